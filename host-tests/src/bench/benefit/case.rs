//! One recording with one gyro error multiplied in: how much of the way from bias only to attainable is
//! flown.

use std::path::Path;

use anyhow::Context;
use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::{GyroModel, effects::LIBRARY},
    estimator::Settings,
};
use nalgebra::{Matrix3, Vector3};

use super::{
    HOLD_OUT,
    least_over_shifts::{Window, error_deg, windows},
    middle,
    troubled::Trouble,
};
use crate::{
    bench::error_multiplied_in::drawn,
    diagnosis::{against_reference, has_dense_reference},
};
use testbed::{
    flight::{
        configuration::{freeze_at_us, of_trace},
        estimate::posterior,
        fly_frozen,
    },
    score::{
        RateTrack,
        nees::{Covariance, covariance, covariance_of, normalised},
        seconds_since,
    },
    simulate::known_error,
    trace::{Trace, recordings::name},
};

/// Samples at rest below which a median is no bias.
const REST_SAMPLES: usize = 50;

/// Attainable gain below which no share is computed, degrees: the reference resolves little better.
const TO_BE_HAD_DEG: f64 = 0.2;

/// Harm: flown error beyond this factor of bias only plus this many degrees.
const HARM: (f64, f64) = (1.05, 0.02);

/// A recording with a reference attitude, and the windows that are scored.
pub(super) struct Recording {
    pub(super) name: String,
    trace: Trace,
    windows: Vec<Window>,
    /// Error of the recorded rate less its bias, before an error is multiplied in.
    attainable_deg: f64,
    /// P of the gyro as recorded, by the reference; `None` if that does not show it.
    own: Option<OwnP>,
}

/// P of a recording's gyro before an error is multiplied in, and how well the reference tells it.
struct OwnP {
    p: Matrix3<f64>,
    covariance: Covariance,
}

impl OwnP {
    /// From the whole recording, with gravity and field computed from the reference.
    fn of(trace: &Trace) -> anyhow::Result<Option<Self>> {
        if !has_dense_reference(trace) {
            return Ok(None);
        }
        let (flight, ..) = against_reference(trace, &of_trace(trace), None)?;
        let window = flight.reports.iter().rev().find(|report| report.t_effect_us.is_some());
        Ok(window.map(|window| Self { p: window.fitted.p_matrix().map(f64::from), covariance: covariance(window) }))
    }
}

