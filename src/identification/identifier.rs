use super::{
    Carried, Decision, Refusal, WindowCost, WindowReport,
    judgement::unidentified,
    prior::theta_of,
    window_fit::{Context, Job, Step, WindowFit},
};
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel},
    config::Config,
    diagnosis::{Diagnosis, DiagnosisJob, DiagnosisReport, History, Subject},
    window::{Reading, Rebuild, RestLimits, SampleStream, Scales, StreamSettings},
};
use core::mem::ManuallyDrop;
use heapless::{Deque, Vec};

/// Reports waiting to be polled.
const PENDING: usize = 4;

/// Latest samples that a diagnosis looks at, seconds: fewer than are kept, so that it has time to go through them again and again before
/// they are overwritten. One begins where the one before ended.
const DIAGNOSIS_S: f32 = 36.0;

/// What a diagnosis finds takes effect this long after it began, seconds.
const DIAGNOSIS_LATENCY_S: f32 = 10.0;

/// Increments whose test windows are made anew in one piece of work.
const REBUILT_IN_A_STEP: u32 = 16;

/// Work units of judging a fit.
const JUDGE_UNITS: u32 = 500;

/// Whether a window is being identified.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Idle,
    /// The test windows are made anew, without the effects that have been found since they were.
    Rebuilding,
    Fitting,
    /// The result waits for its instant.
    Ready,
}

/// The memory of a fit and that of a diagnosis, which never run at the same time, in one place.
///
/// With a tag of its own, so that nothing to do is all zeros.
#[expect(clippy::large_enum_variant, reason = "the variants share static memory")]
#[repr(u8)]
enum Work {
    Nothing,
    // Nothing in either has to be dropped; with drop glue an assignment goes by way of the stack.
    Rebuild(ManuallyDrop<Rebuild>),
    Fit(ManuallyDrop<WindowFit>),
    Diagnosis(ManuallyDrop<Diagnosis>),
}

impl Work {
    // Functions of their own, so that the all-zero values are written where they belong and never stand on the stack.

    #[inline(never)]
    fn begin_rebuild(&mut self) {
        *self = Self::Rebuild(ManuallyDrop::new(Rebuild::zero()));
    }

    #[inline(never)]
    fn begin_fit(&mut self) {
        if !matches!(self, Self::Fit(_)) {
            *self = Self::Fit(ManuallyDrop::new(WindowFit::zero()));
        }
    }

    #[inline(never)]
    fn begin_diagnosis(&mut self) {
        if !matches!(self, Self::Diagnosis(_)) {
            *self = Self::Diagnosis(ManuallyDrop::new(Diagnosis::zero()));
        }
    }
}

/// Windows of samples in, accepted models or reasoned refusals out.
pub(crate) struct Identifier {
    pub stream: SampleStream,
    config: Config,
    flown: GyroModel,
    /// First sample and increment since the start or the last gap.
    stream_start_us: u64,
    stream_from: u32,
    next_close_us: u64,
    final_close_us: u64,
    freeze_us: u64,
    /// Until when the samples' lessons are in what the fit carries: no later window may hold them.
    learned_until_us: u64,
    /// End of the latest window that the flown bias comes from; 0: none.
    bias_known_us: u64,
    /// The window that is fitted, or was the last to be.
    job: Job,
    /// What the samples before it taught.
    carried: Carried,
    state: State,
    work: Work,
    /// The diagnosis that is to begin as soon as no window is fitted.
    to_diagnose: Option<DiagnosisJob>,
    history: History,
    next_diagnosis_us: u64,
    final_diagnosis_us: u64,
    diagnosis_effect_us: u64,
    /// The report of a diagnosis that waits for its instant.
    waiting: Vec<DiagnosisReport, 1>,
    /// The latest diagnosis that has taken effect, until somebody takes it.
    diagnosed: Vec<DiagnosisReport, 1>,
    /// Whether the test windows that are kept were made with other effects.
    stale_tests: bool,
    /// The result of the job, once it is judged.
    result: Vec<WindowReport, 1>,
    pending: Deque<WindowReport, PENDING>,
    /// Reports dropped because nobody polled them.
    pub reports_lost: u32,
    pub overruns: u32,
    pub diagnosis_overruns: u32,
    pub diagnoses_lost: u32,
}

