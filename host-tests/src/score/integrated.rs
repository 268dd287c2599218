use nalgebra::{UnitQuaternion, Vector3};

use super::{RateTrack, Tracks};

/// Rotation integrated from a rate track, between any two times that it covers without a gap.
///
/// Between readings the rate is taken to change linearly. The rotation vector of a step is its mean rate
/// times its length and the coning term of a linear rate, so what is left is the chord: a rate that swings at
/// w rad/s keeps 1 - (w dt)^2 / 12 of itself. At 1 Hz and 100 Hz sampling that is 3 parts in 10,000.
pub(super) struct Integrated {
    track: RateTrack,
    /// Rotation from the body at each reading to the body at the first reading of its run.
    rotation: Vec<UnitQuaternion<f64>>,
    /// Number of the gap-free run that each reading belongs to.
    run: Vec<u32>,
}

impl Integrated {
    /// Integrates a track; steps longer than `gap_s` begin a new run.
    pub(super) fn new(track: &RateTrack, gap_s: f64) -> Self {
        let mut rotation = Vec::with_capacity(track.t_s.len());
        let mut run = Vec::with_capacity(track.t_s.len());
        let mut previous: Option<(f64, Vector3<f64>, UnitQuaternion<f64>, u32)> = None;
        for (&t_s, &rate) in track.t_s.iter().zip(&track.rate_rad_s) {
            let (q, run_index) = match previous {
                None => (UnitQuaternion::identity(), 0),
                Some((last_s, _, q, run_index)) if t_s - last_s > gap_s => (q, run_index + 1),
                Some((last_s, last_rate, q, run_index)) => (q * step(&last_rate, &rate, t_s - last_s), run_index),
            };
            rotation.push(q);
            run.push(run_index);
            previous = Some((t_s, rate, q, run_index));
        }
        Self { track: track.clone(), rotation, run }
    }

    /// Rotation from the body at `to_s` to the body at `from_s`; `None` if the track does not reach or a gap
    /// lies between.
    pub(super) fn rotation(&self, from_s: f64, to_s: f64) -> Option<UnitQuaternion<f64>> {
        let (from, from_run) = self.at(from_s)?;
        let (to, to_run) = self.at(to_s)?;
        (from_run == to_run).then(|| from.inverse() * to)
    }

    /// Whether there is no reading at all.
    pub(super) fn is_empty(&self) -> bool {
        self.rotation.is_empty()
    }

    fn at(&self, t_s: f64) -> Option<(UnitQuaternion<f64>, u32)> {
        let times = &self.track.t_s;
        // Times come from whole microseconds: a tenth of one is rounding.
        let after = times.partition_point(|&t| t <= t_s + 1e-7);
        let i = after.checked_sub(1)?;
        let (q, run) = (*self.rotation.get(i)?, *self.run.get(i)?);
        let elapsed_s = t_s - times.get(i)?;
        if elapsed_s <= 1e-7 {
            return Some((q, run));
        }
        let rate = self.track.rate_rad_s.get(i)?;
        let next_rate = self.track.rate_rad_s.get(after)?;
        let step_s = times.get(after)? - times.get(i)?;
        let rate_there = rate + (next_rate - rate) * (elapsed_s / step_s);
        (*self.run.get(after)? == run).then(|| (q * step(rate, &rate_there, elapsed_s), run))
    }
}

impl Tracks<Integrated> {
    /// Whether every non-empty track covers the interval without a gap: the four are compared over the same
    /// intervals.
    pub(super) fn cover(&self, from_s: f64, to_s: f64) -> bool {
        self.uncompensated.rotation(from_s, to_s).is_some()
            && self.all(|track| track.is_empty() || track.rotation(from_s, to_s).is_some())
    }
}

/// Rotation over `dt_s` under a rate that changes linearly from `start` to `end`, rad/s.
fn step(start: &Vector3<f64>, end: &Vector3<f64>, dt_s: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis((start + end) * (0.5 * dt_s) + start.cross(end) * (dt_s * dt_s / 12.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Classical coning: the body axis z describes a cone of half angle `a` at `f` Hz; its rate is known in
    /// closed form.
    fn coning_error(rate_hz: f64) -> f64 {
        let (a, w) = (0.1_f64, 2.0 * std::f64::consts::PI);
        let attitude = |t: f64| {
            let axis = Vector3::new((w * t).cos(), (w * t).sin(), 0.0);
            UnitQuaternion::from_scaled_axis(axis * a)
        };
        let rate = |t: f64| {
            Vector3::new(-a.sin() * (w * t).sin(), a.sin() * (w * t).cos(), -2.0 * (a / 2.0).sin().powi(2)) * w
        };
        let count = (10.0 * rate_hz) as usize;
        let t_s: Vec<f64> = (0..=count).map(|i| i as f64 / rate_hz).collect();
        let track = RateTrack { rate_rad_s: t_s.iter().map(|&t| rate(t)).collect(), t_s };
        let rotation = Integrated::new(&track, 1.0).rotation(0.0, 10.0).unwrap();
        (attitude(0.0).inverse() * attitude(10.0)).angle_to(&rotation)
    }

    #[test]
    fn coning_errs_by_the_chord_alone_and_so_with_the_square_of_the_step() {
        // The swing's amplitude loses (w dt)^2 / 12 to the chord, the drift a^2 w / 2 that it makes twice
        // that.
        let w_dt = 2.0 * std::f64::consts::PI / 100.0;
        let chord = (w_dt * w_dt / 12.0) * 0.1 * 0.1 * 2.0 * std::f64::consts::PI * 10.0;
        assert!((coning_error(100.0) / chord - 1.0).abs() < 0.02, "{} {chord}", coning_error(100.0));
        assert!((coning_error(100.0) / coning_error(200.0) - 4.0).abs() < 0.1);
    }

    #[test]
    fn an_instant_between_readings_splits_a_rotation_without_a_remainder() {
        let track = RateTrack {
            t_s: vec![0.0, 0.01, 0.02, 0.03],
            rate_rad_s: [1.0, 3.0, -2.0, 4.0].map(|z| Vector3::new(0.0, 0.0, z)).to_vec(),
        };
        let whole = Integrated::new(&track, 1.0);
        let parts = whole.rotation(0.0, 0.0137).unwrap() * whole.rotation(0.0137, 0.03).unwrap();
        assert!(parts.angle_to(&whole.rotation(0.0, 0.03).unwrap()) < 1e-12);
        // Trapezoids: 0.02 + 0.005 + 0.01 rad.
        assert!((whole.rotation(0.0, 0.03).unwrap().angle() - 0.035).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_integrated_across_a_gap_or_beyond_the_ends() {
        let track =
            RateTrack { t_s: vec![0.0, 0.01, 0.02, 0.12, 0.13], rate_rad_s: vec![Vector3::new(1.0, 0.0, 0.0); 5] };
        let integrated = Integrated::new(&track, 0.03);
        assert!(integrated.rotation(0.0, 0.02).is_some());
        assert!(integrated.rotation(0.01, 0.12).is_none());
        assert!(integrated.rotation(0.01, 0.05).is_none());
        assert!(integrated.rotation(0.12, 0.14).is_none());
        assert!(integrated.rotation(-0.01, 0.01).is_none());
    }
}
