//! Watch for magnets: notices a jump of the field, follows two hypotheses, and decides (docs/magnets.md).

mod kept_intervals;
mod offsets;
mod suspicion;

use super::{
    accumulator::Accumulator,
    field_filter::{FieldFilter, FieldPrior, IN_BODY, IN_EARTH},
    field_node::{FieldNode, FieldNodes},
    field_noise::{CORRELATED, FieldNoise, at_most},
    grid::Grid,
    hard_iron_interval::{HardIronCounts, HardIronInterval},
    hypothesis::{JUMP_UT, follow, follow_from},
    rest::{RestDetector, RestLimits},
    rest_bias::RestBias,
};
use crate::{
    config::Config,
    sample::Reading,
    statistics::chi_square::{IN_A_HUNDRED, IN_A_MILLION, IN_A_THOUSAND, IN_TWENTY},
};
use nalgebra::Vector3;
use offsets::Offsets;
use suspicion::{Suspicion, Verdict};

/// Length of a node, seconds. Means over this time preserve turns of 300 deg/s, because they are taken in the
/// gyro's frame.
const NODE_S: f32 = 0.2;

/// Nodes (3 s) whose field must be as predicted before a change; else the change does not withhold the field. A magnet
/// that is brought comes faster; a slower change means that the gyro's own frame is wrong, and nothing can be decided.
const STEADY_NODES: u8 = 15;
/// Least size of a change that matters, in deviations of the calibrated field's error.
const LEAST_SIZE: f32 = 2.0;
/// Consecutive nodes with innovations exceeded by chance once in a hundred: together as unlikely as one in a million.
const UNLIKELY_NODES: u8 = 3;
/// Angle of turning since the start after which an offset present from the start must have shown, radians: half a turn
/// shows twice the offset.
const TOLD_RAD: f32 = core::f32::consts::PI;

/// Field to be used now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UsableField {
    /// None: the field changed in an undecided way, or an unknown offset came after the freeze.
    Withheld,
    /// The calibrated field after subtracting this offset, microtesla.
    Less(Vector3<f32>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// No field has been read yet.
    Waiting,
    /// One filter tracks the field.
    Tracking,
    /// The field changed: one filter assumes new iron, one a new earth field, one no change.
    Undecided,
}

/// Watch for body-fixed magnetic offsets that come and go.
///
/// A filter ([`FieldFilter`]) predicts the field in the frame that the gyro carries along. After a change
/// that it does not explain, two more filters start: one in which the body-fixed offset jumped, and one in
/// which the earth's field did. They agree while the probe stands still; once it turns, only one goes on predicting the
/// field. The field is withheld until their likelihoods decide. A constant offset present from the start belongs to the
/// null hypothesis.
pub(crate) struct HardIronWatch {
    settings: WatchSettings,
    state: State,
    prior: FieldPrior,
    noise: FieldNoise,
    accumulator: Accumulator,
    nodes: FieldNodes,
    rests: RestDetector,
    /// Bias from rests, and the time of the latest rest.
    rest_bias: Option<RestBias>,
    rest_us: u64,
    tracked: FieldFilter,
    iron: FieldFilter,
    earth: FieldFilter,
    /// Angle turned since the start, at most [`TOLD_RAD`], radians.
    turned_rad: f32,
    /// Consecutive nodes whose innovation is so large that chance exceeds it less than once in a hundred.
    unlikely: u8,
    /// Consecutive nodes whose innovation is so small that chance exceeds it more than once in a thousand, at most
    /// [`STEADY_NODES`].
    calm: u8,
    /// True if an offset that was there from the start has changed, until what was learnt of it is to be forgotten.
    own_iron_changed: bool,
    suspicion: Suspicion,
    offsets: Offsets,
}

/// Configuration of the watch.
#[derive(Clone, Copy)]
struct WatchSettings {
    period_us: u32,
    grid: Grid,
    rest_limits: RestLimits,
}

impl WatchSettings {
    /// All zero, for a static.
    const ZERO: Self =
        Self { period_us: 0, grid: Grid::zero(), rest_limits: RestLimits { deviation_rad_s: 0.0, bias_rad_s: 0.0 } };

