//! What is to be identified, and what that takes.

use super::Forgetting;
use crate::{
    compensation::{GyroModel, VectorModel},
    config::Config,
    window::{RestBias, SampleStream},
};

/// The window being identified.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub t_start_us: u64,
    pub t_end_us: u64,
    pub effect_us: u64,
    /// Increments of the window.
    pub from: u32,
    pub to: u32,
    /// The bias from rests until the close.
    pub rest: Option<RestBias>,
    /// The same with what the effects that are taken out added to it.
    pub rest_as_read: Option<RestBias>,
    /// Whether a rest came after what the flown bias was learnt from.
    pub rest_is_news: bool,
    /// End of the window that the P that flies was learnt from; 0: none.
    pub p_known_us: u64,
    pub rest_s: f32,
    /// Pairs of rests until the close.
    pub rest_pairs: u32,
    /// Largest error of the norm of specific force at a rest until the close, m/s^2.
    pub rest_norm_error_m_s2: Option<f32>,
}

impl Job {
    pub const fn zero() -> Self {
        Self {
            t_start_us: 0,
            t_end_us: 0,
            effect_us: 0,
            from: 0,
            to: 0,
            rest: None,
            rest_as_read: None,
            rest_is_news: false,
            p_known_us: 0,
            rest_s: 0.0,
            rest_pairs: 0,
            rest_norm_error_m_s2: None,
        }
    }
}

/// What a fit needs to know beside its window.
pub(crate) struct Context<'a> {
    pub stream: &'a SampleStream,
    pub config: &'a Config,
    pub flown: &'a GyroModel,
}

impl Context<'_> {
    /// How fast what earlier windows taught goes stale.
    pub const fn forgetting(&self) -> Forgetting {
        Forgetting {
            bias_walk_rad_s_rts: self.config.attitude.gyro_bias_walk_rad_s_rts,
            forgetting_s: self.config.identification.forgetting_s,
        }
    }

    /// Whether the configuration holds a calibration of the accelerometer.
    pub fn accelerometer_on_record(&self) -> bool {
        self.config.accel != VectorModel::IDENTITY
    }
}
