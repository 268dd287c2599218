use super::{
    Accumulator, Block, Grid, Increment, IncrementRing, Reading, RestBias, RestDetector, RestLimits, RestNorm, Scales,
    WeakForm,
};
use nalgebra::{Matrix3, Vector3};

/// Increments kept: the longest window (50 s of at least 20 ms) and the time to build its segments.
pub(crate) const INCREMENTS: usize = 2_600;

/// Length of a block of weak-form equations, seconds: the unit of cross-validation, longer than the motion is correlated.
const BLOCK_S: f32 = 2.5;

/// Blocks kept: 20 of a window, those cut at its ends, and those begun while it is being solved.
const BLOCKS: usize = 23;

/// Everything that is gathered from samples as they come: increments, blocks of weak-form equations, and rests.
pub(crate) struct SampleStream {
    pub grid: Grid,
    pub increments: IncrementRing<INCREMENTS>,
    accumulator: Accumulator,
    weak_form: WeakForm,
    blocks: [Block; BLOCKS],
    increments_per_block: u32,
    /// Number of the block being filled, counted from the start of the stream.
    newest_block: u32,
    rest_detector: RestDetector,
    rest_limits: RestLimits,
    bias_walk_rad_s_rts: f32,
    rest_bias: Option<RestBias>,
    rest_bias_us: u64,
    /// The latest 64 seconds, one bit each, the newest lowest: 1 for rest.
    rest_history: u64,
    rest_norm: RestNorm,
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
            accumulator: Accumulator::zero(),
            weak_form: WeakForm::zero(),
            blocks: [Block::zero(); BLOCKS],
            increments_per_block: 0,
            newest_block: 0,
            rest_detector: RestDetector::zero(),
            rest_limits: RestLimits { deviation_rad_s: 0.0, bias_rad_s: 0.0 },
            bias_walk_rad_s_rts: 0.0,
            rest_bias: None,
            rest_bias_us: 0,
            rest_history: 0,
            rest_norm: RestNorm::zero(),
            gravity_m_s2: 0.0,
            sample_period_us: 0,
            scales: Scales::zero(),
        }
    }

    pub fn configure(&mut self, settings: &StreamSettings) {
        self.grid = Grid::new(settings.sample_period_us);
        self.weak_form.configure(self.grid, settings.rest_limits.bias_rad_s);
        self.increments_per_block = self.grid.increments_in(BLOCK_S) as u32;
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
    pub fn start(&mut self, t_us: u64, p: Matrix3<f32>, c: Vector3<f32>) {
        self.increments.start(self.scales);
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.weak_form.start(p, c);
        self.blocks = [Block::zero(); BLOCKS];
        self.newest_block = 0;
        self.rest_detector.start(self.sample_period_us);
    }

    /// Begins again after a gap. An empty increment marks it, so that no segment and no test window spans it; what was gathered
    /// before stays for the window that the gap closed.
    pub fn restart(&mut self, t_us: u64) {
        self.push_increment(&Increment { rate: None, gravity: None, field: None });
        self.accumulator.start(t_us, self.grid, self.sample_period_us);
        self.rest_detector.start(self.sample_period_us);
    }

    /// Takes one sample.
    pub fn push(&mut self, t_us: u64, rate: Reading, gravity: Reading, field: Reading) {
        while let Some(increment) = self.accumulator.close_before(t_us, self.grid) {
            self.push_increment(&increment);
        }
        self.accumulator.add(rate, gravity, field);
        let Some(second) = self.rest_detector.push(rate, gravity, field, &self.rest_limits) else { return };
        self.rest_history = self.rest_history << 1 | u64::from(second.is_some());
        let Some(rest) = second else { return };
        self.rest_bias = Some(self.rest_bias(t_us).map_or(RestBias::from_rest(&rest), |bias| bias.updated(&rest)));
        self.rest_bias_us = t_us;
        if let Some(norm) = rest.specific_force_m_s2 {
            self.rest_norm.add(libm::fabsf(norm - self.gravity_m_s2));
        }
    }

    fn push_increment(&mut self, increment: &Increment) {
        let increment = self.increments.push(increment);
        // A test window that ends now has its centre half a window back.
        let centre = self.increments.count().saturating_sub(self.weak_form.half_length());
        let number = centre.checked_div(self.increments_per_block).unwrap_or(0);
        let Some(block) = self.blocks.get_mut(number as usize % BLOCKS) else { return };
        if number > self.newest_block {
            self.newest_block = number;
            *block = Block::zero();
        }
        self.weak_form.push(&increment, block);
    }

    /// The nominal model changes by `shift` of theta, to w = P w_raw - c: kept equations move their origin.
    pub fn change_model(&mut self, p: Matrix3<f32>, c: Vector3<f32>, shift: &[f32; 12]) {
        for block in &mut self.blocks {
            block.recentre(shift);
        }
        self.weak_form.change_model(p, c);
    }

    /// The numbers of the blocks that lie wholly within increments `from..to`.
    pub fn blocks_within(&self, from: u32, to: u32) -> core::ops::Range<u32> {
        let before = |increment: u32| increment.checked_div(self.increments_per_block).unwrap_or(0);
        let first = before(from + self.increments_per_block.saturating_sub(1));
        let end = before(to.saturating_sub(self.weak_form.half_length()));
        first..end
    }

    /// A block by number; `None` once it has been overwritten.
    pub fn block(&self, number: u32) -> Option<&Block> {
        let held = number <= self.newest_block && number + BLOCKS as u32 > self.newest_block;
        self.blocks.get(number as usize % BLOCKS).filter(|_| held)
    }

    /// How many of the last `seconds` (at most 64) were at rest.
    pub const fn rest_seconds(&self, seconds: u32) -> u32 {
        if seconds >= 64 {
            self.rest_history.count_ones()
        } else {
            (self.rest_history & ((1 << seconds) - 1)).count_ones()
        }
    }

    /// The bias from rests, aged to `t_us`.
    pub fn rest_bias(&self, t_us: u64) -> Option<RestBias> {
        let since_s = t_us.saturating_sub(self.rest_bias_us) as f32 * 1e-6;
        self.rest_bias.map(|bias| bias.aged(since_s, self.bias_walk_rad_s_rts))
    }

    /// Largest error of the norm of specific force at the latest rests, m/s^2; `None` before the first.
    pub fn rest_norm_error_m_s2(&self) -> Option<f32> {
        self.rest_norm.largest()
    }
}
