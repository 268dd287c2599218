//! What all samples so far say of the gyro's errors, and whether that may fly.

use super::{
    Estimator,
    averaging::Averaged,
    columns::{BIAS, P},
    gaussian::triangle,
    real::{Real, V3, norm},
};
use crate::compensation::GyroModel;

/// Motion before which nothing flies, seconds: of 26 recordings two were made worse after 4 to 20 s of it, and none after 14.
const LEAST_MOTION_S: f32 = 14.0;
/// Mean squared innovation, over its degrees of freedom, of a filter that has diverged: four deviations of the mean of 120 nodes of nine
/// over 1. Sound runs stay under 1.07.
const DIVERGED: f32 = 1.2;
/// The same before there are so many nodes: this over the root of their number.
const DIVERGED_EARLY: f32 = 1.9;
/// Share of the latest time without a rate at which the gyro is of no use.
const MOST_LOST: f32 = 0.5;
/// Share of the latest motion without a field at which there is no magnetometer.
const MOST_FIELDLESS: f32 = 0.8;
/// Deviations of the prior from its centre, the factory's P or a stored model's, at which a P is none that a data sheet allows: one in 16,000
/// by chance.
const MOST_SIGMAS: f32 = 4.0;
/// Hard iron, of the earth's field, at which the magnetometer needs a calibration first.
const MOST_HARD_IRON: f32 = 0.5;
/// A parameter is observed when less than half of the prior's deviation is left.
const OBSERVED: f32 = 0.5;

/// What all samples so far say of the gyro's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// The mean that may fly.
    pub gyro: GyroModel,
    /// The factory's P with its own bias.
    pub bias_only: GyroModel,
    /// 1-sigma of P (row-major, 9) then b (rad/s, 3).
    pub sigma: [f32; 12],
    /// Covariance of P's nine elements, row-major: the packed lower triangle.
    pub p_covariance: [f32; 45],
    /// Directions of P's nine that the data decide.
    pub decided: u8,
    /// Which of the twelve parameters are observed.
    pub observable: [bool; 12],
    /// Widths that the data choose for the magnetometer's matrix, the hard iron and the accelerometer, over the data sheet's.
    pub widths: [f32; 3],
    /// Mean squared innovation over its degrees of freedom.
    pub nis: f32,
    /// Seconds of motion that it comes from.
    pub motion_s: f32,
    /// Whether it may fly.
    pub fitness: Result<(), Unfit>,
}

/// Why a posterior may not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Unfit {
    /// Too little motion with a gyro that can be used.
    NotEnoughMotion {
        /// How much there was, seconds.
        motion_s: f32,
        /// How much there has to be, seconds.
        needed_s: f32,
    },
    /// The innovations are larger than the filter thinks.
    Diverged {
        /// Mean squared innovation over its degrees of freedom.
        nis: f32,
    },
    /// The gyro's readings are missing, clipped or frozen too often.
    GyroUnusable {
        /// Share of the time without a rate.
        share: f32,
    },
    /// The accelerometer reads nothing usable.
    NoAccelerometer,
    /// Too little of the motion has a field: rotation about gravity cannot be seen.
    NoMagnetometer {
        /// Share of the motion without one.
        share: f32,
    },
    /// P is farther from the factory's than any part's data sheet allows.
    Implausible {
        /// How many deviations of the prior.
        sigmas: f32,
    },
    /// The magnetometer's offset is too large: it needs a calibration first.
    MagnetometerUncalibrated {
        /// Hard iron, of the earth's field.
        hard_iron_share: f32,
    },
}

