use super::{
    chi_square::{CLIPPED, IN_A_HUNDRED, IN_A_MILLION, IN_A_THOUSAND},
    field_filter::{FieldFilter, IN_BODY, IN_EARTH, Prior},
    field_node::{FieldNode, FieldNodes},
    field_noise::{CORRELATED, FieldNoise, TURNING_RAD_S, at_most},
    hard_iron_interval::{HardIronCounts, HardIronInterval},
    hypothesis::{JUMP_UT, follow},
    whitening::Whitening,
};
use crate::{
    config::Config,
    window::{Accumulator, Grid, Reading, RestBias},
};
use nalgebra::{Matrix3, Vector3};

/// Length of a node, seconds: means over so long keep what turns at 300 deg/s, since they are taken in the gyro's frame.
const NODE_S: f32 = 0.2;

/// So many nodes in a row beyond one in a hundred are as unlikely as one beyond one in a million.
const UNLIKELY_NODES: u8 = 3;
/// One hypothesis is taken and the other dropped at this log ratio of their likelihoods: Wald's bound for one error in a million.
const DECIDED: f32 = 13.8;
/// At this log ratio, 20 to 1, an undecided change is likely enough one of the earth's field to be left to the attitude filter, which has
/// its own way with those.
const LIKELY: f32 = 3.0;
/// Most that one node may say for or against, so that no single one decides.
const MOST_OF_A_NODE: f32 = 5.0;
/// An offset must have been steady for so long, seconds: disturbances in passing last 2 s, and edges under 3 s apart are one.
const STEADY_S: f32 = 3.0;
/// The same in nodes. The field is withheld for a change only if it was as predicted for so long before, and what takes longer to come is no
/// magnet that is brought: then the gyro's frame itself is wrong, and there is no telling.
const STEADY_NODES: u8 = 15;
/// Consecutive nodes as predicted after which a disturbance is over (1 s).
const QUIET_NODES: u8 = 5;
/// What cannot be told apart in this time of turning, seconds, is dropped; while the probe stands still it counts by a sixth. The same as
/// for a new field in the attitude filter.
const PATIENCE_S: f32 = 20.0;
const STILL_WEIGHT: f32 = 1.0 / 6.0;
/// A change matters from so many of the calibrated field's errors on.
const LEAST_SIZE: f32 = 2.0;
/// After so much turning since the start an offset that was there from the start has shown, radians: half a turn shows twice its size.
const TOLD_RAD: f32 = core::f32::consts::PI;

/// Intervals kept for the report.
pub(super) const KEPT: usize = 8;

/// What is to be made of the calibrated field now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FieldUse {
    /// Not to be used: it has changed, and it is not known yet how; or the offset is one that must not be learned any more.
    Withheld,
    /// To be used after this offset, microtesla, has been subtracted.
    Less(Vector3<f32>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// No field yet.
    Waiting,
    /// One filter tracks the field.
    Tracking,
    /// The field has changed: a filter in which the iron did, one in which the earth's field did, and one in which nothing has.
    Undecided,
}

/// How a change of the field ended.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Iron,
    Earth,
    Passed,
    Untold,
}

/// The change that is being looked into.
#[derive(Clone, Copy)]
struct Suspicion {
    /// First node that did not fit, and the last one of those after it in which an offset in the body did not stay, microseconds.
    first_us: u64,
    last_us: u64,
    /// Log likelihood of iron over that of the earth's field.
    log_ratio: f32,
    steady_s: f32,
    age_s: f32,
    quiet: u8,
    /// Nodes in which an offset in the body did not stay.
    jumps: u8,
    /// Whether the field was as predicted before.
    sudden: bool,
    /// Whether the offset in the body, if it is one, matters.
    matters: bool,
}

/// Watches for body-fixed magnetic offsets that come and go.
///
/// A filter ([`FieldFilter`]) predicts the field in the frame that the gyro carries along. A change that it does not explain is followed
/// by two more filters: in one the offset fixed in the body has jumped, in the other the field fixed in the earth. While the probe
/// stands still both say the same; as it turns, one of them goes on predicting and the other does not. Until their likelihoods
/// decide, the field is withheld. A constant offset from the start is part of the null hypothesis.
pub(crate) struct HardIronWatch {
    state: State,
    prior: Prior,
    noise: FieldNoise,
    period_us: u32,
    grid: Grid,
    accumulator: Accumulator,
    nodes: FieldNodes,
    rest_us: u64,
    tracked: FieldFilter,
    iron: FieldFilter,
    earth: FieldFilter,
    /// Angle turned since the start, up to [`TOLD_RAD`], radians.
    turned_rad: f32,
    /// Nodes in a row beyond one in a hundred.
    unlikely: u8,
    /// Nodes in a row within one in a thousand, up to [`STEADY_NODES`].
    calm: u8,
    suspicion: Suspicion,
    /// Offset in the body and its variance on each axis before the present interval.
    base_ut: Vector3<f32>,
    base_variance_ut2: Vector3<f32>,
    freeze_us: u64,
    frozen: bool,
    /// Whether the last of the intervals lasts.
    on: bool,
    intervals: [HardIronInterval; KEPT],
    counts: HardIronCounts,
}