impl Identifier {
    pub const fn zero() -> Self {
        Self {
            stream: SampleStream::zero(),
            config: Config::UNSET,
            flown: GyroModel::UNSET,
            stream_start_us: 0,
            stream_from: 0,
            next_close_us: 0,
            final_close_us: 0,
            freeze_us: 0,
            learned_until_us: 0,
            bias_known_us: 0,
            job: Job::zero(),
            carried: Carried::nothing(),
            state: State::Idle,
            work: Work::Nothing,
            to_diagnose: None,
            history: History::zero(),
            next_diagnosis_us: 0,
            final_diagnosis_us: 0,
            diagnosis_effect_us: 0,
            waiting: Vec::new(),
            diagnosed: Vec::new(),
            stale_tests: false,
            result: Vec::new(),
            pending: Deque::new(),
            reports_lost: 0,
            overruns: 0,
            diagnosis_overruns: 0,
            diagnoses_lost: 0,
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let id = config.identification;
        self.config = *config;
        self.flown = config.gyro;
        self.final_close_us = config.freeze_at_us.map_or(u64::MAX, |t| t.saturating_sub(micros(id.latency_s)));
        self.freeze_us = config.freeze_at_us.unwrap_or(u64::MAX);
        // What the last diagnosis finds is there when the last window is fitted.
        let diagnosis_s = DIAGNOSIS_LATENCY_S;
        self.final_diagnosis_us = self.final_close_us.saturating_sub(micros(diagnosis_s));
        self.diagnosed.clear();
        self.stale_tests = false;
        // Ranges of the stored increments where the full scale is unknown: 4000 deg/s and 32 g, the widest of the parts in use,
        // and ten times the strongest field on earth.
        self.stream.configure(&StreamSettings {
            sample_period_us: config.sample_period_us,
            rest_limits: RestLimits { deviation_rad_s: id.rest_gyro_deviation_rad_s, bias_rad_s: id.max_bias_rad_s },
            bias_walk_rad_s_rts: config.attitude.gyro_bias_walk_rad_s_rts,
            gravity_m_s2: config.earth.gravity_m_s2,
            scales: Scales::new(
                config.full_scale.gyro_rad_s.unwrap_or(70.0),
                2.0 * config.full_scale.accel_m_s2.unwrap_or(160.0),
                2.0 * config.full_scale.mag_ut.unwrap_or(330.0),
            ),
        });
        self.learned_until_us = 0;
        self.bias_known_us = 0;
        self.carried = Carried::nothing();
        self.work = Work::Nothing;
        self.to_diagnose = None;
        self.diagnosis_effect_us = 0;
        self.history = History::zero();
        self.waiting.clear();
        self.state = State::Idle;
        self.pending.clear();
        self.reports_lost = 0;
        self.overruns = 0;
        self.diagnosis_overruns = 0;
        self.diagnoses_lost = 0;
    }

    pub const fn flown(&self) -> &GyroModel {
        &self.flown
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        self.stream.start(t_us, &theta_of(&self.flown));
        self.start_window(t_us);
        self.schedule_diagnosis(t_us);
    }

    /// A gap: the window in progress ends with the last sample before it, and another begins after it. Nobody works during a
    /// gap, so it does not count into a result's latency; but after a freeze nothing new takes effect, except a result that was
    /// due in the gap and is ready.
    pub fn gap(&mut self, last_us: u64, t_us: u64) {
        let latest_us = if self.freeze_us > t_us { self.freeze_us } else { t_us };
        let delayed = |effect_us: u64| {
            let effect_us = effect_us.saturating_add(t_us - last_us);
            if effect_us > latest_us { latest_us } else { effect_us }
        };
        self.job.effect_us = delayed(self.job.effect_us);
        if self.next_close_us != u64::MAX {
            let effect_us = delayed(last_us.saturating_add(micros(self.config.identification.latency_s)));
            self.close(last_us, effect_us, true);
        }
        self.stream.restart(t_us);
        self.start_window(t_us);
    }

    fn start_window(&mut self, t_us: u64) {
        self.stream_start_us = t_us;
        self.stream_from = self.stream.increments.count();
        self.schedule(t_us, t_us.saturating_add(micros(self.config.identification.window_s)));
    }

    /// Sets the next close: the regular one, or the last one before the freeze where that comes first or so soon after that
    /// the regular one's result would not have landed.
    fn schedule(&mut self, now_us: u64, regular_us: u64) {
        self.next_close_us = if now_us >= self.final_close_us {
            u64::MAX
        } else if regular_us.saturating_add(micros(self.config.identification.latency_s)) > self.final_close_us {
            self.final_close_us
        } else {
            regular_us
        };
    }

    /// Sets when the next diagnosis begins; the last one before a freeze begins early enough for what it finds.
    fn schedule_diagnosis(&mut self, now_us: u64) {
        let regular_us = now_us.saturating_add(micros(DIAGNOSIS_S));
        let latency_us = micros(DIAGNOSIS_LATENCY_S);
        self.next_diagnosis_us = if now_us >= self.final_diagnosis_us {
            u64::MAX
        } else if regular_us.saturating_add(latency_us) > self.final_diagnosis_us {
            self.final_diagnosis_us
        } else {
            regular_us
        };
    }

    /// Begins a diagnosis of the latest samples.
    fn start_diagnosis(&mut self, t_us: u64) {
        let count = self.stream.increments.count();
        let most = self.stream.grid.increments_in(DIAGNOSIS_S) as u32;
        let from = self.stream_from.max(count.saturating_sub(most));
        let length_us = u64::from(count - from) * u64::from(self.stream.grid.interval_us);
        let job = DiagnosisJob {
            t_start_us: t_us.saturating_sub(length_us),
            t_end_us: t_us,
            from,
            to: count,
            flown: self.flown,
        };
        self.diagnosis_effect_us = t_us.saturating_add(micros(DIAGNOSIS_LATENCY_S));
        self.to_diagnose = Some(job);
    }

    /// Before a sample is compensated: a diagnosis that is due takes effect, or was not done in time. Returns whether the effects
    /// changed.
    pub fn take_diagnosed(&mut self, t_us: u64) -> bool {
        if self.diagnosis_effect_us == 0 || t_us < self.diagnosis_effect_us {
            return false;
        }
        self.diagnosis_effect_us = 0;
        let Some(mut report) = self.waiting.pop() else {
            self.diagnosis_overruns = self.diagnosis_overruns.saturating_add(1);
            return false;
        };
        report.t_effect_us = t_us;
        let effects = report.active();
        if self.diagnosed.pop().is_some() {
            self.diagnoses_lost = self.diagnoses_lost.saturating_add(1);
        }
        // Just emptied, so there is room.
        let _ = self.diagnosed.push(report);
        let changed = effects != *self.stream.effects() && report.is_conclusive();
        if changed {
            self.stream.set_effects(&effects);
            self.stale_tests = true;
        }
        changed
    }

    /// The oldest diagnosis that nobody has taken.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.diagnosed.pop()
    }

