//! Acceleration while drilling, beside gravity: broadband vibration, chatter of the bit, shocks.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{
    drilling::Motion,
    random::Random,
    scenario::{Scenario, ShockSettings},
};

/// Standard gravity, m/s^2: the unit of shocks and full scales.
pub(super) const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Broadband noise above a corner frequency, sample by sample: white noise x of deviation 1 less its own
/// first-order low-pass, `y = scale (x - low)`, `low += smoothing (x - low)` with the same x in both.
#[derive(Clone, Copy, Debug)]
pub struct HighPassed {
    /// Scale of the noise, m/s^2, tool axes.
    pub scale_m_s2: Vector3<f64>,
    /// Share of the way to x that the low-pass goes in one sample.
    pub smoothing: f64,
}

impl HighPassed {
    /// The noise of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let vibration = &scenario.vibration;
        let period_s = f64::from(scenario.sample_period_us) * 1e-6;
        let smoothing = 1.0 - libm::exp(-TAU * vibration.lowest_hz * period_s);
        // y = (1 - s)(x - low), and low has s / (2 - s) of x's variance: so y has 2 (1 - s)^2 / (2 - s) of
        // it.
        let kept = (1.0 - smoothing) * libm::sqrt(2.0 / (2.0 - smoothing));
        let rms = Vector3::new(vibration.lateral_m_s2, vibration.lateral_m_s2, vibration.axial_m_s2);
        Self { scale_m_s2: rms / kept, smoothing }
    }

    /// Deviation of white noise whose mean over `samples` is as large as this noise's.
    #[must_use]
    pub fn white_m_s2(&self, samples: u32) -> Vector3<f64> {
        // low' - low = s (x - low), so the sum of y is the low-pass's change over s. Its values at both ends
        // have s / (2 - s) of x's variance and the correlation (1 - s)^n.
        let (s, n) = (self.smoothing, f64::from(samples));
        let sum = 2.0 * s / (2.0 - s) * (1.0 - libm::pow(1.0 - s, n)) / (s * s);
        // y uses the low-pass with x already in it: (1 - s) of x minus the low-pass before.
        self.scale_m_s2 * ((1.0 - s) * libm::sqrt(sum / n))
    }
}

/// The broadband vibration of a run.
pub(super) struct Broadband {
    shape: HighPassed,
    low: Vector3<f64>,
}

impl Broadband {
    pub(super) fn new(scenario: &Scenario) -> Self {
        Self { shape: HighPassed::of(scenario), low: Vector3::zeros() }
    }

    pub(super) fn next(&mut self, random: &mut Random) -> Vector3<f64> {
        let white = random.normal3();
        self.low += (white - self.low) * self.shape.smoothing;
        (white - self.low).component_mul(&self.shape.scale_m_s2)
    }
}

/// Chatter of the bit: acceleration at a high order of the rotation.
pub(super) struct Chatter {
    amplitude_m_s2: f64,
    order: f64,
    mean_rad_s: f64,
    phase_rad: [f64; 3],
}

impl Chatter {
    pub(super) fn new(scenario: &Scenario, random: &mut Random) -> Self {
        Self {
            amplitude_m_s2: scenario.vibration.chatter_m_s2,
            order: f64::from(scenario.vibration.chatter_order),
            mean_rad_s: scenario.rotation.mean_rpm * TAU / 60.0,
            phase_rad: std::array::from_fn(|_| TAU * random.uniform()),
        }
    }

    pub(super) fn at(&self, motion: &Motion) -> Vector3<f64> {
        if self.mean_rad_s == 0.0 {
            return Vector3::zeros();
        }
        let speed = motion.toolface_rate_rad_s / self.mean_rad_s;
        let waves = self.phase_rad.map(|phase| libm::sin(self.order * motion.toolface_rad + phase));
        Vector3::from(waves) * (self.amplitude_m_s2 * speed * speed)
    }
}

/// A half-sine pulse, and the rebound that takes its velocity out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shock {
    /// Start, seconds.
    pub start_s: f64,
    /// Length of the pulse, seconds.
    pub length_s: f64,
    /// Peak, tool axes, m/s^2.
    pub peak_m_s2: [f64; 3],
    /// Length of the rebound, seconds; 0 for none.
    pub rebound_s: f64,
}

impl Shock {
    /// End, rebound included, seconds.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.start_s + self.length_s + self.rebound_s
    }

    /// Mean acceleration over an interval, tool axes, m/s^2 (exact: the difference of the velocities).
    pub(super) fn mean_m_s2(&self, from_s: f64, to_s: f64) -> Vector3<f64> {
        Vector3::from(self.peak_m_s2) * ((self.velocity_s(to_s) - self.velocity_s(from_s)) / (to_s - from_s))
    }

    /// Velocity at `t_s` for a peak of 1 m/s^2: it has the unit of a time.
    fn velocity_s(&self, t_s: f64) -> f64 {
        let since_s = t_s - self.start_s;
        let pulse = (1.0 - libm::cos(PI * (since_s / self.length_s).clamp(0.0, 1.0))) * self.length_s / PI;
        if self.rebound_s > 0.0 {
            pulse * (1.0 - ((since_s - self.length_s) / self.rebound_s).clamp(0.0, 1.0))
        } else {
            pulse
        }
    }
}