    fn new(config: &Config) -> Self {
        let id = &config.identification;
        Self {
            period_us: config.sample_period_us,
            grid: Grid::new(config.sample_period_us),
            rest_limits: RestLimits { deviation_rad_s: id.rest_gyro_deviation_rad_s, bias_rad_s: id.max_bias_rad_s },
        }
    }
}

impl HardIronWatch {
    pub const fn zero() -> Self {
        Self {
            settings: WatchSettings::ZERO,
            state: State::Waiting,
            prior: FieldPrior::zero(),
            noise: FieldNoise::zero(),
            accumulator: Accumulator::zero(),
            nodes: FieldNodes::zero(),
            rests: RestDetector::zero(),
            rest_bias: None,
            rest_us: 0,
            tracked: FieldFilter::zero(),
            iron: FieldFilter::zero(),
            earth: FieldFilter::zero(),
            turned_rad: 0.0,
            unlikely: 0,
            calm: 0,
            own_iron_changed: false,
            suspicion: Suspicion::new(0, false),
            offsets: Offsets::zero(),
        }
    }

    /// Starts anew from a configuration.
    pub fn configure(&mut self, config: &Config) {
        let (id, attitude) = (&config.identification, &config.attitude);
        *self = Self::zero();
        self.settings = WatchSettings::new(config);
        self.prior = FieldPrior {
            diagonal: id.prior_sigma_diagonal,
            off_diagonal: id.prior_sigma_off_diagonal,
            bias_rad_s: id.prior_sigma_bias_rad_s,
            lag_s: attitude.mag_timing_sigma_s,
            in_body_ut: 0.0,
            forgetting_s: id.forgetting_s,
            bias_walk_rad_s_rts: attitude.gyro_bias_walk_rad_s_rts,
        };
        self.noise = FieldNoise::new(attitude.mag_sigma_rad, attitude.gyro_noise_rad_s_rthz, id.max_bias_rad_s);
        self.nodes.start(config.gyro.p_matrix(), Vector3::from(config.gyro.b_rad_s));
    }

    /// Starts at the first sample.
    pub fn start(&mut self, t_us: u64) {
        let WatchSettings { grid, period_us, .. } = self.settings;
        self.accumulator.start(t_us, grid, period_us);
        self.rests.start(period_us);
    }

    /// Learns no new offset from now on.
    pub const fn freeze(&mut self) {
        self.offsets.freeze();
    }

    /// Restarts after a gap: the gyro's frame is lost, the body-fixed offset is not.
    pub fn gap(&mut self, t_us: u64) {
        let WatchSettings { grid, period_us, .. } = self.settings;
        self.accumulator.start(t_us, grid, period_us);
        self.rests.start(period_us);
        self.lose_frame();
    }

    /// The gyro's frame is lost: nothing can be told of a change that is under examination.
    fn lose_frame(&mut self) {
        self.nodes.interrupt();
        if self.state == State::Undecided {
            self.conclude(Verdict::Untold);
        }
    }

    /// Applies a bias of the raw gyro found at rest.
    fn rest(&mut self, bias: &RestBias) {
        let sigma = bias.sigma_rad_s();
        let change = self.nodes.set_bias(bias.rate);
        for filter in [&mut self.tracked, &mut self.iron, &mut self.earth] {
            if sigma * sigma < filter.bias_variance() {
                filter.set_bias(sigma);
            } else {
                filter.shift_bias(&change);
            }
        }
        if self.state == State::Waiting {
            self.prior.bias_rad_s = sigma;
        }
    }

    /// Takes one sample: raw rate, calibrated specific force and field, uncorrected by effects.
    pub fn push(&mut self, t_us: u64, [rate, force, field]: [Reading; 3]) {
        if let Some(Some(rest)) = self.rests.push(rate, force, field, &self.settings.rest_limits) {
            let since_s = t_us.saturating_sub(self.rest_us) as f32 * 1e-6;
            let before = self.rest_bias.map(|bias| bias.predicted(since_s, self.prior.bias_walk_rad_s_rts));
            let bias = before.map_or(RestBias::from_rest(&rest), |bias| bias.updated(&rest));
            (self.rest_bias, self.rest_us) = (Some(bias), t_us);
            self.rest(&bias);
        }
        while let Some(increment) = self.accumulator.close_before(t_us, self.settings.grid) {
            if let Some(node) = self.nodes.push(&increment, self.settings.grid.interval_s(), NODE_S) {
                // A node is valid at its middle.
                self.update(t_us.saturating_sub((0.5e6 * node.time_s) as u64), &node);
            }
        }
        self.accumulator.add(rate, field);
    }

