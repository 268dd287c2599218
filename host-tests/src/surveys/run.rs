//! Result of a run once it is worked out: its stations and what was done to them.

use serde::Serialize;

use super::{
    analysis::Analysis,
    reference::{Provenance, ReferenceAt},
    settings::Correction,
};

/// Result for a run.
#[derive(Debug, Serialize)]
pub struct SurveyedRun {
    /// Name of the well.
    pub well: String,
    /// Correction that was asked for.
    pub correction: Correction,
    /// Sag that was added to the inclinations, in words; `None` where none was.
    pub sag: Option<String>,
    /// Origin of the reference.
    pub provenance: Provenance,
    /// Convergence of the grid, degrees; `None` without one: azimuths and positions then count from true north.
    pub convergence_deg: Option<f64>,
    /// Azimuth of the vertical section, degrees.
    pub vertical_section_deg: f64,
    /// Tool codes of the stations, that of the covariances, each once.
    pub tool_codes: Vec<String>,
    /// The multi-station analysis, if one was made.
    pub analysis: Option<Analysis>,
    /// Doubts about the run, a sentence each.
    pub warnings: Vec<String>,
    /// Stations.
    pub stations: Vec<SurveyedStation>,
}

/// Result for one station. Angles are in degrees, lengths in metres.
#[derive(Clone, Debug, Serialize)]
pub struct SurveyedStation {
    /// Measured depth.
    pub md_m: f64,
    /// Reference at this depth.
    pub reference: ReferenceAt,
    /// Model that it comes from.
    pub reference_model: String,
    /// Day that the model was evaluated for.
    pub reference_date: String,
    /// Convergence of the grid; `None` without one.
    pub convergence_deg: Option<f64>,
    /// Mean force, m/s^2, and field, microtesla, tool axes; `None` if the file gave angles.
    pub readings: Option<[[f64; 3]; 2]>,
    /// Inclination and magnetic azimuth as measured.
    pub measured_deg: [f64; 2],
    /// Inclination of the hole, corrected, sag included. Stations at one depth share their mean direction.
    pub inclination_deg: f64,
    /// Its standard deviation; `None` where only angles were read.
    pub sigma_inclination_deg: Option<f64>,
    /// Azimuth from magnetic north, corrected.
    pub magnetic_azimuth_deg: f64,
    /// Its standard deviation.
    pub sigma_magnetic_azimuth_deg: Option<f64>,
    /// Azimuth from the north of positions: grid, or true without a grid.
    pub azimuth_deg: f64,
    /// Its standard deviation, the declination's included.
    pub sigma_azimuth_deg: Option<f64>,
    /// Gravity toolface; `None` where only angles were read.
    pub gravity_toolface_deg: Option<f64>,
    /// Measured less reference |G| m/s^2, |B| microtesla, dip degrees.
    pub off_reference: Option<[f64; 3]>,
    /// Sag that was added to the inclination.
    pub sag_deg: f64,
    /// Correction of the azimuth, or that there was none.
    pub corrected: &'static str,
    /// Tool code.
    pub tool_code: String,
    /// Axial interference by the reference, microtesla, and its standard deviation.
    pub axial_interference_ut: Option<[f64; 2]>,
    /// True in the no-go zone of the short-collar correction.
    pub axial_no_go: Option<bool>,
    /// True if the other stations contradict this one.
    pub doubted: bool,
    /// North, east, true vertical depth.
    pub position_m: [f64; 3],
    /// Bend since the station before, degrees over 30 m.
    pub dogleg_deg_30m: f64,
    /// Distance along the vertical section.
    pub vertical_section_m: f64,
    /// Covariance of the position, row by row: north, east, down; m^2.
    pub covariance_m2: [[f64; 3]; 3],
    /// Half axes of the horizontal ellipse of one standard deviation, and the azimuth of the larger, degrees.
    pub ellipse: [f64; 3],
}

impl SurveyedRun {
    /// Account of the sag in words: how it is known, and what was added.
    #[must_use]
    pub fn sag_told(&self) -> String {
        let Some(how) = &self.sag else { return "none corrected".to_owned() };
        let added = || self.stations.iter().map(|station| station.sag_deg);
        let (least, most) = (added().fold(f64::MAX, f64::min), added().fold(f64::MIN, f64::max));
        format!("{how}; {least:.3} to {most:.3} deg are added to the measured inclinations")
    }
}