    /// Before a sample is compensated: a result that is due takes effect. If the model changed, the deviations of the new one, P
    /// row-major, then b, rad/s.
    pub fn take_effect(&mut self, t_us: u64) -> Option<[f32; 12]> {
        if self.state == State::Idle || t_us < self.job.effect_us {
            return None;
        }
        let ready = self.state == State::Ready;
        self.state = State::Idle;
        let Some(mut report) = self.result.pop().filter(|_| ready) else {
            let job = self.job;
            self.announce_overrun(&job);
            return None;
        };
        report.t_effect_us = Some(t_us);
        let changed = (report.flown != self.flown).then_some(report.sigma);
        if changed.is_some() {
            self.stream.change_model(&theta_of(&report.flown));
            self.flown = report.flown;
            self.bias_known_us = report.t_end_us;
        }
        self.announce(report);
        changed
    }

    /// Takes one sample (raw rate, calibrated vectors).
    pub fn push(&mut self, t_us: u64, [rate, gravity, field]: [Reading; 3], temperature_c: Option<f32>) {
        self.stream.push(t_us, rate, gravity, field, temperature_c);
        if t_us >= self.next_diagnosis_us {
            if self.config.effects {
                self.start_diagnosis(t_us);
            }
            self.schedule_diagnosis(t_us);
        }
        if t_us >= self.next_close_us {
            // The last window before a freeze closes at its first sample at or after the instant that leaves it the latency: by less
            // than a sample period its result would come after the freeze.
            let effect_us = t_us.saturating_add(micros(self.config.identification.latency_s));
            self.close(t_us, if effect_us < self.freeze_us { effect_us } else { self.freeze_us }, false);
            self.schedule(t_us, t_us.saturating_add(micros(self.config.identification.step_s)));
        }
    }