    /// Returns the field to be used now.
    pub fn usable_field(&self) -> UsableField {
        let doubtful = self.state == State::Undecided && self.suspicion.is_doubtful();
        match (doubtful, self.offsets.kept.lasting()) {
            (true, _) => UsableField::Withheld,
            (_, None) => UsableField::Less(Vector3::zeros()),
            (_, Some(interval)) if interval.is_corrected() => UsableField::Less(interval.offset()),
            (_, Some(_)) => UsableField::Withheld,
        }
    }

    /// Variances on each axis of the offset that is subtracted now, microtesla^2; 0 if none is.
    pub fn offset_variances_ut2(&self) -> Vector3<f32> {
        let subtracted = self.offsets.kept.lasting().filter(|interval| interval.is_corrected());
        subtracted.map_or(Vector3::zeros(), |interval| Vector3::from(interval.sigma_ut).map(|sigma| sigma * sigma))
    }

    /// Returns true if an offset that was there from the start has changed: what was learnt of the probe's own iron
    /// holds no more. A magnet that came before the probe had turned counts as its own iron.
    pub const fn own_iron_changed(&self) -> bool {
        self.own_iron_changed
    }

    /// Notes that what was learnt of the probe's own iron is to be forgotten.
    pub const fn own_iron_forgotten(&mut self) {
        self.own_iron_changed = false;
    }

    pub const fn counts(&self) -> HardIronCounts {
        self.offsets.kept.counts
    }

    /// Takes an interval that has begun or ended since it was taken.
    pub fn take_interval(&mut self) -> Option<HardIronInterval> {
        self.offsets.kept.take_news()
    }

    /// Latest intervals, oldest first.
    pub fn intervals(&self) -> impl Iterator<Item = &HardIronInterval> {
        self.offsets.kept.iter()
    }

    /// Norm of the earth's field, microtesla.
    fn field_ut(&self) -> f32 {
        libm::sqrtf(self.tracked.in_earth().norm_squared())
    }

    /// Error of the calibrated field, microtesla.
    fn error_ut(&self) -> f32 {
        self.noise.error_ut(self.field_ut())
    }

    fn update(&mut self, t_us: u64, node: &FieldNode) {
        if node.is_unseen() {
            self.lose_frame();
            return;
        }
        self.noise.turn(node);
        self.turned_rad = at_most(self.turned_rad + node.angle_rad, TOLD_RAD);
        if self.state == State::Waiting {
            if node.fields > 0 {
                self.prior.in_body_ut = self.noise.error_ut(libm::sqrtf(node.field_ut.norm_squared()));
                self.tracked.start(&node.field_ut, &self.prior);
                self.state = State::Tracking;
            }
            return;
        }
        let walk_ut2 = self.noise.walk_ut2(node, self.field_ut());
        self.tracked.predict(node, &self.prior, walk_ut2);
        if self.state == State::Undecided {
            self.iron.predict(node, &self.prior, walk_ut2);
            self.earth.predict(node, &self.prior, walk_ut2);
        }
        if node.fields > 0 {
            if self.state == State::Tracking {
                self.track(t_us, node);
            } else {
                self.compare(t_us, node);
            }
        }
        if !self.tracked.is_sound() {
            self.state = State::Waiting;
            self.offsets.kept.close(t_us);
        }
    }

