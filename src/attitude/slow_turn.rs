//! Detector of a turn that is too slow to be told from the gyro's bias: gravity and field, in the body, show it.

use super::{error_state::BIAS, filter_step::FilterStep, state::State};
use core::f32::consts::TAU;
use nalgebra::Vector3;

/// Chi-square of two degrees of freedom, exceeded once in a thousand: -2 ln 0.001.
const CHANGED: f32 = 13.82;
/// Length of the means of the field that are compared, seconds.
const BLOCK_S: f32 = 0.5;
/// Fastest turn that is taken for rest, rad/s: `RestTracker` allows 2 deg/s, VQF's default.
const FASTEST_RAD_S: f32 = 0.035;
/// Wander of the field's mean direction over half a second at rest, beside its noise, rad: 0.1 deg on recordings of
/// sensors on a table (`estimator::Noise::HAND`: its field at rest).
const OWN_RAD: f32 = 1.8e-3;

/// Sums over half a second: force and field in the body, field in the earth frame, and the field's squared norm.
#[derive(Clone, Copy)]
struct Block {
    force: Vector3<f32>,
    field: Vector3<f32>,
    field_ned: Vector3<f32>,
    square: f32,
    steps: u16,
    seconds: f32,
}

impl Block {
    const ZERO: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        field: Vector3::new(0.0, 0.0, 0.0),
        field_ned: Vector3::new(0.0, 0.0, 0.0),
        square: 0.0,
        steps: 0,
        seconds: 0.0,
    };

    /// Variance of the mean field's direction about an axis, rad^2.
    fn variance(&self) -> f32 {
        let n = f32::from(self.steps);
        let norm_squared = self.field.norm_squared() / n;
        // Relative variance of single steps about their mean, over the two axes across the field.
        let scatter = (self.square - norm_squared) / norm_squared;
        OWN_RAD * OWN_RAD + if scatter > 0.0 && n > 1.0 { 0.5 * scatter / (n - 1.0) } else { 0.0 }
    }

    fn heading(&self) -> f32 {
        libm::atan2f(self.field_ned.y, self.field_ned.x)
    }

    /// Cosine of the angle between force and field.
    fn dip_cosine(&self) -> f32 {
        self.force.dot(&self.field) / libm::sqrtf(self.force.norm_squared() * self.field.norm_squared())
    }
}

/// Detector of slow turns while everything is quiet.
pub(super) struct SlowTurn {
    block: Block,
    /// Block with which later ones are compared: the first at rest, or the last in which the field had changed; none if
    /// it has no steps.
    first: Block,
    /// Mean field of the block before.
    last_field: Vector3<f32>,
    age_s: f32,
    /// Time that has to pass without a turn until rest is believed, seconds: as long as the last turn took to be seen.
    doubted_s: f32,
    /// Variance of the bias before the first block, largest of the axes, (rad/s)^2.
    bias_variance: f32,
}

impl SlowTurn {
    pub const fn new() -> Self {
        Self {
            block: Block::ZERO,
            first: Block::ZERO,
            last_field: Vector3::new(0.0, 0.0, 0.0),
            age_s: 0.0,
            doubted_s: 0.0,
            bias_variance: 0.0,
        }
    }

    /// Returns true if the mean rate of a quiet gyro may be its bias.
    pub const fn is_none(&self) -> bool {
        self.age_s >= self.doubted_s
    }

