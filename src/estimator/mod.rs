//! The gyro's errors from all samples so far: one forward square-root filter over increments, nodes and rests.
//!
//! Samples are pushed as they come, work is done in pieces between them, and at an instant of one's own choosing the posterior is asked for.

mod posterior;
mod window_cost;

pub use posterior::{Posterior, Unfit};
pub use window_cost::WindowCost;

use crate::{
    config::{Config, Motion},
    sample::Reading,
};
use nalgebra::Vector3;

/// Constants of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What moves the probe.
    pub motion: Motion,
}

impl Settings {
    /// Those of a configuration that has been checked.
    #[must_use]
    pub const fn new(config: &Config) -> Self {
        Self { motion: config.identification.motion }
    }
}

/// The estimator; all zero bytes when new.
pub struct Estimator {
    settings: Settings,
}

impl Estimator {
    /// An estimator before its configuration.
    #[must_use]
    pub const fn zero() -> Self {
        Self { settings: Settings { motion: Motion::Hand } }
    }

    /// Starts afresh.
    pub const fn configure(&mut self, settings: &Settings) {
        self.settings = *settings;
    }

    /// Takes one sample: raw rate, rad/s, without the earth's and without the effects of the gyro that are taken out; specific force, m/s^2,
    /// and field, microtesla, calibrated. It sees gaps in time by itself, and it is cheap.
    pub const fn push(&mut self, _t_us: u64, _rate: Reading, _force: Reading, _field: Reading) {}

    /// Forgets everything learnt, for instance when the gyro's effects have changed: the factory's model is the centre of the prior again.
    pub const fn restart(&mut self) {}

    /// The gyro's bias stepped by so much, raw frame.
    pub const fn step_bias(&mut self, _by_rad_s: Vector3<f32>) {}

    /// Asks for the posterior of all samples so far. It is there once [`Estimator::step`] has returned 0, and until then there is none.
    pub const fn close(&mut self) {}

    /// One bounded piece of work; its size in units of some 300 instructions, 0 when there is nothing to do.
    pub const fn step(&mut self) -> u32 {
        0
    }

    /// What the last [`Estimator::close`] asked for, once it is done.
    #[must_use]
    pub const fn posterior(&self) -> Option<&Posterior> {
        None
    }

    /// The rows of the last 50 s of motion: what the population search minimises.
    #[must_use]
    pub const fn window_cost(&self) -> Option<WindowCost<'_>> {
        None
    }

    /// Seconds of motion since the start: not at rest, and with a gyro that can be used.
    #[must_use]
    pub const fn motion_s(&self) -> f32 {
        0.0
    }

    /// When the probe was last at rest, microseconds; `None` before the first rest.
    #[must_use]
    pub const fn last_rest_us(&self) -> Option<u64> {
        None
    }

    /// How many of the last `seconds`, at most 64, were at rest.
    #[must_use]
    pub const fn rest_seconds(&self, _seconds: u32) -> u32 {
        0
    }

    /// Increments that were lost because [`Estimator::step`] was called too seldom.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        0
    }
}
