//! Identifier: passes samples to the estimator, does its work in pieces, and lets each result fly at the instant that
//! the schedule has fixed. It holds no statistics of its own.

use super::{
    Decision, Refusal, WindowCost, WindowReport,
    flying::{Flight, deg_per_turn},
    schedule::{Schedule, Update},
    search::Search,
};
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel, Theta},
    config::Config,
    diagnosis::{DiagnosisReport, Findings},
    estimator::{CandidateId, CandidateSet, Estimator, KnownAttitude, Settings, turned_back},
    optimizer::{Cost, Progress},
    sample::{Reading, TurnFlags},
};
#[cfg(feature = "storage")]
use crate::{
    diagnosis::as_estimated,
    estimator::{Learnt, LearntHead, NotContinued},
};
use heapless::{Deque, Vec};

/// Work units, as the estimator's, of one evaluation of a window's cost: some 100 nodes of nine rows.
const EVALUATION_UNITS: u32 = 170;

/// Work units of judging a posterior, or the result of a search.
const JUDGE_UNITS: u32 = 180;

/// Facts about an update that has taken effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Taken {
    /// Deviations of the model that flies now.
    pub sigma: Theta,
    /// True if the effects that are taken out have changed.
    pub effects: bool,
    /// True if the effects of the magnetometer that are taken out have changed.
    pub of_field: bool,
    /// True if a window closed with it.
    pub is_window: bool,
}

/// Makes the estimator's results fly at fixed instants.
pub(crate) struct Identifier<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> {
    estimator: Estimator<f32, NODES, COLUMNS>,
    schedule: Schedule<WindowReport>,
    findings: Findings<REPORTS>,
    state: State,
    /// Report of the window that is being searched.
    searched: Vec<WindowReport, 1>,
    search: Search,
    /// Reports waiting to be polled.
    pending: Deque<WindowReport, REPORTS>,
}

/// State that the samples since the configuration have left, beside that of the parts. A new configuration resets it as
/// one value.
struct State {
    flown: GyroModel,
    /// Sample from which it flies, microseconds; 0: since the start.
    flown_since_us: u64,
    bias_only: GyroModel,
    /// Latest sample that the flown bias comes from, microseconds; 0 for none.
    bias_known_us: u64,
    /// Cost of the posterior's mean on the searched window.
    cost_of_mean: f32,
    /// Reports dropped because nobody polled them.
    reports_lost: u32,
    overruns: u32,
    /// Turns about which the sensors do not agree: while there are any, no P is accepted.
    mounting_wrong: TurnFlags,
}