    /// Tests a node against the single filter's prediction.
    fn track(&mut self, t_us: u64, node: &FieldNode) {
        let error_ut = self.error_ut();
        let noise = self.noise.variance_ut2(error_ut, 1.0);
        let innovation = self.tracked.innovation(node);
        let Some((squared, _)) = innovation.squared(noise) else { return };
        let size2 = innovation.innovation_ut.norm_squared();
        self.unlikely = if squared > IN_A_HUNDRED { self.unlikely.saturating_add(1) } else { 0 };
        let changed = squared > IN_A_MILLION || self.unlikely >= UNLIKELY_NODES;
        if changed && size2 > LEAST_SIZE * LEAST_SIZE * error_ut * error_ut {
            let unknown = self.turned_rad < TOLD_RAD;
            let turned_ut = JUMP_UT * self.noise.recent_rad();
            if unknown && turned_ut * turned_ut > size2 {
                // The offset may have been present from the start, unseen before the first turn.
                self.tracked.inflate(IN_BODY, JUMP_UT);
                self.tracked.inflate(IN_EARTH, JUMP_UT);
                return;
            }
            self.suspect(t_us);
            self.compare(t_us, node);
            return;
        }
        self.calm = if squared > IN_A_THOUSAND {
            0
        } else if self.calm < STEADY_NODES {
            self.calm + 1
        } else {
            STEADY_NODES
        };
        self.noise.learn(squared, noise, &innovation.predicted, node.time_s);
        let noise = self.noise.variance_ut2(error_ut, CORRELATED);
        follow_from(&mut self.tracked, innovation, node, noise, None);
        if squared < IN_TWENTY {
            self.offsets.refine(&self.tracked, t_us, 0.5 * LEAST_SIZE * self.error_ut());
        }
    }

    /// Starts the two hypotheses of a change.
    fn suspect(&mut self, t_us: u64) {
        self.offsets.kept.suspect();
        self.state = State::Undecided;
        self.unlikely = 0;
        self.suspicion = Suspicion::new(t_us, self.calm >= STEADY_NODES);
        self.calm = 0;
        (self.iron, self.earth) = (self.tracked, self.tracked);
        self.iron.inflate(IN_BODY, JUMP_UT);
        self.earth.inflate(IN_EARTH, JUMP_UT);
    }

    /// Compares the hypotheses by a node while the change is undecided.
    fn compare(&mut self, t_us: u64, node: &FieldNode) {
        let error_ut = self.error_ut();
        let (noise, quiet_noise) =
            (self.noise.variance_ut2(error_ut, CORRELATED), self.noise.variance_ut2(error_ut, 1.0));
        let iron = follow(&mut self.iron, node, noise, Some(IN_BODY));
        let earth = follow(&mut self.earth, node, noise, Some(IN_EARTH));
        let unchanged = self.tracked.innovation(node);
        let lost_ut2 = 9.0 * error_ut * error_ut;
        let quiet = unchanged.squared(quiet_noise).is_some_and(|(squared, _)| squared < IN_TWENTY)
            && unchanged.predicted.trace() < 3.0 * lost_ut2;
        let better = if iron.squared < earth.squared { &iron } else { &earth };
        self.noise.learn(better.squared, noise, &better.predicted, node.time_s);

        let jump = self.iron.in_body() - self.tracked.in_body();
        let least_ut = LEAST_SIZE * error_ut;
        let matters = jump.norm_squared() > least_ut * least_ut;
        if let Some(verdict) = self.suspicion.weigh((t_us, node), [&iron, &earth], quiet, matters) {
            self.conclude(verdict);
        }
    }

    /// Ends a suspicion by its verdict, which may end an interval or begin one.
    fn conclude(&mut self, verdict: Verdict) {
        self.state = State::Tracking;
        let matters_ut = LEAST_SIZE * self.error_ut();
        let (before, after) = (self.tracked.in_body(), self.iron.in_body());
        let matters = (after - before).norm_squared() > matters_ut * matters_ut;
        // An offset that was there from the start and has gone is no magnet that came.
        let less = !self.offsets.kept.on && after.norm_squared() < before.norm_squared();
        let gone = verdict == Verdict::Iron && matters && less;
        self.own_iron_changed |= gone;
        let edge_us = self.suspicion.first_us / 2 + self.suspicion.last_us / 2;
        let filters = [&self.tracked, &self.iron];
        if gone && self.offsets.tell_afterwards(filters, edge_us) {
            // It came as an offset that could not be told.
        } else if verdict != Verdict::Iron || !matters || less {
            self.offsets.kept.dismiss();
            if verdict == Verdict::Untold && matters && self.suspicion.is_likely_iron() {
                self.offsets.hold_untold(filters, edge_us);
            }
        } else {
            self.offsets.change(filters, edge_us, matters_ut);
        }
        match verdict {
            Verdict::Iron => self.tracked = self.iron,
            Verdict::Passed => {}
            Verdict::Earth | Verdict::Untold => self.tracked = self.earth,
        }
    }
}

#[cfg(test)]
mod tests;