impl<T: Real> Estimator<T> {
    /// The posterior of an average, at the present state of the filter.
    pub(super) fn posterior_of(&self, averaged: &Averaged<T>) -> Posterior {
        let mut sigma = [0.0; 12];
        let mut observable = [false; 12];
        let mut p_covariance = [0.0; 45];
        // P row-major, then b, as the average has them.
        let unit = |k: usize| {
            let column = if k < 9 { P.from + k } else { BIAS.from + k - 9 };
            self.sigma.get(column).map_or(0.0, |sigma| sigma.narrow())
        };
        let variance = |i: usize, j: usize| averaged.covariance.get(triangle(i) + j).map_or(0.0, |x| x.narrow());
        for (k, (sigma, observable)) in sigma.iter_mut().zip(&mut observable).enumerate() {
            let deviation = libm::sqrtf(variance(k, k));
            *observable = deviation < OBSERVED;
            *sigma = deviation * unit(k);
        }
        let pairs = (0..9).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for (slot, (i, j)) in p_covariance.iter_mut().zip(pairs) {
            *slot = variance(i, j) * unit(i) * unit(j);
        }
        let b = [9, 10, 11].map(|k| averaged.mean.get(k).copied().unwrap_or(T::ZERO));
        Posterior {
            gyro: self.model(&averaged.mean),
            bias_only: GyroModel { b_rad_s: self.bias_of(&b), ..self.settings.factory },
            sigma,
            p_covariance,
            decided: averaged.decided,
            observable,
            widths: averaged.widths.map(|x| x.narrow()),
            nis: self.innovation.narrow(),
            motion_s: self.motion_s.narrow(),
            fitness: self.fitness(averaged),
        }
    }

    fn fitness(&self, averaged: &Averaged<T>) -> Result<(), Unfit> {
        let share = self.unread.get();
        if share > MOST_LOST {
            return Err(Unfit::GyroUnusable { share });
        }
        if !self.has_begun {
            return Err(Unfit::NoAccelerometer);
        }
        let motion_s = self.motion_s.narrow();
        // What was learnt before the power was off counts, but says nothing new before the first motion.
        let motion_s = if self.innovations == 0 { 0.0 } else { motion_s };
        if motion_s < LEAST_MOTION_S {
            return Err(Unfit::NotEnoughMotion { motion_s, needed_s: LEAST_MOTION_S });
        }
        let early = 1.0 + DIVERGED_EARLY / libm::sqrtf(f32::from(self.innovations));
        let nis = self.innovation.narrow();
        if self.has_diverged() || nis > DIVERGED && nis > early {
            return Err(Unfit::Diverged { nis });
        }
        let share = if self.node.has_field { self.fieldless.get() } else { 1.0 };
        if share > MOST_FIELDLESS {
            return Err(Unfit::NoMagnetometer { share });
        }
        let sigmas = averaged.mean.iter().take(9).fold(0.0_f32, |most, x| {
            let size = libm::fabsf(x.narrow());
            // A NaN stays.
            if size <= most { most } else { size }
        });
        if !matches!(sigmas.partial_cmp(&MOST_SIGMAS), Some(core::cmp::Ordering::Less)) {
            return Err(Unfit::Implausible { sigmas });
        }
        let hard_iron_share = (norm(&self.parameters.hard_iron) / norm(&self.node.field)).narrow();
        if hard_iron_share > MOST_HARD_IRON {
            return Err(Unfit::MagnetometerUncalibrated { hard_iron_share });
        }
        Ok(())
    }

    /// Whether the innovations say that the filter is wrong.
    pub(super) fn has_diverged(&self) -> bool {
        self.innovations >= super::work::INNOVATIONS && self.innovation > T::of(DIVERGED)
    }

    /// The bias of a deviation in units of the prior's width, rad/s.
    fn bias_of(&self, deviation: &[T; 3]) -> [f32; 3] {
        let [x, y, z] = *deviation;
        let sigma = self.sigma.get(BIAS.from).copied().unwrap_or(T::ZERO);
        (self.bias + V3::new(x, y, z) * sigma).map(|b| b.narrow()).into()
    }

    /// The model of deviations of P (row-major) and b in units of the prior's widths.
    pub(super) fn model(&self, deviations: &[T; 12]) -> GyroModel {
        let [p @ .., x, y, z] = *deviations;
        let mut model = GyroModel { b_rad_s: self.bias_of(&[x, y, z]), ..self.settings.factory };
        let sigma = self.sigma.iter().skip(P.from);
        // Column-major, so row by row.
        let centre = self.prior_p.transpose();
        for (((slot, centre), x), sigma) in model.p.as_flattened_mut().iter_mut().zip(centre.iter()).zip(p).zip(sigma) {
            *slot = (*centre + x * *sigma).narrow();
        }
        model
    }
}
