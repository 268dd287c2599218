//! Error of a rate signal: its rotation over 2 s against the reference's, at the common time shift that
//! minimises it.

use nalgebra::{UnitQuaternion, Vector3};

use testbed::{
    score::{RateTrack, seconds_since, trimmed_rms, unit_quaternion},
    trace::Trace,
};

/// Length of a window, microseconds.
const WINDOW_US: u64 = 2_000_000;

/// Distance of the last window from the recording's end, microseconds, so that every shift stays inside.
const MARGIN_US: u64 = 100_000;

/// Largest time shift tried, milliseconds, from 0 on: how far the gyro may lag the reference. Clocks of two
/// instruments never agree to a millisecond.
const LARGEST_SHIFT_MS: u32 = 8;

/// A window, and the reference's rotation over it.
pub(super) struct Window {
    /// Start, seconds since the first sample.
    from_s: f64,
    to_s: f64,
    /// Rotation from the body at the window's end to the body at its start.
    rotation: UnitQuaternion<f64>,
}

/// Windows of 2 s, end to end from `from_us`, in which every sample has a reference and `movement`.
pub(super) fn windows(trace: &Trace, from_us: u64) -> Vec<Window> {
    let (start_us, samples) = (trace.first_us(), &trace.samples);
    let last_us = (start_us + trace.duration_us()).saturating_sub(MARGIN_US);
    let scored = |i: usize| {
        let moves = trace.movement.as_ref().and_then(|movement| movement.get(i)).copied().unwrap_or(false);
        trace.reference.get(i).copied().flatten().filter(|_| moves).and_then(unit_quaternion)
    };
    let window = |at_us: u64| {
        let [first, last] = [at_us, at_us + WINDOW_US].map(|t_us| samples.partition_point(|s| s.t_us < t_us));
        if !(first..=last).all(|i| scored(i).is_some()) {
            return None;
        }
        let [from_s, to_s] = [samples.get(first)?, samples.get(last)?].map(|s| seconds_since(start_us, s.t_us));
        Some(Window { from_s, to_s, rotation: scored(first)?.inverse() * scored(last)? })
    };
    let starts = (0..).map(|index| from_us + index * WINDOW_US).take_while(|at_us| at_us + WINDOW_US < last_us);
    starts.filter_map(window).collect()
}

/// Angle between the track's rotation and the reference's, degrees, rms of the smallest 98 %, at the best
/// shift; `None` if the track covers no window or is not finite.
pub(super) fn error_deg(windows: &[Window], track: &RateTrack) -> Option<f64> {
    let turned = Turned::new(track);
    let at_shift = |shift_ms: u32| {
        let shift_s = 1e-3 * f64::from(shift_ms);
        let error =
            |w: &Window| Some(w.rotation.angle_to(&turned.between(w.from_s + shift_s, w.to_s + shift_s)?).to_degrees());
        let errors: Vec<f64> = windows.iter().filter_map(error).collect();
        // An error that is not finite must not be trimmed away.
        if errors.iter().all(|error| error.is_finite()) { trimmed_rms(errors) } else { None }
    };
    (0..=LARGEST_SHIFT_MS).filter_map(at_shift).reduce(f64::min)
}

/// A track integrated once, so that the rotation between any two times takes two look-ups whatever the shift.
struct Turned<'a> {
    t_s: &'a [f64],
    /// Mean of the two rates at the ends of the step that begins at each point, rad/s.
    mean_rad_s: Vec<Vector3<f64>>,
    /// Rotation from the body at each point to the body at the first.
    rotation: Vec<UnitQuaternion<f64>>,
}

impl<'a> Turned<'a> {
    fn new(track: &'a RateTrack) -> Self {
        let rates = track.rate_rad_s.windows(2);
        let mean_rad_s: Vec<Vector3<f64>> = rates.map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let steps = track.t_s.windows(2).map(|pair| pair[1] - pair[0]);
        let mut rotation = vec![UnitQuaternion::identity()];
        let mut last = UnitQuaternion::identity();
        for (mean, step_s) in mean_rad_s.iter().zip(steps) {
            last *= UnitQuaternion::from_scaled_axis(mean * step_s);
            rotation.push(last);
        }
        Self { t_s: &track.t_s, mean_rad_s, rotation }
    }

    /// Rotation from the body at `to_s` to the body at `from_s`; `None` if the track does not reach.
    fn between(&self, from_s: f64, to_s: f64) -> Option<UnitQuaternion<f64>> {
        Some(self.at(from_s)?.inverse() * self.at(to_s)?)
    }

