//! Whether and when the gyro's bias stepped: a change point of the residual together with a shock.
//!
//! Each test window's scores and information of the three columns of c stand for a constant rate error in that window. A step before t is
//! such an error in the windows before t; those that t lies in have their share of it.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    remainder::chance_of_ratio,
    sign_flip::GROUPS,
    weak_columns::{COLUMNS, GYRO},
};
use crate::{rotation::sine_and_cosine, window::SampleStream};
use nalgebra::{Matrix3, Vector3};

mod shocks;

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

/// Scores of one test window, and information of two of them.
const SCORE: usize = 3;
const INFORMATION: usize = 6;

/// Threshold of twice the log-likelihood between the best time and others that it may have been as well, with 99 %: Hansen, Econometrica
/// 68 (2000) 575, table 1.
const AS_LIKELY: f32 = 10.59;

/// What the test windows say of a constant error of the rate, in memory that is lent.
pub(super) struct RateErrors<'a> {
    sums: &'a mut [f32],
}

/// When the test windows are.
#[derive(Clone, Copy)]
pub(super) struct Timing {
    /// First increment of the first.
    pub from: u32,
    pub hop: u32,
    /// Hops in a test window.
    pub hops: u32,
    /// How many there are.
    pub tests: u32,
}

impl Timing {
    /// Which share of a test window's weight lies before an increment: that of sin^2.
    #[inline(never)]
    fn share(&self, test: u32, until: u32) -> f32 {
        let begin = self.from + test * self.hop;
        let length = self.hop * self.hops;
        if until <= begin {
            0.0
        } else if until >= begin + length {
            1.0
        } else {
            let part = (until - begin) as f32 / length as f32;
            part - sine_and_cosine(core::f32::consts::TAU * part).0 / core::f32::consts::TAU
        }
    }
}

impl<'a> RateErrors<'a> {
    /// In memory of at least 6 numbers per test window.
    pub fn new(sums: &'a mut [f32]) -> Self {
        Self { sums }
    }

    pub fn clear(&mut self) {
        self.sums.fill(0.0);
    }

    /// Adds the rows of one vector over one test window.
    #[inline(never)]
    pub fn add(&mut self, test: usize, rows: &[[f32; COLUMNS]; 3], residual: &[f32; 3], weight: f32) {
        let stride = 2 * SCORE + INFORMATION;
        let pair = self.sums.get_mut(test / 2 * stride..(test / 2 + 1) * stride).unwrap_or_default();
        let Some((scores, information)) = pair.split_at_mut_checked(2 * SCORE) else { return };
        for (row, r) in rows.iter().zip(residual) {
            let [x, y, z] = [row[GYRO - 3], row[GYRO - 2], row[GYRO - 1]];
            let scores = scores.iter_mut().skip(test % 2 * SCORE);
            scores.zip([x, y, z]).for_each(|(sum, a)| *sum += weight * a * r);
            let products = [x * x, y * x, y * y, z * x, z * y, z * z];
            information.iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
        }
    }

    /// Score and information of a test window; the information is the mean of two.
    #[inline(never)]
    fn of(&self, test: u32) -> (Vector3<f32>, Matrix3<f32>) {
        let stride = 2 * SCORE + INFORMATION;
        let pair = (test / 2) as usize * stride;
        let Some([a, b, c, d, e, f, xx, yx, yy, zx, zy, zz]) =
            self.sums.get(pair..).and_then(|sums| sums.first_chunk::<12>())
        else {
            return (Vector3::zeros(), Matrix3::zeros());
        };
        let score = if test.is_multiple_of(2) { Vector3::new(*a, *b, *c) } else { Vector3::new(*d, *e, *f) };
        (score, Matrix3::new(*xx, *yx, *zx, *yx, *yy, *zy, *zx, *zy, *zz) * 0.5)
    }

    /// Puts a step that has been taken out back into the scores. `unit`: rate per unit of c's columns, rad/s.
    #[inline(never)]
    fn put_back(&mut self, step: &BiasStep, timing: &Timing, unit_rad_s: f32) {
        let x = step.step_rad_s / -unit_rad_s;
        for test in 0..timing.tests {
            let share = timing.share(test, step.until);
            if share == 0.0 {
                break;
            }
            let (_, information) = self.of(test);
            let added = information * x * share;
            let stride = 2 * SCORE + INFORMATION;
            let at = (test / 2) as usize * stride + (test % 2) as usize * SCORE;
            self.sums.iter_mut().skip(at).zip(added.iter()).for_each(|(sum, added)| *sum += added);
        }
    }

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

/// Inverse of an information with the prior's, which is one.
#[inline(never)]
fn inverse_with_prior(information: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    (information + Matrix3::identity()).try_inverse()
}

/// An error of the rate before a time, and one at all times.
#[derive(Clone, Copy)]
struct Fit {
    step: Vector3<f32>,
    rest: Vector3<f32>,
    covariance: Matrix3<f32>,
}

/// Sums over test windows of their scores and information, each times its share, and of the information times the squared share.
#[derive(Clone, Copy)]
struct Sums {
    score: Vector3<f32>,
    of_one: Matrix3<f32>,
    of_two: Matrix3<f32>,
}

impl Sums {
    const ZERO: Self = Self {
        score: Vector3::new(0.0, 0.0, 0.0),
        of_one: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        of_two: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    #[inline(never)]
    fn add(&mut self, score: &Vector3<f32>, information: &Matrix3<f32>, share: f32) {
        self.score += score * share;
        self.of_one += information * share;
        self.of_two += information * (share * share);
    }

    /// The error that goes with the share, beside one at all times, and twice its gain. The unit information of the prior keeps it
    /// solvable.
    #[inline(never)]
    fn fit(&self, all: &Self, inverse_of_all: &Matrix3<f32>) -> Option<(Fit, f32)> {
        let gains = self.of_one * inverse_of_all;
        let score = self.score - gains * all.score;
        let covariance = inverse_with_prior(&(self.of_two - gains * self.of_one))?;
        let step = covariance * score;
        let gain = step.dot(&score);
        let rest = inverse_of_all * (all.score - self.of_one * step);
        gain.is_finite().then_some((Fit { step, rest, covariance }, gain))
    }
}
