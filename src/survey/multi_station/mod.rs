//! Multi-station analysis: the sensors' errors that several stations of one run determine together, and azimuths and
//! inclinations corrected for these errors.
//!
//! At a station the accelerometer and the magnetometer read six numbers, and the attitude takes three. The other three,
//! |G|, |B| and dip, are known from a reference, so every station gives three equations for the errors of the sensors.
//! These errors stay the same from station to station while the attitude changes; that separates them. The method is
//! that of E. Nyrnes, T. Torkildsen and H. Wilson, SPE/IADC 125677 (2009), and of the ISCWSA's Introduction to wellbore
//! positioning, 14.1, with one difference: no error is left out of the estimate. Each has the ISCWSA MWD error model's
//! size as its prior ([`crate::config::SurveyErrors`]), so an error that the stations do not determine keeps the
//! prior's width, and is named ([`Estimate::observable`]).
//!
//! A roll test (several toolfaces at one depth) and a cluster shot (several surveys at nearly one attitude) are
//! stations like others.

mod decision;
mod fit;
mod left_out;
mod parameters;
mod report;
mod rows;
mod settings;
mod station;

pub use decision::{Decision, Refusal};
pub use parameters::{PARAMETERS, Parameter};
pub use report::{CorrectedStation, Estimate, MultiStationReport};
pub use settings::MultiStationSettings;
pub use station::{Station, StationReference};

use crate::config::SurveyErrors;
use heapless::Vec;

/// Largest number of stations in one analysis.
pub const MAX_STATIONS: usize = 64;
/// Smallest number of stations in one analysis: each station is predicted by the others, and two others are the fewest
/// that can contradict each other.
pub const LEAST_STATIONS: usize = 3;

/// Stations of one run of one tool, in the order in which they were taken.
#[derive(Clone, Debug, Default)]
pub struct MultiStation {
    stations: Vec<Station, MAX_STATIONS>,
}

impl MultiStation {
    /// Creates an analysis without stations.
    #[must_use]
    pub const fn new() -> Self {
        Self { stations: Vec::new() }
    }

    /// Adds a station.
    ///
    /// # Errors
    /// Hands the station back if there are [`MAX_STATIONS`] already, or if it holds no usable gravity and field.
    pub fn push(&mut self, station: Station) -> Result<(), Station> {
        if station.is_usable() { self.stations.push(station) } else { Err(station) }
    }

    /// Stations so far.
    #[must_use]
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Drops all stations, for another tool or bottom-hole assembly.
    pub fn clear(&mut self) {
        self.stations.clear();
    }

    /// Estimates the errors that the stations have in common, and decides whether to correct. `None` with fewer
    /// than [`LEAST_STATIONS`] stations, or if a prior or a noise is not positive.
    #[must_use]
    pub fn analyse(&self, errors: &SurveyErrors, settings: &MultiStationSettings) -> Option<MultiStationReport> {
        report::analysed(&self.stations, errors, settings)
    }
}

#[cfg(test)]
mod tests;