impl HardIronWatch {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            state: State::Waiting,
            prior: Prior::zero(),
            noise: FieldNoise::zero(),
            period_us: 0,
            grid: Grid::zero(),
            accumulator: Accumulator::zero(),
            nodes: FieldNodes::zero(),
            rest_us: 0,
            tracked: FieldFilter::zero(),
            iron: FieldFilter::zero(),
            earth: FieldFilter::zero(),
            turned_rad: 0.0,
            unlikely: 0,
            calm: 0,
            suspicion: Suspicion {
                first_us: 0,
                last_us: 0,
                log_ratio: 0.0,
                steady_s: 0.0,
                age_s: 0.0,
                quiet: 0,
                jumps: 0,
                sudden: false,
                matters: false,
            },
            base_ut: zero,
            base_variance_ut2: zero,
            freeze_us: 0,
            frozen: false,
            on: false,
            intervals: [HardIronInterval::NONE; KEPT],
            counts: HardIronCounts { intervals: 0, suspicions: 0, dismissed: 0 },
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let (id, attitude) = (&config.identification, &config.attitude);
        *self = Self::zero();
        self.prior = Prior {
            diagonal: id.prior_sigma_diagonal,
            off_diagonal: id.prior_sigma_off_diagonal,
            bias_rad_s: id.prior_sigma_bias_rad_s,
            lag_s: attitude.mag_timing_sigma_s,
            in_body_ut: 0.0,
            forgetting_s: id.forgetting_s,
            bias_walk_rad_s_rts: attitude.gyro_bias_walk_rad_s_rts,
        };
        self.noise = FieldNoise::new(attitude.mag_sigma_rad, attitude.gyro_noise_rad_s_rthz, id.max_bias_rad_s);
        self.period_us = config.sample_period_us;
        self.grid = Grid::new(config.sample_period_us);
        self.freeze_us = config.freeze_at_us.unwrap_or(u64::MAX);
        self.nodes.start(config.gyro.p_matrix(), Vector3::from(config.gyro.b_rad_s));
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        self.accumulator.start(t_us, self.grid, self.period_us);
    }

    /// Begins again after a gap: the frame is lost, what is fixed in the body is not.
    pub fn gap(&mut self, t_us: u64) {
        self.accumulator.start(t_us, self.grid, self.period_us);
        self.nodes.interrupt();
        if self.state == State::Undecided {
            self.conclude(Verdict::Untold);
        }
    }

    /// A rest has told the bias of the raw gyro.
    pub fn rest(&mut self, rest_us: u64, bias: &RestBias) {
        if rest_us == self.rest_us {
            return;
        }
        self.rest_us = rest_us;
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

    /// Takes one sample: raw rate and calibrated field, as they were read.
    pub fn push(&mut self, t_us: u64, rate: Reading, field: Reading) {
        if t_us >= self.freeze_us {
            self.frozen = true;
        }
        while let Some(increment) = self.accumulator.close_before(t_us, self.grid) {
            if let Some(node) = self.nodes.push(&increment, self.grid.interval_s(), NODE_S) {
                // Valid at its middle.
                self.take(t_us.saturating_sub((0.5e6 * node.time_s) as u64), &node);
            }
        }
        self.accumulator.add(rate, Reading::Missing, field);
    }

    /// What is to be made of the calibrated field now.
    pub fn field_use(&self) -> FieldUse {
        let Suspicion { log_ratio, sudden, matters, .. } = self.suspicion;
        let doubtful = self.state == State::Undecided && log_ratio > -LIKELY && matters && sudden;
        match (doubtful, self.last().filter(|_| self.on)) {
            (true, _) => FieldUse::Withheld,
            (_, None) => FieldUse::Less(Vector3::zeros()),
            (_, Some(interval)) if interval.corrected => FieldUse::Less(interval.offset()),
            (_, Some(_)) => FieldUse::Withheld,
        }
    }

    pub const fn counts(&self) -> HardIronCounts {
        self.counts
    }

    /// The latest intervals, the oldest first.
    pub fn intervals(&self) -> impl Iterator<Item = &HardIronInterval> {
        let count = self.counts.intervals as usize;
        (count.saturating_sub(KEPT)..count).filter_map(|number| self.intervals.get(number % KEPT))
    }

    fn last(&self) -> Option<&HardIronInterval> {
        self.intervals.get((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    fn last_mut(&mut self) -> Option<&mut HardIronInterval> {
        self.intervals.get_mut((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    /// The earth's field, microtesla.
    fn field_ut(&self) -> f32 {
        libm::sqrtf(self.tracked.in_earth().norm_squared())
    }

    /// Error of the calibrated field, microtesla.
    fn error_ut(&self) -> f32 {
        self.noise.error_ut(self.field_ut())
    }

    fn take(&mut self, t_us: u64, node: &FieldNode) {
        let rate_rad_s = node.angle_rad / node.time_s;
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
                self.compare(t_us, node, rate_rad_s);
            }
        }
        if !self.tracked.is_sound() {
            self.state = State::Waiting;
            self.close(t_us);
        }
    }

    /// One filter: is the node as predicted?
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
                // Never seen before turning, and it may have been there all the time.
                self.tracked.open(IN_BODY, JUMP_UT);
                self.tracked.open(IN_EARTH, JUMP_UT);
                return;
            }
            self.counts.suspicions = self.counts.suspicions.saturating_add(1);
            self.state = State::Undecided;
            self.unlikely = 0;
            self.suspicion = Suspicion {
                first_us: t_us,
                last_us: t_us,
                log_ratio: 0.0,
                steady_s: 0.0,
                age_s: 0.0,
                quiet: 0,
                jumps: 0,
                sudden: self.calm >= STEADY_NODES,
                matters: false,
            };
            self.calm = 0;
            (self.iron, self.earth) = (self.tracked, self.tracked);
            self.iron.open(IN_BODY, JUMP_UT);
            self.earth.open(IN_EARTH, JUMP_UT);
            self.compare(t_us, node, node.angle_rad / node.time_s);
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
        follow(&mut self.tracked, node, noise, None);
        if self.on && squared < CLIPPED {
            self.refine(t_us);
        }
    }

    /// Two hypotheses: which of them predicts what follows?
    fn compare(&mut self, t_us: u64, node: &FieldNode, rate_rad_s: f32) {
        let error_ut = self.error_ut();
        let (noise, quiet_noise) =
            (self.noise.variance_ut2(error_ut, CORRELATED), self.noise.variance_ut2(error_ut, 1.0));
        let iron = follow(&mut self.iron, node, noise, Some(IN_BODY));
        let earth = follow(&mut self.earth, node, noise, Some(IN_EARTH));
        let unchanged = self.tracked.innovation(node);
        let lost_ut2 = 9.0 * error_ut * error_ut;
        let quiet = unchanged.squared(quiet_noise).is_some_and(|(squared, _)| squared < CLIPPED)
            && unchanged.predicted.trace() < 3.0 * lost_ut2;
        let better = if iron.squared < earth.squared { &iron } else { &earth };
        let (squared, predicted) = (better.squared, better.predicted);
        self.noise.learn(squared, noise, &predicted, node.time_s);

        let jump = self.iron.in_body() - self.tracked.in_body();
        let least_ut = LEAST_SIZE * error_ut;
        let suspicion = &mut self.suspicion;
        suspicion.matters = jump.norm_squared() > least_ut * least_ut;
        let ratio = iron.log_likelihood - earth.log_likelihood;
        suspicion.log_ratio += at_most(if ratio > -MOST_OF_A_NODE { ratio } else { -MOST_OF_A_NODE }, MOST_OF_A_NODE);
        if iron.reopened {
            (suspicion.last_us, suspicion.steady_s) = (t_us, 0.0);
            suspicion.jumps = suspicion.jumps.saturating_add(1);
        } else {
            suspicion.steady_s += node.time_s;
        }
        suspicion.age_s += node.time_s * if rate_rad_s > TURNING_RAD_S { 1.0 } else { STILL_WEIGHT };
        suspicion.quiet = if quiet { suspicion.quiet.saturating_add(1) } else { 0 };
        let verdict = if suspicion.log_ratio > DECIDED && suspicion.steady_s > STEADY_S {
            Verdict::Iron
        } else if suspicion.log_ratio < -DECIDED {
            Verdict::Earth
        } else if !suspicion.matters && suspicion.steady_s > STEADY_S {
            if suspicion.log_ratio > 0.0 { Verdict::Iron } else { Verdict::Earth }
        } else if suspicion.quiet >= QUIET_NODES {
            Verdict::Passed
        } else if suspicion.age_s > PATIENCE_S || suspicion.jumps > STEADY_NODES {
            Verdict::Untold
        } else {
            return;
        };
        self.conclude(verdict);
    }

    fn conclude(&mut self, verdict: Verdict) {
        self.state = State::Tracking;
        let edge_us = self.suspicion.first_us / 2 + self.suspicion.last_us / 2;
        let matters_ut = LEAST_SIZE * self.error_ut();
        let (before, after) = (self.tracked.in_body(), self.iron.in_body());
        let matters = (after - before).norm_squared() > matters_ut * matters_ut;
        // What was there from the start and has gone is no magnet that came.
        let less = !self.on && after.norm_squared() < before.norm_squared();
        if verdict != Verdict::Iron || !matters || less {
            self.counts.dismissed = self.counts.dismissed.saturating_add(1);
            match verdict {
                Verdict::Iron => self.tracked = self.iron,
                Verdict::Passed => {}
                Verdict::Earth | Verdict::Untold => self.tracked = self.earth,
            }
            return;
        }
        let covariance = self.iron.in_body_covariance();
        if self.on {
            self.close(edge_us);
            let left = self.iron.in_body() - self.base_ut;
            let spread = covariance + Matrix3::from_diagonal(&self.base_variance_ut2);
            self.tracked = self.iron;
            if left.norm_squared() < matters_ut * matters_ut || is_same(&left, &spread) {
                return;
            }
        } else {
            self.base_ut = self.tracked.in_body();
            self.base_variance_ut2 = self.tracked.in_body_covariance().diagonal();
            self.tracked = self.iron;
        }
        let offset = self.tracked.in_body() - self.base_ut;
        let variance = covariance.diagonal() + self.base_variance_ut2;
        if is_same(&offset, &Matrix3::from_diagonal(&variance)) {
            self.counts.dismissed = self.counts.dismissed.saturating_add(1);
            return;
        }
        let known = self.intervals().find(|known| {
            let other = known.offset() - offset;
            let spread = covariance + Matrix3::from_diagonal(&Vector3::from(known.sigma_ut).map(|s| s * s));
            known.corrected && (other.norm_squared() < matters_ut * matters_ut || is_same(&other, &spread))
        });
        let learned = HardIronInterval {
            from_us: edge_us,
            to_us: None,
            offset_ut: offset.into(),
            sigma_ut: variance.map(libm::sqrtf).into(),
            corrected: true,
        };
        let interval = match (self.frozen, known) {
            (false, _) => learned,
            (true, Some(known)) => HardIronInterval { from_us: edge_us, to_us: None, ..*known },
            (true, None) => HardIronInterval { corrected: false, ..learned },
        };
        if let Some(slot) = self.intervals.get_mut(self.counts.intervals as usize % KEPT) {
            *slot = interval;
        }
        self.counts.intervals = self.counts.intervals.wrapping_add(1);
        self.on = true;
    }

    /// The interval that lasts, if one does, ends.
    fn close(&mut self, t_us: u64) {
        if core::mem::take(&mut self.on)
            && let Some(last) = self.last_mut()
        {
            last.to_us = Some(t_us);
        }
    }

    /// The offset of the interval that lasts becomes more certain; or it has gone so slowly that no node told.
    fn refine(&mut self, t_us: u64) {
        let offset = self.tracked.in_body() - self.base_ut;
        let least_ut = 0.5 * LEAST_SIZE * self.error_ut();
        if offset.norm_squared() < least_ut * least_ut {
            self.close(t_us);
        }
        if self.frozen || !self.on {
            return;
        }
        let variance = self.tracked.in_body_covariance().diagonal() + self.base_variance_ut2;
        if let Some(last) = self.last_mut() {
            last.offset_ut = offset.into();
            last.sigma_ut = variance.map(libm::sqrtf).into();
        }
    }
}

fn is_same(difference: &Vector3<f32>, spread: &Matrix3<f32>) -> bool {
    Whitening::new(spread).is_some_and(|whitening| whitening.apply(difference).norm_squared() < IN_A_HUNDRED)
}

#[cfg(test)]
mod tests;