impl Recording {
    /// Reads a recording; `None` if it has no reference, no `movement`, or no window that can be scored.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn read(path: &Path) -> anyhow::Result<Option<Self>> {
        let trace = Trace::read(path)?;
        let windows = windows(&trace, freeze_at_us(&trace, HOLD_OUT));
        let attainable_deg = error_deg(&windows, &less_bias(&trace, freeze_at_us(&trace, HOLD_OUT), trace.first_us()));
        let Some(attainable_deg) = attainable_deg else { return Ok(None) };
        let own = OwnP::of(&trace)?;
        Ok(Some(Self { name: name(path), trace, windows, attainable_deg, own }))
    }

    /// Puts a trouble into the first half, multiplies an error in and flies: identification in the first
    /// half, frozen in the second.
    ///
    /// # Errors
    /// The recording cannot be flown.
    pub(super) fn fly_with(&self, trouble: Trouble, scale: f64, draw: u64) -> anyhow::Result<Case> {
        self.fly(trouble.of(&self.trace), freeze_at_us(&self.trace, HOLD_OUT), scale, draw)
    }

    /// Flies with an error multiplied in, frozen after so many seconds of motion; `None` if the first half has fewer.
    ///
    /// # Errors
    /// The recording cannot be flown.
    pub(super) fn fly_until(&self, motion_s: f64, scale: f64, draw: u64) -> anyhow::Result<Option<Case>> {
        let moves = self.trace.movement.iter().flatten();
        let mut moving = self.trace.samples.iter().zip(moves).filter(|(_, moves)| **moves);
        let reached = moving.nth((motion_s * 1e6 / f64::from(self.trace.nominal_period_us())) as usize);
        let half_us = freeze_at_us(&self.trace, HOLD_OUT);
        let Some((sample, _)) = reached.filter(|(sample, _)| sample.t_us < half_us) else { return Ok(None) };
        self.fly(self.trace.clone(), sample.t_us, scale, draw).map(Some)
    }

    fn fly(&self, mut trace: Trace, freeze_us: u64, scale: f64, draw: u64) -> anyhow::Result<Case> {
        let truth = drawn(&self.name, draw, scale);
        known_error::apply(&mut trace, &truth);
        let config = of_trace(&trace);
        trace.mark_clipped(&config.full_scale);
        let flight = fly_frozen(&config, freeze_us, &trace.samples)?;

        let outputs = flight.outputs.iter().map(|o| (self.seconds(o.t_us), rate(o.rate_rad_s)));
        let flown = RateTrack::from_points(outputs);
        let window = flight.reports.iter().rev().find(|report| report.t_effect_us.is_some());
        Ok(Case {
            scale,
            draw,
            errors: self.errors(&trace, &flown)?,
            p_flies: flight.reports.last().is_some_and(|report| report.flown.p != config.gyro.p),
            nees: window.and_then(|window| self.nees(&window.fitted, &covariance(window), &truth)),
        })
    }

    /// Multiplies an error in and runs the estimator alone over the first half, its covariance inflated by `factor`
    /// times what is built in.
    ///
    /// # Errors
    /// The recording cannot be scored.
    pub(super) fn estimate_with(&self, factor: f32, scale: f64, draw: u64) -> anyhow::Result<Case> {
        let truth = drawn(&self.name, draw, scale);
        let mut trace = self.trace.clone();
        known_error::apply(&mut trace, &truth);
        let config = of_trace(&trace);
        trace.mark_clipped(&config.full_scale);
        let mut settings = Settings::new(&config);
        settings.widths.inflations = settings.widths.inflations.map(|inflation| factor * inflation);
        let half_us = freeze_at_us(&self.trace, HOLD_OUT);
        let first_half = trace.samples.iter().take_while(|sample| sample.t_us < half_us).copied();
        let posterior = posterior::<f32>(&settings, &LIBRARY, first_half).context("no posterior")?;
        let model = if posterior.fitness.is_ok() { posterior.gyro } else { posterior.bias_only };
        let point = |s: &Sample| (self.seconds(s.t_us), model.compensate(s.gyro_rad_s).cast());
        let flown = RateTrack::from_points(trace.samples.iter().filter(|s| is_read(s)).map(point));
        Ok(Case {
            scale,
            draw,
            errors: self.errors(&trace, &flown)?,
            p_flies: posterior.fitness.is_ok(),
            nees: self.nees(&posterior.gyro, &covariance_of(&posterior), &truth),
        })
    }

    /// Seconds from the start of the recording, before any trouble.
    fn seconds(&self, t_us: u64) -> f64 {
        seconds_since(self.trace.first_us(), t_us)
    }

    fn errors(&self, trace: &Trace, flown: &RateTrack) -> anyhow::Result<Errors> {
        let error =
            |track: &RateTrack| error_deg(&self.windows, track).with_context(|| format!("{}: no rate", self.name));
        let half_us = freeze_at_us(&self.trace, HOLD_OUT);
        Ok(Errors {
            bias_only_deg: error(&less_bias(trace, half_us, self.trace.first_us()))?,
            flown_deg: error(flown)?,
            attainable_deg: self.attainable_deg,
        })
    }

    /// NEES / 9 of an estimate, against the error that was multiplied in and the recording's own P behind it, which is
    /// as uncertain as the reference leaves it.
    fn nees(&self, estimate: &GyroModel, covariance: &Covariance, multiplied_in: &GyroModel) -> Option<f64> {
        let own = self.own.as_ref()?;
        // The error's P gives the recorded rate from the spoilt one, and the recording's own P the true rate from that.
        let truth = own.p * multiplied_in.p_matrix().map(f64::from);
        let row_major = std::array::from_fn(|k| truth[(k / 3, k % 3)]);
        normalised(estimate.p.as_flattened(), &(covariance + own.covariance), &row_major)
    }
}

fn is_read(sample: &Sample) -> bool {
    !sample.flags.contains(SampleFlags::GYRO_MISSING)
}

/// The raw rate less its median at rest in the first half; unchanged if there is hardly any rest.
fn less_bias(trace: &Trace, half_us: u64, start_us: u64) -> RateTrack {
    let moves = trace.movement.iter().flatten();
    let at_rest = trace.samples.iter().zip(moves).filter(|(s, moves)| !**moves && s.t_us < half_us && is_read(s));
    let at_rest: Vec<[f32; 3]> = at_rest.map(|(s, _)| s.gyro_rad_s).collect();
    let bias = if at_rest.len() > REST_SAMPLES {
        let median = |axis: usize| middle(&at_rest.iter().map(|rate| f64::from(rate[axis])).collect::<Vec<f64>>());
        Vector3::from_fn(|axis, _| median(axis))
    } else {
        Vector3::zeros()
    };
    let point = |s: &Sample| (seconds_since(start_us, s.t_us), rate(s.gyro_rad_s) - bias);
    RateTrack::from_points(trace.samples.iter().filter(|s| is_read(s)).map(point))
}

