//! Coverage of the stated deviations of the attitude: how often the error is within them.

use std::collections::HashMap;

use meerkat_mwd::attitude::{Attitude, AttitudeFlags};

use testbed::{
    flight::Flight,
    score::{Settings, reference_attitudes},
    trace::Trace,
};

/// Coverage of one angle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Angle {
    /// Attitudes that were scored.
    pub count: usize,
    /// Those within one deviation, and within two.
    pub within: [usize; 2],
    /// Sum of the squared errors, each in its deviation.
    pub squares: f64,
    /// Longest stretch over three deviations, seconds.
    pub longest_s: f64,
    /// Start of the stretch that goes on, microseconds.
    since_us: Option<u64>,
}

/// Coverage of inclination and azimuth, in this order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coverage {
    pub angles: [Angle; 2],
}

impl Coverage {
    /// Scores the attitudes of a flight at whose time there is a reference in motion; the azimuth where it exists.
    pub(super) fn of(trace: &Trace, flight: &Flight) -> Self {
        let moves: HashMap<u64, bool> = trace.rows().map(|row| (row.sample.t_us, row.moves)).collect();
        let outputs: HashMap<u64, Attitude> =
            flight.outputs().filter_map(|output| Some((output.t_us, output.attitude?))).collect();
        let mut coverage = Self::default();
        for (t_us, reference) in reference_attitudes(trace, &Settings::default()) {
            let Some(attitude) = outputs.get(&t_us).filter(|_| moves.get(&t_us) == Some(&true)) else { continue };
            let c = reference.to_rotation_matrix();
            let horizontal = c[(0, 2)].hypot(c[(1, 2)]);
            let apart = |found: f32, truth: f64| libm::remainder(f64::from(found) - truth, std::f64::consts::TAU).abs();
            let [inclination, azimuth] = &mut coverage.angles;
            inclination.take(
                t_us,
                apart(attitude.inclination_rad, horizontal.atan2(c[(2, 2)])),
                attitude.sigma_inclination_rad,
            );
            if !attitude.flags.intersects(AttitudeFlags::NO_HEADING | AttitudeFlags::NEAR_VERTICAL) {
                azimuth.take(t_us, apart(attitude.azimuth_rad, c[(1, 2)].atan2(c[(0, 2)])), attitude.sigma_azimuth_rad);
            }
        }
        coverage
    }

    /// The coverage of both together.
    pub(super) fn with(mut self, other: &Self) -> Self {
        for (sum, one) in self.angles.iter_mut().zip(&other.angles) {
            sum.count += one.count;
            sum.squares += one.squares;
            sum.within.iter_mut().zip(one.within).for_each(|(sum, count)| *sum += count);
            sum.longest_s = sum.longest_s.max(one.longest_s);
        }
        self
    }
}

impl Angle {
    fn take(&mut self, t_us: u64, error_rad: f64, sigma_rad: f32) {
        let sigmas = error_rad / f64::from(sigma_rad);
        self.count += 1;
        self.squares += sigmas * sigmas;
        for (within, limit) in self.within.iter_mut().zip([1.0, 2.0]) {
            *within += usize::from(sigmas <= limit);
        }
        if sigmas > 3.0 {
            let since_us = *self.since_us.get_or_insert(t_us);
            self.longest_s = self.longest_s.max((t_us - since_us) as f64 * 1e-6);
        } else {
            self.since_us = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_counted_in_their_deviations_and_a_stretch_ends_with_the_first_good_one() {
        let mut angle = Angle::default();
        for (second, error) in [0.5, 1.5, 3.5, 4.0, 3.1, 0.1, 5.0].into_iter().enumerate() {
            angle.take(second as u64 * 1_000_000, error * 0.02, 0.02);
        }
        assert_eq!((angle.count, angle.within), (7, [2, 3]));
        assert!((angle.squares - 65.37).abs() < 1e-4, "{}", angle.squares);
        assert!((angle.longest_s - 2.0).abs() < 1e-9);
    }
}