impl State {
    /// Flies a model, of which nothing was learnt.
    const fn of(model: GyroModel) -> Self {
        Self {
            flown: model,
            flown_since_us: 0,
            bias_only: model,
            bias_known_us: 0,
            cost_of_mean: 0.0,
            reports_lost: 0,
            overruns: 0,
            mounting_wrong: TurnFlags::empty(),
        }
    }
}

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Identifier<NODES, COLUMNS, REPORTS> {
    pub const fn zero() -> Self {
        Self {
            estimator: Estimator::zero(),
            schedule: Schedule::zero(),
            findings: Findings::zero(),
            state: State::of(GyroModel::UNSET),
            searched: Vec::new(),
            search: Search::None,
            pending: Deque::new(),
        }
    }

    /// Forgets everything learnt, and looks for the effects of a library.
    pub fn configure(&mut self, config: &Config, library: &'static [&'static dyn Effect]) {
        self.estimator.configure(&Settings::new(config), if config.effects { library } else { &[] });
        self.schedule.configure(config);
        self.findings.start();
        self.state = State::of(config.gyro);
        self.searched.clear();
        self.search = Search::None;
        self.pending.clear();
    }

    /// Flies this model, known with these deviations, from the first sample on. Call it between
    /// `configure` and `start`.
    #[cfg(feature = "storage")]
    pub fn restore(&mut self, config: &Config, gyro: &GyroModel, sigma: &Theta, effects: &ActiveEffects) {
        self.state.flown = *gyro;
        self.findings.restore(effects);
        self.estimator.restore(gyro, sigma, &as_estimated(effects, self.estimator.library(), config));
        self.estimator.compose_with(gyro);
    }

    /// Returns what the estimator has learnt; `None` while it is being updated.
    #[cfg(feature = "storage")]
    pub fn learnt(&self, config: &Config) -> Option<Learnt<'_>> {
        self.estimator.learnt(LearntHead::fingerprint(config))
    }

    /// Goes on from what was learnt before, as `read` hands it out number by number. Call it between `configure` and
    /// `start`.
    ///
    /// # Errors
    /// The reason; the estimator then starts without what was learnt.
    #[cfg(feature = "storage")]
    pub fn go_on(
        &mut self,
        head: &LearntHead,
        config: &Config,
        read: impl FnOnce(&mut dyn FnMut(usize, f32)) -> bool,
    ) -> Result<(), NotContinued> {
        if head.fingerprint != LearntHead::fingerprint(config) {
            return Err(NotContinued::OtherFilter);
        }
        let estimator = &mut self.estimator;
        if !read(&mut |k, number| estimator.set_learnt(k, number)) {
            self.estimator.drop_learnt();
            return Err(NotContinued::Incomplete);
        }
        self.estimator.go_on(head.motion_s)
    }

    pub const fn flown(&self) -> &GyroModel {
        &self.state.flown
    }

    /// Sample from which the flown model flies, microseconds; `None`: since the start.
    pub const fn flown_since_us(&self) -> Option<u64> {
        if self.state.flown_since_us > 0 { Some(self.state.flown_since_us) } else { None }
    }

    /// Turns about which the sensors do not agree.
    pub const fn mounting_wrong(&self) -> TurnFlags {
        self.state.mounting_wrong
    }

    /// Sets the turns about which the sensors do not agree: while there are any, no P is accepted.
    pub const fn mistrust_mounting(&mut self, wrong: TurnFlags) {
        self.state.mounting_wrong = wrong;
    }

    /// Returns the number of reports that nobody polled, and of updates that came too late.
    pub const fn reports_lost_and_overruns(&self) -> [u32; 2] {
        [self.state.reports_lost, self.state.overruns]
    }

    /// Returns the number of increments that the estimator has lost.
    pub const fn increments_lost(&self) -> u32 {
        self.estimator.lost()
    }

    /// Lets nothing new take effect after an instant.
    pub fn freeze(&mut self, at_us: u64) {
        self.schedule.freeze(at_us);
    }

    /// Instant from which nothing new takes effect; `u64::MAX`: never.
    pub const fn freeze_us(&self) -> u64 {
        self.schedule.freeze_us()
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        self.schedule.start(t_us);
    }

    /// Notes a gap in the samples, which is longer than their times say by `longer_s`.
    pub fn gap(&mut self, last_us: u64, t_us: u64, longer_s: f32) {
        self.schedule.gap(last_us, t_us);
        if longer_s > 0.0 {
            self.estimator.wait(longer_s);
        }
    }

    /// Returns true if the instant of an update has come, with a result or without.
    pub fn is_due(&self, t_us: u64) -> bool {
        self.schedule.is_due(t_us)
    }

    /// Lets a result that is due take effect, before a sample is compensated.
    pub fn take_effect(&mut self, t_us: u64, config: &Config) -> Option<Taken> {
        let (update, result) = self.schedule.take_effect(t_us)?;
        // A search that still runs comes too late.
        self.searched.clear();
        let Some(mut report) = result else {
            self.findings.drop_waiting();
            self.state.overruns = self.state.overruns.saturating_add(1);
            let report = self.flight(config, &update).without_result(&update, Refusal::Overrun);
            self.announce(&update, report);
            return None;
        };
        report.t_effect_us = Some(t_us);
        self.state.bias_only = report.bias_only;
        let has_changed = report.flown != self.state.flown;
        if has_changed {
            (self.state.flown, self.state.flown_since_us) = (report.flown, t_us);
            self.estimator.compose_with(&self.state.flown);
            self.state.bias_known_us = report.t_end_us;
        }
        let effects = self.findings.take_effect(t_us, update.is_window, self.estimator.library());
        self.announce(&update, report);
        (has_changed || effects.is_some()).then_some(Taken {
            sigma: report.sigma,
            effects: effects.is_some(),
            of_field: effects.unwrap_or(false),
            is_window: update.is_window,
        })
    }

    /// Takes one sample: raw rate, calibrated specific force and field; temperature over the effects' reference
    /// temperature, K. Returns true if [`Identifier::look`] can ask for the attitude of this instant.
    pub fn push(&mut self, t_us: u64, readings: [Reading; 3], warming_k: Option<f32>) -> bool {
        if self.schedule.is_over() {
            return false;
        }
        let can_look = self.estimator.push(t_us, readings, warming_k);
        if let Some(update) = self.schedule.push(t_us) {
            self.estimator.close(NODES > 0 && update.is_window);
        }
        can_look
    }

    /// Has the estimator forget the hard iron that it has learnt: it has changed. Returns false if there is no room for
    /// the request now.
    pub fn forget_iron(&mut self) -> bool {
        self.estimator.forget_iron()
    }

    /// Asks for the estimator's attitude at the sample just pushed.
    pub fn look(&mut self) {
        self.estimator.look();
    }

    /// Attitude at the last instant for which it was asked, if the work has come so far.
    pub fn known_attitude(&self) -> Option<&KnownAttitude> {
        self.estimator.known_attitude()
    }

    /// Does one bounded piece of work; returns its size in units, 0 when there is nothing to do.
    pub fn step(&mut self, config: &Config) -> u32 {
        let Some(update) = self.schedule.asked() else { return self.estimator.step() };
        if !self.searched.is_empty() {
            // The estimator stands still during a search, so the window is searched as it closed.
            return self.step_search();
        }
        if self.estimator.posterior().is_none() {
            return self.estimator.step();
        }
        self.judge(&update, config)
    }

    /// Judges the posterior: it is the result of an update, or the beginning of a window's search.
    #[inline(never)]
    fn judge(&mut self, update: &Update, config: &Config) -> u32 {
        let Some(posterior) = self.estimator.posterior() else { return 0 };
        let flight = self.flight(config, update);
        let mut report = flight.judged(update, posterior);
        let fitness = flight.fitness(posterior);
        let window_us = [update.window_start_us, update.t_us];
        let flies = report.decision == Decision::Accepted;
        self.findings.judge(window_us, &self.estimator, (fitness, flies), config);
        if update.is_window {
            self.estimator.start_remainder();
        }
        let cost = self.estimator.window_cost().filter(|_| report.decision == Decision::Accepted);
        let Some(cost) = cost else {
            self.schedule.conclude(report);
            return JUDGE_UNITS;
        };
        let finite = |cost: f32| cost.is_finite().then_some(cost);
        report.cost_before = finite(cost.evaluate(&cost.coordinates(&self.state.flown)));
        self.state.cost_of_mean = cost.evaluate(&[0.0; 12]);
        report.cost_after = finite(self.state.cost_of_mean);
        let id = &config.identification;
        self.search = Search::new(id.optimizer, id.max_evaluations, config.seed ^ update.since_start_us);
        // The slot was emptied when the update before took effect, so there is room.
        let _ = self.searched.push(report);
        2 * EVALUATION_UNITS + JUDGE_UNITS
    }

    /// Does a piece of the search. Its result flies where it costs less than the posterior's mean.
    #[inline(never)]
    fn step_search(&mut self) -> u32 {
        let cost = self.estimator.window_cost();
        if let Some(cost) = &cost
            && self.search.step(cost) == Progress::Running
        {
            return EVALUATION_UNITS;
        }
        let Some(mut report) = self.searched.pop() else { return 0 };
        report.evaluations = self.search.evaluations();
        if let (Some(cost), Some((y, found))) = (cost, self.search.best()) {
            let model = cost.model(&y);
            let is_better = found < self.state.cost_of_mean && model.is_valid();
            report.cost_gained_by_search = Some(if is_better { self.state.cost_of_mean - found } else { 0.0 });
            if is_better {
                report.cost_after = Some(found);
                (report.fitted, report.flown) = (model, model);
                report.deg_per_turn = deg_per_turn(&self.state.flown, &model);
            }
        }
        self.schedule.conclude(report);
        JUDGE_UNITS
    }

    fn flight<'a>(&'a self, config: &'a Config, update: &Update) -> Flight<'a> {
        // A window is far shorter than the hour that 32 bits of microseconds hold.
        let window_s = update.t_us.saturating_sub(update.window_start_us) as u32 / 1_000_000;
        let estimator = &self.estimator;
        // The bias of the posterior has nothing in it of what it takes out, whichever way the probe points, and at the
        // rest all of the others.
        let [still, read] = estimator.still();
        let taken_out = estimator.posterior().map_or(CandidateSet::EMPTY, |posterior| posterior.taken_out);
        let moment = |index: u8| if taken_out.has(CandidateId::new(index.into())) { &still } else { &read };
        let of_effects = self.findings.flown().added_to_rate(estimator.library(), moment);
        Flight {
            config,
            flown: &self.state.flown,
            bias_only: &self.state.bias_only,
            of_effects_at_rest_rad_s: turned_back(&self.state.flown, &of_effects),
            rest_is_news: self.estimator.last_rest_us().is_some_and(|us| us > self.state.bias_known_us),
            rest_s: self.estimator.rest_seconds(window_s) as f32,
            mounting_wrong: self.state.mounting_wrong,
        }
    }

    /// Hands out the report of an update that closes a window.
    fn announce(&mut self, update: &Update, report: WindowReport) {
        if update.is_window && self.pending.push_back(report).is_err() {
            self.state.reports_lost = self.state.reports_lost.saturating_add(1);
        }
    }

    /// Returns the oldest report that nobody has taken.
    pub fn take_report(&mut self) -> Option<WindowReport> {
        self.pending.pop_front()
    }

    /// Returns the effects that are taken out.
    pub const fn effects(&self) -> &ActiveEffects {
        self.findings.flown()
    }

    /// Returns the oldest report of the effects that nobody has taken.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.findings.take()
    }

    /// Returns the number of reports of the effects that nobody took.
    pub const fn diagnoses_lost(&self) -> u32 {
        self.findings.lost
    }

    #[cfg(feature = "explanation")]
    pub const fn estimator(&self) -> &Estimator<f32, NODES, COLUMNS> {
        &self.estimator
    }

    /// Returns the cost that the search of the latest window minimises.
    pub fn window_cost(&self) -> Option<WindowCost<'_, NODES>> {
        self.estimator.window_cost()
    }
}

#[cfg(all(test, feature = "storage"))]
mod tests;