    /// Closes the window in progress: a job, or at once a report of why there is none.
    fn close(&mut self, t_us: u64, effect_us: u64, cut_by_gap: bool) {
        let count = self.stream.increments.count();
        let t_start_us = self
            .stream_start_us
            .max(t_us.saturating_sub(micros(self.config.identification.window_s)))
            .max(self.learned_until_us);
        // A window is far shorter than the hour that 32 bits of microseconds hold.
        let length_us = (t_us - t_start_us) as u32;
        let kept = length_us.checked_div(self.stream.grid.interval_us).unwrap_or(0);
        let job = Job {
            t_start_us,
            t_end_us: t_us,
            effect_us,
            from: self.stream_from.max(count.saturating_sub(kept)),
            to: count,
            rest: self.stream.rest_bias(t_us),
            rest_is_news: self.stream.last_rest_us().is_some_and(|rest_us| rest_us > self.bias_known_us),
            rest_s: self.stream.rest_seconds(length_us / 1_000_000) as f32,
            rest_norm_error_m_s2: self.stream.rest_norm_error_m_s2(),
        };
        let too_short = Refusal::WindowTooShort {
            length_s: length_us as f32 * 1e-6,
            needed_s: self.config.identification.min_window_s,
            cut_by_gap,
        };
        match (u64::from(length_us) < micros(self.config.identification.min_window_s), self.state) {
            // Too short for P, but a rest in it still gives the bias.
            (true, State::Idle) => {
                self.job = job;
                let report = unidentified(&self.context(), &job, too_short);
                self.conclude(report);
            }
            (true, _) => self.announce_unapplied(&job, too_short),
            (false, State::Idle) => {
                self.job = job;
                self.result.clear();
                // A diagnosis that is not done by now has had its time: when it is due it is counted as an overrun.
                if core::mem::take(&mut self.stale_tests) {
                    self.work.begin_rebuild();
                    let Self { work, stream, .. } = self;
                    if let Work::Rebuild(rebuild) = work {
                        rebuild.start(stream, job.from);
                    }
                    self.state = State::Rebuilding;
                } else {
                    self.start_fit();
                }
            }
            (false, _) => self.announce_overrun(&job),
        }
    }

    /// Begins to fit the window of the job.
    fn start_fit(&mut self) {
        self.work.begin_fit();
        let (job, carried) = (self.job, self.carried);
        if let Some((context, fit)) = self.split() {
            fit.start(&context, job, &carried);
        }
        self.state = State::Fitting;
    }

    /// Keeps a result until it takes effect.
    fn conclude(&mut self, report: WindowReport) {
        self.result.clear();
        // Just emptied, so there is room.
        let _ = self.result.push(report);
        self.state = State::Ready;
    }

    /// A window whose result is not ready in time.
    fn announce_overrun(&mut self, job: &Job) {
        self.overruns = self.overruns.saturating_add(1);
        self.announce_unapplied(job, Refusal::Overrun);
    }

