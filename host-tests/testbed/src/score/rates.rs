//! Four ways to read the gyro that are compared: raw, bias only, twelve parameters, as flown.

use meerkat_mwd::{SampleFlags, compensation::GyroModel};
use nalgebra::{Matrix3, Vector3};

use super::{
    PerModel,
    integrated::{Asked, Integrated, Integrator},
};
use crate::{flight::Flight, trace::Trace};

/// Body rates over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RateTrack {
    /// Times of validity, seconds since the trace's first sample, strictly increasing.
    pub t_s: Vec<f64>,
    /// Body rate at each of these times, rad/s.
    pub rate_rad_s: Vec<Vector3<f64>>,
}

impl RateTrack {
    /// Makes a track; a point that is not later than the one before is left out.
    pub fn from_points(points: impl IntoIterator<Item = (f64, Vector3<f64>)>) -> Self {
        let mut track = Self::default();
        for (t_s, rate) in points {
            if track.t_s.last().is_none_or(|&last| t_s > last) {
                track.t_s.push(t_s);
                track.rate_rad_s.push(rate);
            }
        }
        track
    }
}

/// One value for each of the four ways to read the gyro.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tracks<T = RateTrack> {
    /// The raw gyro.
    pub uncompensated: T,
    /// The factory's P with each window's bias.
    pub bias_only: T,
    /// The 12-parameter fit of each window.
    pub twelve_parameters: T,
    /// As flown.
    pub with_effects: T,
}

impl<T> Tracks<T> {
    /// Applies a function to each.
    pub fn map<U>(&self, f: impl Fn(&T) -> U) -> Tracks<U> {
        Tracks {
            uncompensated: f(&self.uncompensated),
            bias_only: f(&self.bias_only),
            twelve_parameters: f(&self.twelve_parameters),
            with_effects: f(&self.with_effects),
        }
    }

    /// One figure of each.
    pub(super) fn per_model(&self, f: impl Fn(&T) -> Option<f64>) -> PerModel {
        let Tracks { uncompensated, bias_only, twelve_parameters, with_effects } = self.map(f);
        PerModel { uncompensated, bias_only, twelve_parameters, with_effects }
    }

    /// Returns true if a condition holds for all four.
    pub(super) fn all(&self, f: impl Fn(&T) -> bool) -> bool {
        let Tracks { uncompensated, bias_only, twelve_parameters, with_effects } = self.map(f);
        uncompensated && bias_only && twelve_parameters && with_effects
    }
}

impl Tracks<Integrated> {
    /// Returns true if every non-empty track covers the interval without a gap: the four are compared over the same
    /// intervals.
    pub(super) fn cover(&self, from_s: f64, to_s: f64) -> bool {
        self.uncompensated.rotation(from_s, to_s).is_some()
            && self.all(|track| track.is_empty() || track.rotation(from_s, to_s).is_some())
    }

    /// The four rate tracks of a flight at their times of validity, over the whole trace, integrated.
    ///
    /// Models change with the windows: each applies from its `t_effect_us` on, `factory` before the first;
    /// what flew may have changed between windows too. A window without a model keeps the twelve parameters
    /// as they were. Samples without a gyro reading are left out.
    #[must_use]
    pub(super) fn at_validity(trace: &Trace, flight: &Flight, factory: &GyroModel, gap_s: f64, asked: &Asked) -> Self {
        let start_us = trace.first_us();
        let mut reports: Vec<_> = flight.reports.iter().filter_map(|r| Some((r.t_effect_us?, r))).collect();
        reports.sort_by_key(|&(t_effect_us, _)| t_effect_us);
        let mut reports = reports.into_iter().peekable();
        let (mut bias_only, mut twelve) = (Compensation::new(factory), Compensation::new(factory));
        let [mut first, mut second, mut third, mut flown] = [(); 4].map(|()| Integrator::new(gap_s, asked));
        for sample in trace.samples() {
            while let Some((_, report)) = reports.next_if(|&(t_effect_us, _)| t_effect_us <= sample.t_us) {
                bias_only = Compensation::new(&report.bias_only);
                // A diverged filter may have no valid model.
                if report.fitted.is_valid() {
                    twelve = Compensation::new(&report.fitted);
                }
            }
            if sample.flags.contains(SampleFlags::GYRO_MISSING) {
                continue;
            }
            let t_s = seconds_since(start_us, sample.t_us);
            let raw = Vector3::from(sample.gyro_rad_s.map(f64::from));
            first.push(t_s, raw);
            second.push(t_s, bias_only.rate(&raw));
            third.push(t_s, twelve.rate(&raw));
        }
        flight.outputs().for_each(|o| flown.push(seconds_since(start_us, o.t_us), flown_rate(o.rate_rad_s)));
        Self {
            uncompensated: first.ended(),
            bias_only: second.ended(),
            twelve_parameters: third.ended(),
            with_effects: flown.ended(),
        }
    }

    /// Puts what was flown at the times at which the gyro was read: a lag that the flight removed is put back, so that
    /// one delay can be taken out of all four tracks alike. Nothing changes if outputs and samples do not pair up: then
    /// only the times of validity are known.
    pub(super) fn fly_at_acquisition(&mut self, trace: &Trace, flight: &Flight, gap_s: f64, asked: &Asked) {
        let are_paired = flight.output_count() + flight.refused.len() == trace.len();
        let paired = || trace.samples().zip(flight.by_sample()).filter_map(|(sample, output)| Some((sample, output?)));
        let mut times = paired().map(|(sample, output)| [sample.t_us, output.t_us]);
        // Without a lag it is there already.
        if !are_paired || times.all(|[sample_us, output_us]| sample_us == output_us) {
            return;
        }
        // Before the other is made: of ten hours each takes eight megabytes.
        self.with_effects = Integrator::new(gap_s, asked).ended();
        let (start_us, mut flown) = (trace.first_us(), Integrator::new(gap_s, asked));
        paired().for_each(|(sample, o)| flown.push(seconds_since(start_us, sample.t_us), flown_rate(o.rate_rad_s)));
        self.with_effects = flown.ended();
    }
}

/// Seconds since `start_us`, negative before it. Subtracts integers, because absolute times may be Unix
/// times.
pub fn seconds_since(start_us: u64, t_us: u64) -> f64 {
    t_us.wrapping_sub(start_us).cast_signed() as f64 * 1e-6
}

fn flown_rate(rate_rad_s: [f32; 3]) -> Vector3<f64> {
    Vector3::from(rate_rad_s.map(f64::from))
}

/// A gyro model in double precision: `w = P (w_raw - b)`.
pub(super) struct Compensation {
    pub(super) p: Matrix3<f64>,
    pub(super) b_rad_s: Vector3<f64>,
}

impl Compensation {
    pub(super) fn new(model: &GyroModel) -> Self {
        Self { p: model.p_matrix().map(f64::from), b_rad_s: Vector3::from(model.b_rad_s.map(f64::from)) }
    }

    pub(super) fn rate(&self, raw_rad_s: &Vector3<f64>) -> Vector3<f64> {
        self.p * (raw_rad_s - self.b_rad_s)
    }
}
