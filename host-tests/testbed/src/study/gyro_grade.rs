//! Two grades of gyro to drill with.

use meerkat_mwd::Config;

use crate::simulate::Scenario;

/// Grade of a gyro: how steady its bias is.
///
/// With white noise of density N and a bias that walks K the Allan variance is N^2 / t + K^2 t / 3 (IEEE Std
/// 952, annex C), and the least Allan deviation, which data sheets give as in-run bias stability, sqrt(2 N K
/// / sqrt(3)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroGrade {
    /// The grade that scenarios have and the configuration assumes, temperature included: 12 deg/h.
    Default,
    /// A grade of 3 deg/h, stated in the configuration.
    Steady,
}

impl GyroGrade {
    /// Both, in the order of their cost.
    pub const BOTH: [Self; 2] = [Self::Default, Self::Steady];

    /// Noise density, deg/s per root hertz, and walk of the bias, deg/s per root second.
    const STEADY: (f64, f64) = (0.005, 1.2e-4);

    /// Name for the title of a table.
    pub const fn told(self) -> &'static str {
        match self {
            Self::Default => {
                "gyro of 0.01 deg/s/rtHz whose bias walks 0.001 deg/s per root second, least Allan deviation 12 deg/h"
            }
            Self::Steady => {
                "gyro of 0.005 deg/s/rtHz whose bias walks 0.00012 deg/s per root second, least Allan deviation 3 deg/h"
            }
        }
    }

    /// Puts a gyro of this grade into the scenario.
    pub fn build_in(self, scenario: &mut Scenario) {
        if self == Self::Steady {
            (scenario.gyro.noise_deg_s_rthz, scenario.gyro.bias_walk_deg_s_rts) = Self::STEADY;
        }
    }

    /// States this grade in the configuration.
    pub fn declare(self, config: &mut Config) {
        if self == Self::Steady {
            config.attitude.gyro_noise_rad_s_rthz = Self::STEADY.0.to_radians() as f32;
            config.attitude.gyro_bias_walk_rad_s_rts = Self::STEADY.1.to_radians() as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::study::one_window::scenario;

    /// The least Allan deviations of both grades are as the tables' titles say.
    #[test]
    fn the_least_allan_deviation_is_the_one_that_is_told() {
        for (grade, expected_deg_h) in GyroGrade::BOTH.into_iter().zip([12.0, 3.0]) {
            for name in ["drilling_vertical", "drilling_45deg"] {
                let mut scenario = scenario(name).unwrap();
                grade.build_in(&mut scenario);
                let (noise, walk) = (scenario.gyro.noise_deg_s_rthz, scenario.gyro.bias_walk_deg_s_rts);
                assert!(
                    grade.told().contains(&format!("{noise} deg/s/rtHz"))
                        && grade.told().contains(&format!("{walk} deg/s per"))
                );
                // over all averaging times
                let least = (1..10_000).map(|t| noise * noise / f64::from(t) + walk * walk * f64::from(t) / 3.0);
                let least_deg_h = 3600.0 * least.fold(f64::INFINITY, f64::min).sqrt();
                assert!((least_deg_h / expected_deg_h - 1.0).abs() < 0.03, "{least_deg_h}");
            }
        }
    }
}
