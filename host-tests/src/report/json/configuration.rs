//! The configuration that flew, as a configuration's file has it: with the instant of a freeze, which is the host's.

use meerkat_mwd::{
    Config,
    compensation::{GyroModel, VectorModel},
    config::{AttitudeConfig, Earth, FullScale, IdentificationConfig, Latency, SurveyConfig},
};
use serde::Serialize;

use testbed::flight::Flight;

/// Fields of [`Config`], in their order, with the hold-out's instant.
#[derive(Debug, Serialize)]
pub(crate) struct Configuration {
    sample_period_us: u32,
    seed: u64,
    freeze_at_us: Option<u64>,
    effects: bool,
    full_scale: FullScale,
    gyro: GyroModel,
    accel: VectorModel,
    mag: VectorModel,
    latency: Latency,
    earth: Earth,
    attitude: AttitudeConfig,
    identification: IdentificationConfig,
    survey: SurveyConfig,
}

impl Configuration {
    pub fn of(config: &Config, flight: &Flight) -> Self {
        // Without `..`: a field that `Config` gains does not compile here until it is written, too.
        let Config {
            sample_period_us,
            seed,
            effects,
            full_scale,
            gyro,
            accel,
            mag,
            latency,
            earth,
            attitude,
            identification,
            survey,
        } = *config;
        Self {
            sample_period_us,
            seed,
            freeze_at_us: flight.frozen_at_us,
            effects,
            full_scale,
            gyro,
            accel,
            mag,
            latency,
            earth,
            attitude,
            identification,
            survey,
        }
    }
}
