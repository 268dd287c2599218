//! From samples to what a diagnosis works on: increments of 20 ms and the bias at rests.

mod accumulator;
mod bias_steps;
mod grid;
mod increment;
mod increment_ring;
mod rest_bias;
mod surroundings;
mod test_function;

pub(super) use accumulator::Accumulator;
pub(super) use grid::Grid;
pub(super) use increment::Increment;
pub(crate) use rest_bias::RestBias;
pub(super) use surroundings::{SHARED, halved, whole};
pub(super) use test_function::{TestFunction, UNDER_WAY};

use crate::{
    compensation::{ActiveEffects, Effect, effect::REFERENCE_TEMPERATURE_C},
    config::Config,
    rest::{RestDetector, RestLimits},
    sample::Reading,
};
use bias_steps::BiasSteps;
use increment_ring::{IncrementRing, Scales};
use nalgebra::Vector3;
use surroundings::SurroundingsRing;

/// Increments kept: the longest window and latency together (46 s of at least 20 ms) and some more.
const INCREMENTS: usize = 2_320;

/// Everything that is gathered from samples as they come: increments and rests.
pub(super) struct SampleStream {
    pub grid: Grid,
    pub increments: IncrementRing<INCREMENTS>,
    pub surroundings: SurroundingsRing,
    accumulator: Accumulator,
    /// What the test windows of this grid are weighted with.
    pub test_function: TestFunction,
    effects: ActiveEffects,
    bias_steps: BiasSteps,
    library: Option<&'static [&'static dyn Effect]>,
    rest_detector: RestDetector,
    rest_limits: RestLimits,
    bias_walk_rad_s_rts: f32,
    rest_bias: Option<RestBias>,
    rest_bias_us: u64,
    sample_period_us: u32,
    scales: Scales,
}

impl SampleStream {
    pub const fn zero() -> Self {
        Self {
            grid: Grid::zero(),
            increments: IncrementRing::zero(),
            surroundings: SurroundingsRing::zero(),
            accumulator: Accumulator::zero(),
            test_function: TestFunction::zero(),
            effects: ActiveEffects::none(),
            bias_steps: BiasSteps::NONE,
            library: None,
            rest_detector: RestDetector::zero(),
            rest_limits: RestLimits { deviation_rad_s: 0.0, bias_rad_s: 0.0 },
            bias_walk_rad_s_rts: 0.0,
            rest_bias: None,
            rest_bias_us: 0,
            sample_period_us: 0,
            scales: Scales::zero(),
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let id = &config.identification;
        self.grid = Grid::new(config.sample_period_us);
        self.test_function.configure(self.grid);
        self.effects = ActiveEffects::none();
        self.rest_limits = RestLimits { deviation_rad_s: id.rest_gyro_deviation_rad_s, bias_rad_s: id.max_bias_rad_s };
        self.bias_walk_rad_s_rts = config.attitude.gyro_bias_walk_rad_s_rts;
        self.sample_period_us = config.sample_period_us;
        // Where the full scale is unknown: 4000 deg/s and 32 g, the widest of the parts in use, and ten times the strongest field on earth.
        self.scales = Scales::new(
            config.full_scale.gyro_rad_s.unwrap_or(70.0),
            2.0 * config.full_scale.accel_m_s2.unwrap_or(160.0),
            2.0 * config.full_scale.mag_ut.unwrap_or(330.0),
        );
        self.rest_bias = None;
    }

    /// Begins at the first sample's time.
    pub fn start(&mut self, t_us: u64) {
        self.increments.start(self.scales);
        self.surroundings.start();
        self.bias_steps = BiasSteps::NONE;
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.rest_detector.start(self.sample_period_us);
    }

    /// Begins again after a gap. An empty increment marks it, so that no test window spans it.
    pub fn restart(&mut self, t_us: u64) {
        self.push_increment(&Increment { rate: None, gravity: None, field: None });
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.rest_detector.start(self.sample_period_us);
    }

    /// Takes one sample.
    pub fn push(&mut self, t_us: u64, [rate, gravity, field]: [Reading; 3], temperature_c: Option<f32>) {
        while let Some(increment) = self.accumulator.close_before(t_us, self.grid) {
            self.push_increment(&increment);
        }
        self.accumulator.add(rate, gravity, field);
        let square_force = if let Reading::Good(gravity) = gravity { Some(gravity.norm_squared()) } else { None };
        self.surroundings.add(square_force, temperature_c);
        let Some(Some(rest)) = self.rest_detector.push(rate, gravity, field, &self.rest_limits) else { return };
        let warming_k = temperature_c.map_or(0.0, |t| t - REFERENCE_TEMPERATURE_C);
        let before = self.rest_as_read(t_us);
        self.rest_bias =
            Some(before.map_or(RestBias::from_rest(&rest, warming_k), |bias| bias.updated(&rest, warming_k)));
        self.rest_bias_us = t_us;
    }

    fn push_increment(&mut self, increment: &Increment) {
        self.increments.push(increment);
        self.surroundings.complete(self.increments.count().wrapping_sub(1));
    }

    /// Sets the effects that are looked for, all of which may come to be taken out.
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.library = Some(library);
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.library.unwrap_or(&[])
    }

    /// The effects that are taken out.
    pub const fn effects(&self) -> &ActiveEffects {
        &self.effects
    }

    /// From here on these effects are taken out.
    pub const fn set_effects(&mut self, effects: &ActiveEffects) {
        self.effects = *effects;
    }

    /// From here on what was read before increment `until`, at `t_us`, is made to look like what is read after it: by that much more, raw.
    pub fn step_bias(&mut self, until: u32, t_us: u64, step_rad_s: &Vector3<f32>) {
        self.bias_steps.add(until, *step_rad_s);
        if let Some(bias) = self.rest_bias.as_mut().filter(|_| self.rest_bias_us < t_us) {
            bias.rate += step_rad_s;
        }
    }

    /// Increment `index` as it would have been read with the bias of the latest.
    #[inline(never)]
    pub fn read(&self, index: u32) -> Increment {
        let read = self.increments.get(index);
        Increment { rate: read.rate.map(|rate| self.bias_steps.taken_out(index, rate)), ..read }
    }

    /// The bias from rests, aged to `t_us`, without the part of the active effects and as uncertain as
    /// that.
    pub fn rest_bias(&self, t_us: u64) -> Option<RestBias> {
        let mut bias = self.rest_as_read(t_us)?;
        let mut moment = bias.moment();
        bias.variance += self.effects.rate_variance(self.library(), &moment);
        self.effects.correct_rate(self.library(), &mut moment);
        bias.rate += moment.rate_rad_s;
        Some(bias)
    }

    /// The same with it.
    pub fn rest_as_read(&self, t_us: u64) -> Option<RestBias> {
        let since_s = t_us.saturating_sub(self.rest_bias_us) as f32 * 1e-6;
        self.rest_bias.map(|bias| bias.aged(since_s, self.bias_walk_rad_s_rts))
    }

    /// When the tool was last at rest, microseconds; `None` before the first rest.
    pub fn last_rest_us(&self) -> Option<u64> {
        self.rest_bias.map(|_| self.rest_bias_us)
    }
}