    /// Reports a window without a result: what flies stays.
    fn announce_unapplied(&mut self, job: &Job, refusal: Refusal) {
        let report = unidentified(&self.context(), job, refusal);
        self.announce(WindowReport { fitted: self.flown, flown: self.flown, ..report });
    }

    fn announce(&mut self, report: WindowReport) {
        if self.pending.push_back(report).is_err() {
            self.reports_lost = self.reports_lost.saturating_add(1);
        }
    }

    /// The oldest report that nobody has taken.
    pub fn take_report(&mut self) -> Option<WindowReport> {
        self.pending.pop_front()
    }

    /// One bounded piece of work; returns its size in units, 0 when there is nothing to do.
    pub fn step(&mut self) -> u32 {
        match self.state {
            State::Rebuilding => {
                let Self { work, stream, job, .. } = self;
                let more = match work {
                    Work::Rebuild(rebuild) => stream.rebuild(rebuild, job.to, REBUILT_IN_A_STEP),
                    _ => false,
                };
                if !more {
                    self.start_fit();
                }
                return REBUILT_IN_A_STEP * 12;
            }
            State::Fitting => {}
            State::Idle | State::Ready => return self.diagnose(),
        }
        let Some((context, fit)) = self.split() else { return 0 };
        match fit.step(&context) {
            Step::More(units) => units,
            Step::Done(report) => {
                match report.decision {
                    Decision::Accepted | Decision::Refused(Refusal::ChangeTooSmall { .. }) => self.learn(),
                    // What was carried no longer holds, or this window is wrong: the next one stands by itself.
                    Decision::Refused(Refusal::Contradiction { .. }) => self.carried = Carried::nothing(),
                    // A window that the gate does not believe teaches nothing.
                    Decision::Refused(_) => {}
                }
                self.conclude(report);
                JUDGE_UNITS
            }
            Step::Overtaken => {
                // Nothing will be ready when it is due.
                self.result.clear();
                self.state = State::Ready;
                JUDGE_UNITS
            }
        }
    }

    /// A piece of the diagnosis, for which there is time when no window is being fitted.
    #[inline(never)]
    fn diagnose(&mut self) -> u32 {
        let begun = self.to_diagnose.take();
        if begun.is_some() {
            self.waiting.clear();
            self.work.begin_diagnosis();
        }
        let Self { work, stream, config, waiting, history, .. } = self;
        let Work::Diagnosis(diagnosis) = work else { return 0 };
        let subject = Subject { stream, config, library: stream.library() };
        if let Some(job) = begun {
            diagnosis.start(&subject, job);
        }
        let units = diagnosis.step(&subject, history);
        if let Some(report) = diagnosis.take_report(&subject) {
            // Emptied when the diagnosis was begun, so there is room.
            let _ = waiting.push(report);
        }
        units
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.stream.library()
    }

    /// The effects that are taken out.
    pub const fn effects(&self) -> &ActiveEffects {
        self.stream.effects()
    }

    /// Sets the effects that are looked for.
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.stream.set_library(library);
    }

    /// The cost of the last window whose innovations stand.
    pub fn window_cost(&self) -> Option<WindowCost<'_>> {
        if let Work::Fit(fit) = &self.work { fit.cost() } else { None }
    }

    /// What no later window will hold is carried on.
    fn learn(&mut self) {
        let until_us = match self.next_close_us {
            u64::MAX => return,
            next_us => next_us.saturating_sub(micros(self.config.identification.window_s)),
        };
        if until_us > self.job.t_start_us {
            self.learned_until_us = until_us;
            let mut carried = self.carried;
            if let Some((context, fit)) = self.split() {
                fit.learn(&context, until_us, &mut carried);
            }
            self.carried = carried;
        }
    }

    fn context(&self) -> Context<'_> {
        Context { stream: &self.stream, config: &self.config, flown: &self.flown }
    }

    /// The fit beside what it needs to know.
    fn split(&mut self) -> Option<(Context<'_>, &mut WindowFit)> {
        let Self { stream, config, flown, work, .. } = self;
        let Work::Fit(fit) = work else { return None };
        Some((Context { stream, config, flown }, fit))
    }
}

fn micros(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}
