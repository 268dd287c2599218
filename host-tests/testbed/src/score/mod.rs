//! Scores of a flight against the trace's own reference: rotation over 2 s, gravity from rest to rest,
//! attitude, rate.
//!
//! The reference is used here and nowhere else: nothing in this module feeds back into what is flown. All in
//! `f64`.

mod attitude;
mod convention;
mod integrated;
pub mod nees;
mod orientation_2s;
mod rate_error;
mod rates;
mod rest_gravity;
mod time_alignment;

use meerkat_mwd::{
    Config,
    compensation::{GyroModel, VectorModel},
    probe::GAP_PERIODS,
};

pub use attitude::unit_quaternion;
pub use attitude::{
    AttitudeRms, TimedAttitude, attitude_errors_deg, attitude_rms_deg, attitudes_of, reference_attitudes,
};
pub use convention::convention_note;
pub use orientation_2s::trimmed_rms;
pub use rate_error::{rate_error_rad_s, systematic_rate_error_rad_s};
pub use rates::seconds_since;
pub use rates::{RateTrack, Tracks};

use crate::{flight::Flight, trace::Trace};
use integrated::Asked;

/// One figure for each of the four ways to read the gyro; `None` if the trace or the flight does not hold it.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct PerModel {
    /// The raw gyro.
    pub uncompensated: Option<f64>,
    /// The factory's P with each window's bias.
    pub bias_only: Option<f64>,
    /// The 12-parameter fit of each window, accepted or not.
    pub twelve_parameters: Option<f64>,
    /// As flown, with every accepted effect.
    pub with_effects: Option<f64>,
}

/// Scores of a flight against the trace's reference columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Reference {
    /// Rotation over consecutive 2 s windows against the reference's: angle of the difference, degrees, rms
    /// of the smallest 98 %.
    pub orientation_2s_rms_deg: PerModel,
    /// The same with one constant delay per recording taken out of all four gyro readings alike.
    pub orientation_2s_rms_time_aligned_deg: PerModel,
    /// That delay, milliseconds; positive if the gyro lags the reference. `None` if no delay within 20 ms
    /// stands out.
    pub time_alignment_ms: Option<f64>,
    /// Direction of gravity carried by the gyro from each rest to the next, against the accelerometer there:
    /// degrees rms.
    pub rest_gravity_deg: PerModel,
    /// Attitude against the reference in the earth frame, without re-alignment, degrees rms.
    pub attitude_rms_deg: AttitudeRms,
}

/// Settings of the scorer.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Settings {
    /// Start of the scored part, microseconds; 0 scores everything.
    pub from_us: u64,
    /// Accelerometer model, for gravity at rests.
    pub accel: VectorModel,
    /// Gyro model that flew before the first window's result.
    pub factory: GyroModel,
    /// Declination that the flight was configured with, degrees east of true north; with one its attitude
    /// counts from true north.
    pub declination_deg: Option<f64>,
}

impl Settings {
    /// The settings for a flight over `trace` with `config`.
    #[must_use]
    pub fn of(trace: &Trace, config: &Config, flight: &Flight) -> Self {
        Self {
            from_us: flight.frozen_at_us.unwrap_or(trace.first_us()),
            accel: config.accel,
            factory: config.gyro,
            declination_deg: config.earth.declination_rad.map(|x| f64::from(x).to_degrees()),
        }
    }
}

/// Scores a flight over the samples from `settings.from_us` on. `None` if the trace has neither a reference
/// attitude nor rests.
#[must_use]
pub fn score(trace: &Trace, flight: &Flight, settings: &Settings) -> Option<Reference> {
    let facts = trace.facts();
    let (has_reference, has_rests) = (facts.referred > 0, facts.rests > 0);
    if !has_reference && !has_rests {
        return None;
    }
    let legs = if has_rests { rest_gravity::legs(trace, settings) } else { Vec::new() };
    let windows = if has_reference { orientation_2s::windows(trace, settings.from_us) } else { Vec::new() };
    let of_windows = orientation_2s::asked(&windows, time_alignment::RANGE_S);
    let asked = Asked::of(of_windows.chain(rest_gravity::asked(&legs)).collect());
    let gap_s = gap_us(trace) * 1e-6;
    let mut integrated = Tracks::at_validity(trace, flight, &settings.factory, gap_s, &asked);
    let mut scores = Reference::default();
    if has_rests {
        scores.rest_gravity_deg = rest_gravity::rms_deg(&legs, &integrated);
    }
    if has_reference {
        let plain = orientation_2s::errors_deg(&windows, &integrated, 0.0);
        scores.orientation_2s_rms_deg = orientation_2s::rms_deg(&plain, |_| true);

        // Tracks that were not flown have one time only.
        integrated.fly_at_acquisition(trace, flight, gap_s, &asked);
        if let Some(delay_s) = time_alignment::fit(&windows, &integrated) {
            let aligned = orientation_2s::errors_deg(&windows, &integrated, delay_s);
            // Over the same windows, so that the delay alone makes the difference.
            let in_both = |index: usize| [&plain, &aligned].iter().all(|of| matches!(of.get(index), Some(Some(_))));
            scores.orientation_2s_rms_deg = orientation_2s::rms_deg(&plain, in_both);
            scores.orientation_2s_rms_time_aligned_deg = orientation_2s::rms_deg(&aligned, in_both);
            scores.time_alignment_ms = Some(delay_s * 1e3);
        }
        scores.attitude_rms_deg = attitude::rms_deg(trace, flight, settings);
    }
    Some(scores)
}