/// Draws the shocks of a run, in order of time: exponential pauses, uniform peaks and lengths, within 30 deg
/// of lateral.
pub(super) fn draw_shocks(settings: &ShockSettings, from_s: f64, to_s: f64, random: &mut Random) -> Vec<Shock> {
    let mut shocks = Vec::new();
    if settings.per_minute <= 0.0 {
        return shocks;
    }
    let mean_pause_s = 60.0 / settings.per_minute;
    let mut start_s = from_s;
    loop {
        start_s += mean_pause_s * random.exponential();
        if start_s >= to_s {
            return shocks;
        }
        let [low_g, high_g] = settings.peak_g;
        let [low_ms, high_ms] = settings.length_ms;
        let peak = STANDARD_GRAVITY_M_S2 * random.between(low_g, high_g);
        let length_s = 1e-3 * random.between(low_ms, high_ms);
        let (sine, cosine) = libm::sincos(TAU * random.uniform());
        let (axial, lateral) = libm::sincos(random.between(-PI / 6.0, PI / 6.0));
        shocks.push(Shock {
            start_s,
            length_s,
            peak_m_s2: [lateral * cosine, lateral * sine, axial].map(|x| peak * x),
            rebound_s: 1e-3 * settings.rebound_ms,
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn broadband_noise_has_the_stated_rms_and_no_slow_part() {
        let scenario = Scenario::default();
        let mut broadband = Broadband::new(&scenario);
        let mut random = Random::new(4);
        let n = 200_000;
        let (mut sum, mut square) = (Vector3::zeros(), Vector3::zeros());
        for _ in 0..n {
            let a = broadband.next(&mut random);
            sum += a;
            square += a.component_mul(&a);
        }
        let rms = (square / f64::from(n)).map(f64::sqrt);
        assert!((rms - Vector3::new(3.0, 3.0, 2.0)).amax() < 0.05, "{rms}");
        // White noise of 3 m/s^2 would leave 0.0067; its own low-pass takes all of that away.
        assert!((sum / f64::from(n)).amax() < 1e-3);
    }

    #[test]
    fn its_means_are_as_large_as_those_of_the_white_noise_that_stands_for_it() {
        const SAMPLES: u32 = 20;
        let scenario = Scenario::default();
        let mut broadband = Broadband::new(&scenario);
        let mut random = Random::new(5);
        let means = 20_000;
        let mut square = Vector3::zeros();
        for _ in 0..means {
            let mean = (0..SAMPLES).map(|_| broadband.next(&mut random)).sum::<Vector3<f64>>() / f64::from(SAMPLES);
            square += mean.component_mul(&mean);
        }
        let found = (square / f64::from(means)).map(f64::sqrt);
        let stated = HighPassed::of(&scenario).white_m_s2(SAMPLES) / f64::from(SAMPLES).sqrt();
        assert!((found.component_div(&stated) - Vector3::repeat(1.0)).amax() < 0.03, "{found} {stated}");
    }

    #[test]
    fn a_shock_is_its_impulse_however_it_is_cut_and_the_rebound_takes_it_back() {
        let shock = Shock { start_s: 1.0034, length_s: 0.006, peak_m_s2: [100.0, 0.0, -50.0], rebound_s: 0.0 };
        let impulse = |shock: &Shock, from: i32, to: i32| -> Vector3<f64> {
            (from..to).map(|ms| f64::from(ms) * 1e-3).map(|t| shock.mean_m_s2(t, t + 1e-3) * 1e-3).sum()
        };
        let half_sine = Vector3::new(100.0, 0.0, -50.0) * (0.006 * 2.0 / PI);
        assert!((impulse(&shock, 990, 1_020) - half_sine).norm() < 1e-9);
        assert_eq!(shock.mean_m_s2(0.0, 1.0), Vector3::zeros());
        let caught = Shock { rebound_s: 0.05, ..shock };
        assert!((impulse(&caught, 990, 1_100)).norm() < 1e-9);
        assert!((caught.mean_m_s2(1.02, 1.03) + half_sine / 0.05).norm() < 1e-9);
        assert_eq!(caught.mean_m_s2(caught.end_s(), 2.0), Vector3::zeros());
    }

    #[test]
    fn shocks_are_as_many_as_poisson_says() {
        let settings = ShockSettings::default();
        let counts: Vec<usize> =
            (0..50).map(|seed| draw_shocks(&settings, 10.0, 430.0, &mut Random::new(seed)).len()).collect();
        // 140 expected in each run, 7,000 in all.
        for &count in &counts {
            assert!((count as f64 - 140.0).abs() < 4.0 * 140_f64.sqrt(), "{count}");
        }
        assert!((counts.iter().sum::<usize>() as f64 - 7_000.0).abs() < 4.0 * 7_000_f64.sqrt());
        let shocks = draw_shocks(&settings, 10.0, 430.0, &mut Random::new(1));
        let g = shocks.iter().map(|s| Vector3::from(s.peak_m_s2).norm() / STANDARD_GRAVITY_M_S2);
        assert!(g.clone().fold(f64::INFINITY, f64::min) >= 5.0 && g.fold(0.0, f64::max) <= 20.0);
        assert!(shocks.first().unwrap().start_s > 10.0 && shocks.last().unwrap().start_s < 430.0);
    }
}