    /// Within a step the rate is constant, the mean of its ends.
    fn at(&self, t_s: f64) -> Option<UnitQuaternion<f64>> {
        let before = self.t_s.partition_point(|&t| t < t_s).checked_sub(1)?;
        let elapsed_s = t_s - self.t_s.get(before)?;
        Some(self.rotation.get(before)? * UnitQuaternion::from_scaled_axis(self.mean_rad_s.get(before)? * elapsed_s))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use meerkat_mwd::Sample;

    const PERIOD_US: u64 = 4_000;

    /// A minute of rotation about an inclined axis by `angle(t)`, always moving.
    fn turning(angle: impl Fn(f64) -> f64) -> Trace {
        let times: Vec<u64> = (0..15_000).map(|i| 1_000_000 + PERIOD_US * i).collect();
        let attitude = |t_us: u64| {
            let q = UnitQuaternion::from_scaled_axis(axis() * angle(seconds_since(1_000_000, t_us)));
            Some([q.w, q.i, q.j, q.k])
        };
        Trace {
            reference: times.iter().map(|&t_us| attitude(t_us)).collect(),
            movement: Some(vec![true; times.len()]),
            samples: times.iter().map(|&t_us| Sample { t_us, ..Sample::default() }).collect(),
            ..Trace::default()
        }
    }

    fn axis() -> Vector3<f64> {
        Vector3::new(0.6, 0.0, 0.8)
    }

    /// The rate about the axis at times that lag the trace's.
    fn track(trace: &Trace, lag_s: f64, rate: impl Fn(f64) -> f64) -> RateTrack {
        let point = |s: &Sample| {
            let t_s = seconds_since(trace.first_us(), s.t_us);
            (t_s + lag_s, axis() * rate(t_s))
        };
        RateTrack::from_points(trace.samples.iter().map(point))
    }

    #[test]
    fn a_constant_error_of_the_rate_is_twice_as_much_of_angle() {
        let trace = turning(|t_s| 1.5 * t_s);
        let windows = windows(&trace, trace.first_us() + 30_000_000);
        for error_deg_s in [0.0, 0.3, -2.0_f64] {
            // Points between the reference's split steps without a remainder.
            for lag_s in [0.0, 0.001_3] {
                let track = track(&trace, lag_s, |_| 1.5 + error_deg_s.to_radians());
                let found = error_deg(&windows, &track).unwrap();
                assert!((found - 2.0 * error_deg_s.abs()).abs() < 1e-9, "{found} {error_deg_s}");
            }
        }
    }

    #[test]
    fn a_lag_within_8_ms_does_not_count_and_what_is_beyond_it_does() {
        // The rate grows linearly, which trapezoids integrate without an error.
        let (acceleration, trace) = (0.02, turning(|t_s| 0.01 * t_s * t_s));
        let windows = windows(&trace, trace.first_us() + 30_000_000);
        let with_lag = |lag_s: f64| error_deg(&windows, &track(&trace, lag_s, |t_s| acceleration * t_s)).unwrap();
        assert!(with_lag(0.0) < 1e-9);
        assert!(with_lag(0.004) < 1e-9);
        let beyond_deg = (acceleration * 2.0 * (0.016 - 0.008)).to_degrees();
        assert!((with_lag(0.016) - beyond_deg).abs() < 1e-9, "{} {beyond_deg}", with_lag(0.016));
    }

    #[test]
    fn a_window_counts_only_if_all_of_it_moves_and_has_a_reference() {
        let mut trace = turning(|t_s| t_s);
        let from_us = trace.first_us() + 30_000_000;
        // 59.996 s less the margin hold 14 whole windows from 30 s on.
        assert_eq!(windows(&trace, from_us).len(), 14);
        trace.movement.as_mut().unwrap()[7_600] = false;
        trace.reference[8_100] = None;
        let left = windows(&trace, from_us);
        assert_eq!(left.len(), 12);
        assert!((left[0].from_s - 34.0).abs() < 1e-9 && (left[0].to_s - 36.0).abs() < 1e-9);
        trace.movement = None;
        assert!(windows(&trace, from_us).is_empty());
    }

    #[test]
    fn a_track_that_covers_no_window_or_is_not_finite_has_no_error() {
        let trace = turning(|t_s| t_s);
        let windows = windows(&trace, trace.first_us() + 30_000_000);
        assert_eq!(error_deg(&windows, &RateTrack::default()), None);
        assert_eq!(error_deg(&windows, &track(&trace, 0.0, |_| f64::NAN)), None);
        assert_eq!(error_deg(&[], &track(&trace, 0.0, |_| 1.0)), None);
    }
}