/// Rotation errors over time, and the reference's delay that was taken out.
pub struct RotationErrors {
    /// Delay as in [`Reference::time_alignment_ms`], taken out of all four readings alike; 0 if none stands out.
    pub delay_ms: f64,
    /// End of each 2 s window, seconds since the trace's first sample, and the angle between the integrated
    /// rotation and the reference's, degrees. Windows that a gap cuts are left out.
    pub deg: Vec<(f64, PerModel)>,
    /// The same windows' errors about x, y and z of the body at the window's end, with their signs.
    pub about_axes_deg: [Vec<(f64, PerModel)>; 3],
}

/// The errors whose root mean square [`Reference::orientation_2s_rms_time_aligned_deg`] is, from
/// `settings.from_us` on.
#[must_use]
pub fn rotation_errors(trace: &Trace, flight: &Flight, settings: &Settings) -> RotationErrors {
    let gap_s = gap_us(trace) * 1e-6;
    let windows = orientation_2s::windows(trace, settings.from_us);
    let asked = Asked::of(orientation_2s::asked(&windows, time_alignment::RANGE_S).collect());
    let mut tracks = Tracks::at_validity(trace, flight, &settings.factory, gap_s, &asked);
    tracks.fly_at_acquisition(trace, flight, gap_s, &asked);
    let delay_s = time_alignment::fit(&windows, &tracks).unwrap_or(0.0);
    let covered = windows.iter().filter(|window| tracks.cover(window.from_s + delay_s, window.to_s + delay_s));
    let covered: Vec<_> = covered.collect();
    let deg = covered.iter().map(|window| (window.to_s, tracks.per_model(|track| window.error_deg(track, delay_s))));
    let about = |axis: usize| {
        let error = |window: &&orientation_2s::Window| {
            (window.to_s, tracks.per_model(|track| window.error_about_deg(track, delay_s, axis)))
        };
        covered.iter().copied().map(|window| error(&window)).collect()
    };
    RotationErrors { delay_ms: 1e3 * delay_s, deg: deg.collect(), about_axes_deg: [about(0), about(1), about(2)] }
}

/// Step in time above which there is a gap, microseconds; no score spans one. Half a microsecond more than
/// whole periods, so that rounding of times makes no gap.
fn gap_us(trace: &Trace) -> f64 {
    f64::from(GAP_PERIODS) * f64::from(trace.nominal_period_us()) + 0.5
}

/// Root mean square; `None` of nothing.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.into_iter().fold((0_usize, 0.0), |(count, sum), x| (count + 1, sum + x * x));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use meerkat_mwd::Sample;
    use nalgebra::Vector3;

    #[test]
    fn a_step_of_exactly_three_periods_is_no_gap_and_one_a_microsecond_longer_is() {
        // Every second stretch of three periods lacks its two samples inside.
        let times: Vec<u64> = (0..3_000_u64).filter(|k| k / 3 % 2 == 0 || k % 3 == 0).map(|k| 3_500 * k).collect();
        let whole = |longer_us: u64| {
            let t_us: Vec<u64> = times.iter().map(|&t| if t > 1_000_000 { t + longer_us } else { t }).collect();
            let samples = t_us.iter().map(|&t_us| Sample { t_us, ..Sample::default() }).collect();
            let trace = Trace { samples, ..Trace::default() };
            assert_eq!(trace.nominal_period_us(), 3_500);
            let t_s: Vec<f64> = t_us.iter().map(|&t| rates::seconds_since(0, t)).collect();
            let (first, last) = (*t_s.first().unwrap(), *t_s.last().unwrap());
            let asked = Asked::of(vec![[first, first], [last, last]]);
            let mut integrator = integrated::Integrator::new(gap_us(&trace) * 1e-6, &asked);
            t_s.iter().for_each(|t_s| integrator.push(*t_s, Vector3::zeros()));
            integrator.ended().rotation(first, last).is_some()
        };
        assert!(whole(0));
        assert!(!whole(1));
    }
}
