//! Whether and when the gyro's bias stepped: a change point of the residual together with a shock.
//!
//! Each test window's scores and information of the three columns of c stand for a constant rate error in that window. A step before t is
//! such an error in the windows before t; those that t lies in have their share of it.

use super::stream::SampleStream;
use super::{remainder::chance_of_ratio, sign_flip::GROUPS};
use nalgebra::{Matrix3, Vector3};

mod fit;
mod rate_errors;
mod shocks;

use fit::{Fit, Sums, inverse_with_prior};
pub(super) use rate_errors::{RateErrors, Timing};
pub(super) use shocks::Shocks;

/// A step that is thought of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BiasStep {
    /// First increment after it; 0: there is none.
    pub until: u32,
    /// The new bias less the old one, compensated frame, rad/s.
    pub step_rad_s: Vector3<f32>,
    pub sigma_rad_s: Vector3<f32>,
    /// Gain in log-likelihood, in the noise that is left.
    pub gain: f32,
    pub p_value: f32,
}

impl BiasStep {
    pub const NONE: Self = Self { p_value: 1.0, ..Self::zero() };

    #[inline(always)]
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { until: 0, step_rad_s: zero, sigma_rad_s: zero, gain: 0.0, p_value: 0.0 }
    }

    /// What the compensated rate of an increment lacks to be as after the step.
    pub fn correction_rad_s(&self, index: u32) -> Vector3<f32> {
        if index < self.until { self.step_rad_s } else { Vector3::zeros() }
    }
}

/// Threshold of twice the log-likelihood between the best time and others that it may have been as well, with 99 %: Hansen, Econometrica
/// 68 (2000) 575, table 1.
const AS_LIKELY: f32 = 10.59;

impl RateErrors<'_> {
    /// Begins to look for a step; `known` is one that has been taken out already. `None`: nothing can be told.
    #[inline(never)]
    pub fn begin(&mut self, known: &BiasStep, timing: &Timing, unit_rad_s: f32) -> Option<Scan> {
        self.put_back(known, timing, unit_rad_s);
        let mut all = Sums::ZERO;
        let mut line = Sums::ZERO;
        for test in 0..timing.tests {
            let (score, information) = self.of(test);
            all.add(&score, &information, 1.0);
            line.add(&score, &information, (test as f32 + 0.5) / timing.tests as f32);
        }
        let inverse_of_all = inverse_with_prior(&all.of_one)?;
        let drift = line.fit(&all, &inverse_of_all)?.1;
        Some(Scan { all, inverse_of_all, drift, ..Scan::zero() })
    }

    /// Tries at most so many times; whether there are others.
    #[inline(never)]
    pub fn scan(
        &self,
        scan: &mut Scan,
        timing: &Timing,
        (shocks, stream): (&Shocks, &SampleStream),
        most: usize,
    ) -> bool {
        let mut more = false;
        for (tried, until) in shocks.times().skip(scan.tried).enumerate() {
            more = tried == most;
            if more {
                break;
            }
            scan.tried += 1;
            while scan.whole < timing.tests && timing.share(scan.whole, until) >= 1.0 {
                let (score, information) = self.of(scan.whole);
                scan.before.add(&score, &information, 1.0);
                scan.whole += 1;
            }
            let mut sums = scan.before;
            for test in scan.whole..timing.tests.min(scan.whole + timing.hops) {
                let (score, information) = self.of(test);
                sums.add(&score, &information, timing.share(test, until));
            }
            let Some((fit, gain)) = sums.fit(&scan.all, &scan.inverse_of_all) else { continue };
            scan.best = if gain > scan.best.1 { (until, gain) } else { scan.best };
            let at_shock = &mut scan.best_at_shock;
            if shocks.is_shock(stream, until) && at_shock.as_ref().is_none_or(|(_, most, _)| gain > *most) {
                *at_shock = Some((until, gain, fit));
            }
        }
        more
    }

    /// The step that explains most, of those at a shock. `None`: there was no shock when the residual changed, or it did not change at once.
    #[inline(never)]
    pub fn found(&self, scan: &Scan, timing: &Timing, shocks: &Shocks, unit_rad_s: f32) -> Option<BiasStep> {
        let (until, twice_the_gain, fit) = scan.best_at_shock?;
        let (dispersion, freedom) = self.dispersion(timing, until, &fit)?;
        let noise = if dispersion > 1.0 { dispersion } else { 1.0 };
        // At the shock: no other time is likelier, or none that is farther off than the test windows tell apart.
        let (likeliest, most) = scan.best;
        let is_at_shock = likeliest.abs_diff(until) <= timing.hop || twice_the_gain >= most - AS_LIKELY * dispersion;
        // A straight line has as many parameters.
        if twice_the_gain <= scan.drift || !is_at_shock {
            return None;
        }
        let p_value = shocks.count() as f32 * chance_of_ratio(twice_the_gain / (3.0 * dispersion), 3.0, freedom);
        Some(BiasStep {
            until,
            step_rad_s: fit.step * -unit_rad_s,
            sigma_rad_s: fit.covariance.diagonal().map(|v| libm::sqrtf(v * dispersion) * unit_rad_s),
            gain: 0.5 * twice_the_gain / noise,
            p_value: if p_value < 1.0 { p_value } else { 1.0 },
        })
    }

    /// Variance of the groups' scores that the step leaves, over what they were thought to have, and its degrees of freedom.
    #[inline(never)]
    fn dispersion(&self, timing: &Timing, until: u32, fit: &Fit) -> Option<(f32, f32)> {
        let (mut square, mut freedom) = (0.0, -6.0);
        let groups = GROUPS as u32;
        for group in 0..groups {
            let (from, to) = (group * timing.tests / groups, (group + 1) * timing.tests / groups);
            let (mut left, mut information) = (Vector3::zeros(), Matrix3::zeros());
            for test in from..to {
                let (score, of_one) = self.of(test);
                left += score - of_one * (fit.step * timing.share(test, until) + fit.rest);
                information += of_one;
            }
            let Some(inverse) = inverse_with_prior(&information) else { continue };
            if information.trace() > 0.0 {
                square += left.dot(&(inverse * left));
                freedom += 3.0;
            }
        }
        (freedom > 3.0 && square > 0.0).then_some((square / freedom, freedom))
    }
}

/// How far a search for a step has come.
pub(super) struct Scan {
    all: Sums,
    inverse_of_all: Matrix3<f32>,
    /// Twice the gain of a straight line.
    drift: f32,
    /// Of the test windows that lie wholly before the present time, and how many they are.
    before: Sums,
    whole: u32,
    /// Times that have been tried.
    tried: usize,
    /// The likeliest of all times and twice its gain; the same of those at a shock.
    best: (u32, f32),
    best_at_shock: Option<(u32, f32, Fit)>,
}

impl Scan {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            all: Sums::ZERO,
            inverse_of_all: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            drift: 0.0,
            before: Sums::ZERO,
            whole: 0,
            tried: 0,
            best: (0, 0.0),
            best_at_shock: None,
        }
    }
}
