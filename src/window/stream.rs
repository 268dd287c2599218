use super::bias_steps::BiasSteps;
use super::{
    Accumulator, Grid, Increment, IncrementRing, Reading, RestBias, RestDetector, RestLimits, RestNorm, RestPairs,
    Scales, SurroundingsRing, TestFunction, rows::GYRO,
};
use crate::compensation::{ActiveEffects, Effect, Moment, effect::REFERENCE_TEMPERATURE_C};
use nalgebra::{Matrix3, Vector3};

/// Increments kept: the longest window (50 s of at least 20 ms) and the time to make its nodes.
pub(crate) const INCREMENTS: usize = 2_600;

/// Everything that is gathered from samples as they come: increments and rests.
pub(crate) struct SampleStream {
    pub grid: Grid,
    pub increments: IncrementRing<INCREMENTS>,
    pub surroundings: SurroundingsRing,
    accumulator: Accumulator,
    /// What the test windows of this grid are weighted with.
    pub test_function: TestFunction,
    theta: [f32; GYRO],
    effects: ActiveEffects,
    bias_steps: BiasSteps,
    library: Option<&'static [&'static dyn Effect]>,
    rest_detector: RestDetector,
    rest_limits: RestLimits,
    bias_walk_rad_s_rts: f32,
    rest_bias: Option<RestBias>,
    rest_bias_us: u64,
    /// The latest 64 seconds, one bit each, the newest lowest: 1 for rest.
    rest_history: u64,
    rest_norm: RestNorm,
    pub rest_pairs: RestPairs,
    /// When a magnet last came to the probe or left it; 0: none has.
    pub magnet_moved_us: u64,
    gravity_m_s2: f32,
    sample_period_us: u32,
    scales: Scales,
}

/// Constants of a stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreamSettings {
    pub sample_period_us: u32,
    pub rest_limits: RestLimits,
    pub bias_walk_rad_s_rts: f32,
    pub gravity_m_s2: f32,
    pub scales: Scales,
}

impl SampleStream {
    pub const fn zero() -> Self {
        Self {
            grid: Grid::zero(),
            increments: IncrementRing::zero(),
            surroundings: SurroundingsRing::zero(),
            accumulator: Accumulator::zero(),
            test_function: TestFunction::zero(),
            theta: [0.0; GYRO],
            effects: ActiveEffects::none(),
            bias_steps: BiasSteps::NONE,
            library: None,
            rest_detector: RestDetector::zero(),
            rest_limits: RestLimits { deviation_rad_s: 0.0, bias_rad_s: 0.0 },
            bias_walk_rad_s_rts: 0.0,
            rest_bias: None,
            rest_bias_us: 0,
            rest_history: 0,
            rest_norm: RestNorm::zero(),
            rest_pairs: RestPairs::zero(),
            magnet_moved_us: 0,
            gravity_m_s2: 0.0,
            sample_period_us: 0,
            scales: Scales::zero(),
        }
    }

    pub fn configure(&mut self, settings: &StreamSettings) {
        self.grid = Grid::new(settings.sample_period_us);
        self.test_function.configure(self.grid);
        self.effects = ActiveEffects::none();
        self.rest_limits = settings.rest_limits;
        self.bias_walk_rad_s_rts = settings.bias_walk_rad_s_rts;
        self.gravity_m_s2 = settings.gravity_m_s2;
        self.sample_period_us = settings.sample_period_us;
        self.scales = settings.scales;
        self.rest_bias = None;
        self.rest_history = 0;
        self.rest_norm = RestNorm::zero();
    }

    /// Begins at the first sample's time with the nominal model w = P w_raw - c.
    pub fn start(&mut self, t_us: u64, theta: &[f32; GYRO]) {
        self.increments.start(self.scales);
        self.surroundings.start();
        self.bias_steps = BiasSteps::NONE;
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.theta = *theta;
        self.rest_pairs.start(theta);
        self.rest_detector.start(self.sample_period_us);
    }

    /// Begins again after a gap. An empty increment marks it, so that no node and no test window spans it; what was gathered
    /// before stays for the window that the gap closed.
    pub fn restart(&mut self, t_us: u64) {
        self.push_increment(&Increment { rate: None, gravity: None, field: None });
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.rest_detector.start(self.sample_period_us);
        self.rest_pairs.interrupt();
    }