    /// Takes a filter step's mean vectors, NED. A turn that gravity and field show, and that was taken for bias, is
    /// corrected in heading and bias.
    pub fn update(&mut self, state: &mut State, step: &FilterStep, is_quiet: bool) {
        if !is_quiet {
            *self = Self::new();
            return;
        }
        let (Some(force), Some(field)) = (step.mean_force(), step.mean_field()) else { return };
        if self.block.steps == 0 && (self.first.steps == 0 || self.age_s <= 0.0) {
            self.bias_variance = largest_bias_variance(state);
        }
        let to_body = state.rotation.transpose();
        let Block { square, steps, seconds, .. } = &mut self.block;
        *square += field.norm_squared();
        *steps += 1;
        *seconds += step.time_s;
        self.block.force += to_body * force;
        self.block.field += to_body * field;
        self.block.field_ned += field;
        if self.block.seconds < BLOCK_S {
            return;
        }
        let block = core::mem::replace(&mut self.block, Block::ZERO);
        let mean_field = block.field / f32::from(block.steps);
        let last_field = core::mem::replace(&mut self.last_field, mean_field);
        self.age_s += block.seconds;
        if self.first.steps == 0 {
            self.first = block;
            return;
        }
        let variance = block.variance() + self.first.variance();
        let limit = CHANGED * variance;
        let [now, before] = [block.field, self.first.field].map(|v| v / libm::sqrtf(v.norm_squared()));
        if (now - before).norm_squared() <= limit {
            return;
        }
        // A turn changes neither the field's norm nor its angle to gravity; a magnet that comes near the probe does.
        let norms = [block, self.first].map(|b| libm::sqrtf(b.field.norm_squared()) / f32::from(b.steps));
        let [norm, norm_before] = norms;
        let longer = norm / norm_before - 1.0;
        let steeper = block.dip_cosine() - self.first.dip_cosine();
        let missed = libm::remainderf(block.heading() - self.first.heading(), TAU);
        let rate = missed / self.age_s;
        // A change within one block is no slow turn.
        let step = (mean_field - last_field).norm_squared() / mean_field.norm_squared();
        let is_slow = step <= FASTEST_RAD_S * FASTEST_RAD_S * BLOCK_S * BLOCK_S + limit;
        let is_turn = is_slow && longer * longer <= limit && steeper * steeper <= limit;
        if is_turn {
            self.doubted_s = self.age_s;
        }
        if is_turn && missed * missed > limit && rate * rate < CHANGED * self.bias_variance {
            // The filter took the turn for bias and did not turn, so that the earth's field seemed to turn the other
            // way.
            state.turn_heading(-missed);
            state.refresh_rotation();
            let down = state.rotation.transpose() * Vector3::z();
            state.bias_rad_s += down * rate;
            let variance = variance / (self.age_s * self.age_s);
            for k in 0..3 {
                state.errors.reset(BIAS + k, variance);
            }
        }
        self.first = block;
        self.age_s = 0.0;
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
mod tests {
    use crate::{Config, attitude::AttitudeFilter, rotation::exp_matrix};
    use nalgebra::{Matrix3, Vector3};
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const PERIOD_S: f32 = 0.01;

    /// Largest heading error, rad, and its share of the stated deviation, of a probe that stands at 45 deg, turns about
    /// the vertical at `rate_rad_s` from 10 to 29 s, and stands again; `disturbed` gives the field at a time, seconds.
    fn worst(seed: u64, rate_rad_s: f32, disturbed: impl Fn(f32, Vector3<f32>) -> Vector3<f32>) -> (f32, f32) {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut uniform = || random.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0;
        let mut vector = |size: f32| Vector3::new(uniform(), uniform(), uniform()) * (size * libm::sqrtf(3.0));
        let (config, mut filter) = (Config::default(), AttitudeFilter::new());
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        let bias = vector(3e-3);
        let tilt = exp_matrix(&Vector3::new(0.3, 0.7, -0.2));
        let (mut largest, mut share, mut turned) = (0.0_f32, 0.0_f32, 0.0_f32);
        for k in 0..10_000_u16 {
            let t = f32::from(k) * PERIOD_S;
            let turning = if (10.0..29.0).contains(&t) { rate_rad_s } else { 0.0 };
            turned += turning * PERIOD_S;
            let body_to_ned: Matrix3<f32> = exp_matrix(&Vector3::new(0.0, 0.0, turned)) * tilt;
            let in_body = |v: Vector3<f32>| body_to_ned.transpose() * v;
            let rate = bias + in_body(Vector3::new(0.0, 0.0, turning)) + vector(2e-3) - filter.residual_bias_rad_s();
            filter.propagate(PERIOD_S, &rate);
            let field = in_body(disturbed(t, Vector3::new(25.0, 0.0, 43.0))) + vector(0.15);
            filter.observe(Some(&(in_body(Vector3::new(0.0, 0.0, -9.81)) + vector(0.02))), Some(&field));
            if t > 5.0 {
                let attitude = filter.attitude(crate::attitude::AttitudeFlags::empty()).unwrap();
                let truth = libm::atan2f(body_to_ned[(1, 2)], body_to_ned[(0, 2)]);
                let error = libm::fabsf(libm::remainderf(attitude.azimuth_rad - truth, core::f32::consts::TAU));
                let part = error / attitude.sigma_azimuth_rad;
                largest = if error > largest { error } else { largest };
                share = if part > share { part } else { share };
            }
        }
        (largest, share)
    }

    #[test]
    fn a_string_that_untwists_slowly_is_followed() {
        for seed in 0..4 {
            for deg_s in [0.1_f32, 0.2, 0.3] {
                let (error, share) = worst(seed, deg_s.to_radians(), |_, field| field);
                // Expected error: half of the 1.3 deg by which the field must turn at this dip to be seen, and its
                // noise.
                assert!(error < 1.3_f32.to_radians(), "seed {seed}, {deg_s} deg/s: {} deg", error.to_degrees());
                assert!(share < 1.0, "seed {seed}, {deg_s} deg/s: {share} of its deviation");
            }
        }
    }

    #[test]
    fn what_comes_near_a_probe_that_stands_turns_nothing() {
        for seed in 0..4 {
            let magnet = |t: f32, field: Vector3<f32>| {
                if (20.0..40.0).contains(&t) { field + Vector3::new(1.0, 2.0, 4.0) } else { field }
            };
            let (still, _) = worst(seed, 0.0, |_, field| field);
            let (error, share) = worst(seed, 0.0, magnet);
            assert!(error < still + 1.0_f32.to_radians() && share < 1.0, "seed {seed}: {still} {error} {share}");
        }
    }
}
