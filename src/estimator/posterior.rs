//! Posterior: the gyro's errors from all samples so far, and the decision whether they may fly. This is where P is
//! accepted or refused; the reasons are in `refusal.rs`, the mean in `averaging.rs`.

use super::{
    CandidateSet, Refusal,
    averaging::Averaged,
    columns::{BIAS, P},
    filter::Filter,
    gaussian::triangle,
    gyro_matrix::GyroMatrix,
    real::{M3, Real, V3, norm},
};
use crate::{
    algebra::cholesky::Cholesky,
    compensation::{GyroModel, Theta},
};
use nalgebra::Vector3;

/// Motion before which nothing flies, seconds: of 26 flights that ended after 4 to 20 s of it two were made worse, of
/// 26 that ended after 14 to 30 s none.
const LEAST_MOTION_S: f32 = 14.0;
/// Least motion where the data exclude the P that the filter began with, seconds: as many nodes as P has elements.
const LEAST_MOTION_EXCLUDED_S: f32 = 4.5;
/// Chi-square of nine degrees of freedom, exceeded once in a thousand.
const EXCLUDED: f32 = 27.88;
/// Share of the latest time without a rate from which on the gyro is of no use.
const MOST_LOST: f32 = 0.5;
/// Share of the latest motion whose rates contradict the field from which on this is no burst: the attitude is aligned
/// anew after each contradiction, so that a gyro that is always wrong contradicts half of the time.
const MOST_TURNED: f32 = 0.25;
/// Share of the latest motion without a field from which on there is no magnetometer.
const MOST_FIELDLESS: f32 = 0.8;
/// Deviations of P, in widths of its prior, from the factory's P or a stored model's from which on no data sheet allows
/// it: one in 16,000 by chance.
const MOST_SIGMAS: f32 = 4.0;
/// Hard iron, of the earth's field, from which on the magnetometer needs a calibration first.
const MOST_HARD_IRON: f32 = 0.5;
/// Share of the prior's variance that a parameter must fall below to count as observed: half of its deviation.
const OBSERVED: f32 = 0.25;

/// Gyro's errors, from all samples so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// The mean that may fly.
    pub gyro: GyroModel,
    /// The factory's P with its own bias.
    pub bias_only: GyroModel,
    /// Part of the latest rest's raw rate that is none of the bias but of the effects that are taken out, rad/s.
    pub of_effects_at_rest_rad_s: Vector3<f32>,
    /// Effects that are taken out: P and b are beside these.
    pub taken_out: CandidateSet,
    /// Deviations of P and b.
    pub sigma: Theta,
    /// Covariance of P's nine elements, row-major: the packed lower triangle.
    pub p_covariance: [f32; 45],
    /// Number of P's nine directions that the data decide.
    pub decided: u8,
    /// True for those of the twelve parameters that are observed, in the order of `sigma`.
    pub observable: [bool; 12],
    /// Widths that the data choose for the magnetometer's shape, the hard iron, the accelerometer's matrix,
    /// the magnetometer's misalignment and the accelerometer's bias, over the data sheets'.
    pub widths: [f32; 5],
    /// NIS: mean squared innovation over its degrees of freedom.
    pub nis: f32,
    /// Seconds of motion that the posterior comes from.
    pub motion_s: f32,
    /// Decision whether the mean may fly, and the reason if not.
    pub fitness: Result<(), Refusal>,
}

/// The model with steps of its bias, rad/s of the compensated rate.
pub(super) fn stepped(model: GyroModel, steps: &Vector3<f32>) -> GyroModel {
    GyroModel { b_rad_s: (Vector3::from(model.b_rad_s) + turned_back(&model, steps)).into(), ..model }
}

/// Raw rate that a model makes this compensated rate of, beside its bias.
pub(crate) fn turned_back(model: &GyroModel, rate_rad_s: &Vector3<f32>) -> Vector3<f32> {
    model.p_matrix().try_inverse().map_or(*rate_rad_s, |inverse| inverse * rate_rad_s)
}

/// Returns true if the P that the filter began with is farther from the mean than chance makes it once in a thousand.
fn excludes_start<T: Real>(averaged: &Averaged<T>) -> bool {
    let covariance = |i: usize, j: usize| averaged.covariance.get(triangle(i) + j).copied().unwrap_or(T::ZERO);
    let Some(factor) = Cholesky::<T, 9>::new(9, covariance) else { return false };
    let [p @ .., _, _, _] = averaged.mean;
    let mut whitened: [T; 9] = p;
    factor.solve_lower(&mut whitened);
    whitened.iter().fold(T::ZERO, |sum, x| sum + *x * *x) > T::of(EXCLUDED)
}

/// Sets P of a model.
pub(super) fn set_p<T: Real>(model: &mut GyroModel, p: &M3<T>) {
    // Column-major, so row by row.
    for (slot, x) in model.p.as_flattened_mut().iter_mut().zip(p.transpose().iter()) {
        *slot = x.narrow();
    }
}

