//! Detector of a turn that is too slow to be told from the gyro's bias: gravity and field, in the body, show it.

use super::{error_state::BIAS, filter_step::FilterStep, rest_rate::RestRate, state::State};
use crate::statistics::chi_square::OF_TWO_IN_A_THOUSAND;
use core::f32::consts::TAU;
use nalgebra::Vector3;

/// Least length of the means of the field that are compared, seconds.
const BLOCK_S: f32 = 0.5;
/// Least number of filter steps with a field in such a mean: its scatter is then known to a half (chi-square of eight
/// degrees of freedom, two axes across the field). A magnetometer that is read five times a second gives as many in a
/// second.
const LEAST_FIELDS: u16 = 5;
/// Longest time in which a mean gathers its fields, seconds; after a longer one they do not stand for its middle.
const LONGEST_BLOCK_S: f32 = 5.0;
/// Fastest turn that is taken for rest, rad/s: `RestTracker` allows 2 deg/s, VQF's default.
const FASTEST_RAD_S: f32 = 0.035;
/// Longest time that the field is given to show a turn, seconds: one about the field's own direction it does not show.
const LONGEST_S: f32 = 120.0;
/// Wander of the field's mean direction over half a second at rest, beside its noise, rad: 0.1 deg on recordings of
/// sensors on a table (`estimator::Noise::HAND`: its field at rest).
const OWN_RAD: f32 = 1.8e-3;

/// Sums over half a second or more: force and field in the body, field in the earth frame, and the field's squared
/// norm.
#[derive(Clone, Copy)]
struct Block {
    force: Vector3<f32>,
    field: Vector3<f32>,
    field_ned: Vector3<f32>,
    /// Turn that the gyro showed, with its bias, rad.
    turn: Vector3<f32>,
    square: f32,
    /// Filter steps with a field.
    fields: u16,
    /// Time of all filter steps, seconds.
    seconds: f32,
}

impl Block {
    const ZERO: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        field: Vector3::new(0.0, 0.0, 0.0),
        field_ned: Vector3::new(0.0, 0.0, 0.0),
        turn: Vector3::new(0.0, 0.0, 0.0),
        square: 0.0,
        fields: 0,
        seconds: 0.0,
    };

    /// Variance of the mean field's direction about an axis, rad^2.
    fn variance(&self) -> f32 {
        let n = f32::from(self.fields);
        let norm_squared = self.field.norm_squared() / n;
        // Relative variance of single steps about their mean, over the two axes across the field.
        let scatter = (self.square - norm_squared) / norm_squared;
        OWN_RAD * OWN_RAD + if scatter > 0.0 && n > 1.0 { 0.5 * scatter / (n - 1.0) } else { 0.0 }
    }

    /// Square of the heading's change over that of the field's direction.
    fn steepness(&self) -> f32 {
        self.field_ned.norm_squared() / self.field_ned.xy().norm_squared()
    }

    fn mean(&self) -> Mean {
        let (norm, n) = (libm::sqrtf(self.field.norm_squared()), f32::from(self.fields));
        Mean {
            direction: self.field / norm,
            norm: norm / n,
            dip_cosine: self.force.dot(&self.field) / (libm::sqrtf(self.force.norm_squared()) * norm),
            heading: libm::atan2f(self.field_ned.y, self.field_ned.x),
            variance: self.variance(),
        }
    }
}

/// Mean field of a block.
#[derive(Clone, Copy)]
struct Mean {
    /// In the body, of unit length; zero: there is none.
    direction: Vector3<f32>,
    norm: f32,
    /// Cosine of the angle between force and field.
    dip_cosine: f32,
    /// Heading of the field in the earth frame, rad.
    heading: f32,
    /// Variance of the direction about an axis, rad^2.
    variance: f32,
}

impl Mean {
    const NONE: Self =
        Self { direction: Vector3::new(0.0, 0.0, 0.0), norm: 0.0, dip_cosine: 0.0, heading: 0.0, variance: 0.0 };

    const fn is_none(&self) -> bool {
        self.norm <= 0.0
    }
}

/// Detector of slow turns while everything is quiet.
pub(super) struct SlowTurn {
    block: Block,
    /// Mean with which later ones are compared: the first at rest, or the last in which the field had changed.
    first: Mean,
    /// Mean field of the block before.
    last_field: Vector3<f32>,
    age_s: f32,
    /// Time that has to pass without a turn until rest is believed, seconds: as long as the last turn took to be seen.
    doubted_s: f32,
    /// Variance of the bias before the first block, largest of the axes, (rad/s)^2.
    bias_variance: f32,
    rate: RestRate,
}

impl SlowTurn {
    pub const fn new() -> Self {
        Self {
            block: Block::ZERO,
            first: Mean::NONE,
            last_field: Vector3::new(0.0, 0.0, 0.0),
            age_s: 0.0,
            doubted_s: 0.0,
            bias_variance: 0.0,
            rate: RestRate::new(),
        }
    }

    /// Notes another gyro model, with which the residual bias has changed by this much, rad/s. With another P the mean
    /// rate begins anew.
    pub fn model_changed(&mut self, by: &Vector3<f32>, same_p: bool) {
        if same_p {
            self.rate.mean += by;
            self.block.turn += by * self.block.seconds;
        } else {
            self.rate = RestRate::new();
        }
    }