fn rate(rad_s: [f32; 3]) -> Vector3<f64> {
    Vector3::from(rad_s.map(f64::from))
}

/// Result of one error in one recording.
pub(super) struct Case {
    pub(super) scale: f64,
    pub(super) draw: u64,
    pub(super) errors: Errors,
    /// True if the last window left a P other than the factory's.
    pub(super) p_flies: bool,
    /// NEES / 9 of P.
    pub(super) nees: Option<f64>,
}

/// Errors of the rotation over 2 s in the second half, degrees.
#[derive(Clone, Copy)]
pub(super) struct Errors {
    /// Error of the raw rate less its bias.
    pub(super) bias_only_deg: f64,
    /// Error as flown.
    pub(super) flown_deg: f64,
    /// Error of the rate before the error was multiplied in, less its bias.
    pub(super) attainable_deg: f64,
}

impl Errors {
    /// Share of the way from bias only to attainable, -1 to 1; `None` if too little is attainable.
    pub(super) fn share(&self) -> Option<f64> {
        let to_be_had_deg = self.bias_only_deg - self.attainable_deg;
        (to_be_had_deg > TO_BE_HAD_DEG)
            .then(|| ((self.bias_only_deg - self.flown_deg) / to_be_had_deg).clamp(-1.0, 1.0))
    }

    /// Returns true if the factory's P would have been clearly better.
    pub(super) fn harmed(&self) -> bool {
        let (factor, more_deg) = HARM;
        self.flown_deg > factor * self.bias_only_deg + more_deg
    }

    /// Flown over bias only.
    pub(super) fn ratio(&self) -> f64 {
        self.flown_deg / self.bias_only_deg
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn errors(bias_only_deg: f64, flown_deg: f64, attainable_deg: f64) -> Errors {
        Errors { bias_only_deg, flown_deg, attainable_deg }
    }

    #[test]
    fn the_share_goes_from_minus_1_to_1_and_is_missing_where_too_little_is_to_be_had() {
        assert_eq!(errors(4.0, 1.0, 1.0).share(), Some(1.0));
        assert_eq!(errors(4.0, 4.0, 1.0).share(), Some(0.0));
        assert_eq!(errors(4.0, 2.5, 1.0).share(), Some(0.5));
        assert_eq!(errors(4.0, 0.5, 1.0).share(), Some(1.0));
        assert_eq!(errors(4.0, 9.0, 1.0).share(), Some(-1.0));
        assert_eq!(errors(0.2, 0.1, 0.0).share(), None);
        assert_eq!(errors(0.201, 0.0, 0.0).share(), Some(1.0));
        assert_eq!(errors(1.0, 0.5, 2.0).share(), None);
    }

    #[test]
    fn harm_is_a_twentieth_and_a_fiftieth_of_a_degree_more_than_bias_only() {
        assert!(!errors(1.0, 1.07, 0.5).harmed());
        assert!(errors(1.0, 1.071, 0.5).harmed());
        assert!(!errors(0.0, 0.02, 0.0).harmed());
        assert!(errors(0.0, 0.021, 0.0).harmed());
    }

    /// 101 samples: what moves, is of the second half or was not read does not count.
    #[test]
    fn the_bias_is_the_median_at_rest_in_the_first_half() {
        let sample =
            |i: u64, rate: f32| Sample { t_us: 10_000 * i, gyro_rad_s: [rate, 0.0, -rate], ..Sample::default() };
        let with = |at_rest: u64| {
            let samples = (0..=200).map(|i| sample(i, if i < at_rest { 0.25 } else { 7.0 })).collect();
            let movement = Some((0..=200).map(|i| (at_rest..150).contains(&i)).collect());
            let mut trace = Trace { samples, movement, ..Trace::default() };
            trace.samples[3].flags = SampleFlags::GYRO_MISSING;
            less_bias(&trace, freeze_at_us(&trace, HOLD_OUT), trace.first_us())
        };
        let rested = with(52);
        assert_eq!(rested.rate_rad_s.len(), 200);
        assert_eq!(*rested.rate_rad_s.first().unwrap(), Vector3::zeros());
        assert_eq!(*rested.rate_rad_s.last().unwrap(), Vector3::new(6.75, 0.0, -6.75));
        assert_eq!(*with(51).rate_rad_s.first().unwrap(), Vector3::new(0.25, 0.0, -0.25));
    }
}