impl<T: Real, const NODES: usize, const E: usize> Filter<T, NODES, E> {
    /// The posterior of an average, at the present state of the filter.
    pub(super) fn posterior_of(&self, averaged: &Averaged<T>) -> Posterior {
        let mut sigma = [0.0; 12];
        let mut p_covariance = [0.0; 45];
        // P row-major, then b, as the average has them.
        let unit = |k: usize| {
            let column = if k < 9 { P.from + k } else { BIAS.from + k - 9 };
            self.prior.sigma.get(column).map_or(0.0, |sigma| sigma.narrow())
        };
        let variance = |i: usize, j: usize| averaged.covariance.get(triangle(i) + j).map_or(0.0, |x| x.narrow());
        for (k, sigma) in sigma.iter_mut().enumerate() {
            let (own, least) = (libm::sqrtf(variance(k, k)) * unit(k), self.least_sigma(k, averaged) * unit(k));
            *sigma = if own < least { least } else { own };
        }
        let pairs = (0..9).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for (slot, (i, j)) in p_covariance.iter_mut().zip(pairs) {
            *slot = variance(i, j) * unit(i) * unit(j);
            if let Some(sigma) = sigma.get(i).filter(|_| i == j) {
                *slot = sigma * sigma;
            }
        }
        let gyro = stepped(self.model(&averaged.mean), &self.steps());
        let of_effects = self.candidates.at_rest(&self.rests.still());
        Posterior {
            gyro,
            bias_only: GyroModel { b_rad_s: gyro.b_rad_s, ..self.settings.factory },
            of_effects_at_rest_rad_s: turned_back(&gyro, &of_effects),
            taken_out: self.candidates.taken_out(),
            sigma,
            p_covariance,
            decided: averaged.decided,
            observable: averaged.unscaled_variance.map(|variance| variance < T::of(OBSERVED)),
            widths: averaged.widths.map(|x| x.narrow()),
            nis: self.course.consistency.nis(),
            motion_s: self.course.motion_s.narrow(),
            fitness: self.fitness(averaged),
        }
    }

    /// The least deviation that may be stated of an element of P, in units of the prior's width. About a stored model
    /// a small scale of the prior says that little has drifted since; it does not say that what was stored was exact.
    /// So an element that the samples do not show is as uncertain as it was when it was stored.
    fn least_sigma(&self, element: usize, averaged: &Averaged<T>) -> f32 {
        let stored = self.prior.stored_sigma.get(element).map_or(T::ZERO, |sigma| *sigma);
        let unscaled = averaged.unscaled_variance.get(element).map_or(T::ZERO, |variance| variance.root());
        (if stored < unscaled { stored } else { unscaled }).narrow()
    }

    /// Steps of the bias that are taken out, rad/s of the compensated rate.
    pub(super) fn steps(&self) -> Vector3<f32> {
        self.candidates.stepped().map(|x| x.narrow())
    }

    fn fitness(&self, averaged: &Averaged<T>) -> Result<(), Refusal> {
        for (share, most) in [(self.shares.unread.get(), MOST_LOST), (self.shares.turned.get(), MOST_TURNED)] {
            if share > most {
                return Err(Refusal::GyroUnusable { share });
            }
        }
        if !self.course.has_begun {
            return Err(Refusal::NoAccelerometer);
        }
        let motion_s = self.course.motion_s.narrow();
        // Motion from before the power was off counts once a node of this start has been judged.
        let motion_s = if self.course.consistency.is_empty() { 0.0 } else { motion_s };
        let needed_s = if excludes_start(averaged) { LEAST_MOTION_EXCLUDED_S } else { LEAST_MOTION_S };
        if motion_s < needed_s {
            return Err(Refusal::NotEnoughMotion { motion_s, needed_s });
        }
        if self.course.consistency.seems_diverged() {
            return Err(Refusal::Diverged { nis: self.course.consistency.nis() });
        }
        let share = if self.node.has_field { self.shares.fieldless.get() } else { 1.0 };
        if share > MOST_FIELDLESS {
            return Err(Refusal::NoMagnetometer { share });
        }
        let sigmas = averaged.mean.iter().take(9).fold(0.0_f32, |most, x| {
            let size = libm::fabsf(x.narrow());
            // A NaN stays, and is refused.
            if size <= most { most } else { size }
        });
        if !matches!(sigmas.partial_cmp(&MOST_SIGMAS), Some(core::cmp::Ordering::Less)) {
            return Err(Refusal::Implausible { sigmas });
        }
        let hard_iron_share = (norm(&self.parameters.hard_iron) / norm(&self.node.field)).narrow();
        if hard_iron_share > MOST_HARD_IRON {
            return Err(Refusal::MagnetometerUncalibrated { hard_iron_share });
        }
        Ok(())
    }

    /// Bias at a deviation in units of the prior's width, rad/s.
    fn bias_of(&self, deviation: &[T; 3]) -> [f32; 3] {
        let [x, y, z] = *deviation;
        let sigma = self.prior.sigma.get(BIAS.from).copied().unwrap_or(T::ZERO);
        (self.bias + V3::new(x, y, z) * sigma).map(|b| b.narrow()).into()
    }

    /// Model at deviations of P (row-major) and b in units of the prior's widths.
    pub(super) fn model(&self, deviations: &[T; 12]) -> GyroModel {
        let [p @ .., x, y, z] = *deviations;
        let mut model = GyroModel { b_rad_s: self.bias_of(&[x, y, z]), ..self.settings.factory };
        let mut d = p;
        for (d, sigma) in d.iter_mut().zip(self.prior.sigma.iter().skip(P.from)) {
            *d *= *sigma;
        }
        set_p(&mut model, &GyroMatrix::new(&d, &self.prior.p).p);
        model
    }
}