    /// Returns true if the mean rate of a quiet gyro may be its bias.
    pub const fn is_none(&self) -> bool {
        self.age_s >= self.doubted_s
    }

    /// Passes over seconds in which the gyro was not quiet, or was not read.
    pub fn interrupt(&mut self, time_s: f32) {
        self.rate.interrupt(time_s);
        *self = Self { rate: core::mem::replace(&mut self.rate, RestRate::new()), ..Self::new() };
    }

    /// Takes a filter step's mean vectors, NED. A turn that gravity and field show, and that was taken for bias, is
    /// corrected in heading and bias.
    pub fn update(&mut self, state: &mut State, step: &FilterStep, is_quiet: bool) {
        if !is_quiet {
            self.interrupt(step.time_s);
            return;
        }
        if self.block.fields == 0 && (self.first.is_none() || self.age_s <= 0.0) {
            self.bias_variance = largest_bias_variance(state);
        }
        self.block.seconds += step.time_s;
        self.block.turn += step.angle_rad + state.bias_rad_s * step.time_s;
        if let (Some(force), Some(field)) = (step.mean_force(), step.mean_field()) {
            let to_body = state.rotation.transpose();
            self.block.square += field.norm_squared();
            self.block.fields += 1;
            self.block.force += to_body * force;
            self.block.field += to_body * field;
            self.block.field_ned += field;
        }
        let is_full = self.block.fields >= LEAST_FIELDS;
        if self.block.seconds < if is_full { BLOCK_S } else { LONGEST_BLOCK_S } {
            return;
        }
        let block = core::mem::replace(&mut self.block, Block::ZERO);
        if !is_full {
            // A doubt stays: only a field ends it.
            (self.first, self.age_s) = (Mean::NONE, 0.0);
            return;
        }
        self.age_s += block.seconds;
        let mean = block.mean();
        let mean_field = mean.direction * mean.norm;
        let last_field = core::mem::replace(&mut self.last_field, mean_field);
        if self.first.is_none() {
            (self.first, self.age_s) = (mean, block.seconds);
            return;
        }
        let variance = mean.variance + self.first.variance;
        let limit = OF_TWO_IN_A_THOUSAND * variance;
        let missed = libm::remainderf(mean.heading - self.first.heading, TAU);
        let is_news = self.rate.update(&(block.turn / block.seconds));
        // Twice the time that the field needs to show such a turn.
        let needed_s = 2.0 * libm::sqrtf(limit) / self.rate.across(&mean.direction);
        let needed_s = if needed_s < LONGEST_S { needed_s } else { LONGEST_S };
        if self.rate.is_changed {
            // The gyro sees a turn, or has another bias. Until the field has shown which, it is a turn, and the bias is
            // what it was.
            self.doubted_s = needed_s;
        }
        if is_news {
            self.set_bias(state);
            self.first = mean;
            self.age_s = 0.0;
            return;
        }
        if (mean.direction - self.first.direction).norm_squared() <= limit {
            if self.rate.is_changed && self.is_none() {
                // Nothing turned: it is the bias.
                state.turn_heading(-missed);
                state.refresh_rotation();
                self.rate.accept();
                self.set_bias(state);
            }
            return;
        }
        // A turn changes neither the field's norm nor its angle to gravity; a magnet that comes near the probe does.
        let longer = mean.norm / self.first.norm - 1.0;
        let steeper = mean.dip_cosine - self.first.dip_cosine;
        let rate = missed / self.age_s;
        // A change within one block is no slow turn.
        let step = (mean_field - last_field).norm_squared() / mean_field.norm_squared();
        let is_slow = step <= FASTEST_RAD_S * FASTEST_RAD_S * block.seconds * block.seconds + limit;
        let is_turn = is_slow && longer * longer <= limit && steeper * steeper <= limit;
        if is_turn {
            self.doubted_s = if self.rate.is_changed { needed_s } else { self.age_s };
        }
        if is_turn
            && missed * missed > limit * block.steepness()
            && rate * rate < OF_TWO_IN_A_THOUSAND * self.bias_variance
        {
            // The filter took the turn for bias and did not turn, so that the earth's field seemed to turn the other
            // way.
            state.turn_heading(-missed);
            state.refresh_rotation();
            let down = state.rotation.transpose() * Vector3::z();
            state.bias_rad_s += down * rate;
            let variance = variance * block.steepness() / (self.age_s * self.age_s);
            for k in 0..3 {
                state.errors.reset(BIAS + k, variance);
            }
        }
        self.first = mean;
        self.age_s = 0.0;
    }

    /// Takes the mean rate of the quiet gyro as its bias.
    fn set_bias(&self, state: &mut State) {
        state.bias_rad_s = self.rate.mean;
        for k in 0..3 {
            state.errors.reset(BIAS + k, self.rate.variance);
        }
    }
}

fn largest_bias_variance(state: &State) -> f32 {
    let largest = |most: f32, k: usize| {
        let variance = state.errors.variance(BIAS + k);
        if variance > most { variance } else { most }
    };
    (0..3).fold(0.0, largest)
}

#[cfg(test)]
mod tests;