    /// Takes one sample.
    pub fn push(&mut self, t_us: u64, rate: Reading, gravity: Reading, field: Reading, temperature_c: Option<f32>) {
        while let Some(increment) = self.accumulator.close_before(t_us, self.grid) {
            self.push_increment(&increment);
        }
        self.accumulator.add(rate, gravity, field);
        let square_force = if let Reading::Good(gravity) = gravity { Some(gravity.norm_squared()) } else { None };
        self.surroundings.add(square_force, temperature_c);
        let Some(second) = self.rest_detector.push(rate, gravity, field, &self.rest_limits) else { return };
        self.rest_history = self.rest_history << 1 | u64::from(second.is_some());
        self.rest_pairs.second(t_us, second.as_ref());
        let Some(rest) = second else { return };
        let warming_k = temperature_c.map_or(0.0, |t| t - REFERENCE_TEMPERATURE_C);
        let before = self.rest_as_read(t_us);
        self.rest_bias =
            Some(before.map_or(RestBias::from_rest(&rest, warming_k), |bias| bias.updated(&rest, warming_k)));
        self.rest_bias_us = t_us;
        if let Some(force_m_s2) = rest.force_m_s2 {
            self.rest_norm.add(libm::fabsf(force_m_s2.norm() - self.gravity_m_s2));
        }
    }

    fn push_increment(&mut self, increment: &Increment) {
        self.increments.push(increment);
        let alone = increment.field.is_none() && self.effects.is_empty();
        self.rest_pairs.push(increment.rate.as_ref().filter(|_| alone), self.grid.interval_s());
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

    /// Whether an effect that is taken out turns a sensor's axes.
    pub fn turns_axes(&self) -> bool {
        let mut found = self.effects.iter().filter_map(|found| self.library().get(usize::from(found.index)));
        found.any(|effect| effect.parameters().iter().any(|parameter| parameter.turns_axes))
    }

    /// From here on these effects are taken out of the increments, those that are kept already included.
    pub fn set_effects(&mut self, effects: &ActiveEffects) {
        self.effects = *effects;
        self.rest_pairs.start(&self.theta);
    }

    /// From here on what was read before increment `until`, at `t_us`, is made to look like what is read after it: by that much more, raw.
    pub fn step_bias(&mut self, until: u32, t_us: u64, step_rad_s: Vector3<f32>) {
        self.bias_steps.add(until, step_rad_s);
        self.rest_pairs.start(&self.theta);
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

    /// Increment `index` without the active effects.
    pub fn increment(&self, index: u32) -> Increment {
        if self.effects.is_empty() { self.read(index) } else { self.without_effects(index) }
    }

    // A function of its own, so that its registers are not saved where there are no effects.
    #[inline(never)]
    fn without_effects(&self, index: u32) -> Increment {
        let read = self.read(index);
        let Some(raw) = read.rate else { return read };
        let nominal = |raw: Vector3<f32>| {
            let [p00, p01, p02, p10, p11, p12, p20, p21, p22, c0, c1, c2] = self.theta;
            Matrix3::new(p00, p01, p02, p10, p11, p12, p20, p21, p22) * raw - Vector3::new(c0, c1, c2)
        };
        let rate = nominal(raw);
        let before = self.read(index.wrapping_sub(1)).rate.map_or(rate, nominal);
        // Not of the next one: whether it is there already depends on when this is asked.
        let acceleration = (rate - before) / self.grid.interval_s();
        let surroundings = self.surroundings.get(index);
        let mut moment = Moment {
            rate_rad_s: rate,
            acceleration_rad_s2: acceleration,
            // Specific force is minus gravity's reading.
            force_m_s2: -read.gravity.unwrap_or_default(),
            square_force_m2_s4: surroundings.square_force_m2_s4,
            field_ut: read.field.unwrap_or_default(),
            warming_k: surroundings.temperature_c.map_or(0.0, |t| t - REFERENCE_TEMPERATURE_C),
        };
        self.effects.correct(self.library(), &mut moment);
        Increment {
            // P is the identity to some per cent, and the change is small already.
            rate: Some(raw + (moment.rate_rad_s - rate)),
            gravity: read.gravity.map(|_| -moment.force_m_s2),
            field: read.field.map(|_| moment.field_ut),
        }
    }

    /// The nominal model is w = P w_raw - c from here on.
    pub fn change_model(&mut self, theta: &[f32; GYRO]) {
        self.theta = *theta;
        self.rest_pairs.change_model(theta);
    }

    /// Mean square rate over a test window, as a rate, under which it holds nothing about P.
    pub const fn moving_rate_rad_s(&self) -> f32 {
        self.rest_limits.bias_rad_s
    }

    /// How many of the last `seconds` (at most 64) were at rest.
    pub const fn rest_seconds(&self, seconds: u32) -> u32 {
        if seconds >= 64 {
            self.rest_history.count_ones()
        } else {
            (self.rest_history & ((1 << seconds) - 1)).count_ones()
        }
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

    /// Largest error of the norm of specific force at the latest rests, m/s^2; `None` before the first.
    pub fn rest_norm_error_m_s2(&self) -> Option<f32> {
        self.rest_norm.largest()
    }
}
