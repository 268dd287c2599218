use super::{
    Carried, Decision, Refusal, WindowCost, WindowReport,
    diagnosis_schedule::DiagnosisSchedule,
    job::{Context, Job},
    judgement::unidentified,
    micros,
    prior::theta_of,
    window_fit::{Step, WindowFit},
    work::Work,
};
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel},
    config::Config,
    diagnosis::DiagnosisReport,
    window::{Reading, RestLimits, SampleStream, Scales, StreamSettings},
};
use heapless::{Deque, Vec};
use nalgebra::Vector3;

/// Reports waiting to be polled.
const PENDING: usize = 3;

/// Whether a window is being identified.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Idle,
    /// The fit of the window is to be begun.
    Due,
    Fitting,
    /// The result waits for its instant.
    Ready,
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
    /// The same of the flown P.
    p_known_us: u64,
    /// The window that is fitted, or was the last to be.
    job: Job,
    /// What the samples before it taught.
    carried: Carried,
    /// Until when the samples of the fit that was judged are still to be learnt from; 0: none are.
    to_learn_us: u64,
    state: State,
    work: Work,
    diagnosis: DiagnosisSchedule,
    /// The result of the job, once it is judged.
    result: Vec<WindowReport, 1>,
    pending: Deque<WindowReport, PENDING>,
    /// Reports dropped because nobody polled them.
    pub reports_lost: u32,
    pub overruns: u32,
}

mod bias_step;
mod closing;
mod reports;
#[cfg(feature = "storage")]
mod restoring;
mod working;

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
            p_known_us: 0,
            job: Job::zero(),
            carried: Carried::nothing(),
            to_learn_us: 0,
            state: State::Idle,
            work: Work::Nothing,
            diagnosis: DiagnosisSchedule::zero(),
            result: Vec::new(),
            pending: Deque::new(),
            reports_lost: 0,
            overruns: 0,
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let id = config.identification;
        self.config = *config;
        self.flown = config.gyro;
        self.final_close_us = config.freeze_at_us.map_or(u64::MAX, |t| t.saturating_sub(micros(id.latency_s)));
        self.freeze_us = config.freeze_at_us.unwrap_or(u64::MAX);
        self.diagnosis.configure(config, self.final_close_us);
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
        self.p_known_us = 0;
        self.carried = Carried::nothing();
        self.to_learn_us = 0;
        self.work = Work::Nothing;
        self.state = State::Idle;
        self.pending.clear();
        self.reports_lost = 0;
        self.overruns = 0;
    }

    pub const fn flown(&self) -> &GyroModel {
        &self.flown
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        self.stream.start(t_us, &theta_of(&self.flown));
        self.start_window(t_us);
        self.diagnosis.schedule(t_us, &self.config);
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

    /// Before a sample is compensated: a diagnosis that is due takes effect, and with it the bias that goes with it. Not while a window is
    /// being fitted, whose result is about the effects as they were. Returns whether the effects changed, and whether the bias stepped.
    pub fn take_diagnosed(&mut self, t_us: u64) -> [bool; 2] {
        if self.state != State::Idle {
            return [false; 2];
        }
        let Some(change) = self.diagnosis.take_effect(t_us, &mut self.stream) else { return [false; 2] };
        let bias = Vector3::from(self.flown.b_rad_s) + change.bias_rad_s;
        if bias.iter().all(|b| b.is_finite()) {
            self.flown.b_rad_s = bias.into();
            self.stream.change_model(&theta_of(&self.flown));
        }
        if change.others_of_gyro {
            // What was learnt about P and bias was about readings with other effects in them.
            self.carried = Carried::nothing();
        }
        let stepped = change.step.is_some_and(|(step, by)| self.follow_step(t_us, &step, &by));
        [change.effects, stepped]
    }

    /// The latest diagnosis that nobody has taken.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.diagnosis.take()
    }

    /// Diagnoses that were not done in time, and reports of others that nobody took.
    pub const fn diagnosis_losses(&self) -> (u32, u32) {
        (self.diagnosis.overruns, self.diagnosis.lost)
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
            if report.flown.p != self.flown.p {
                self.p_known_us = report.t_end_us;
            }
            self.flown = report.flown;
            self.bias_known_us = report.t_end_us;
        }
        self.announce(report);
        changed
    }

    /// Takes one sample (raw rate, calibrated vectors).
    pub fn push(&mut self, t_us: u64, [rate, gravity, field]: [Reading; 3], temperature_c: Option<f32>) {
        self.stream.push(t_us, rate, gravity, field, temperature_c);
        let latest = (&self.stream, self.stream_from);
        self.diagnosis.pushed(t_us, latest, self.next_close_us, &self.config, &self.flown);
        if t_us >= self.next_close_us {
            // The last window before a freeze closes at its first sample at or after the instant that leaves it the latency: by less
            // than a sample period its result would come after the freeze.
            let effect_us = t_us.saturating_add(micros(self.config.identification.latency_s));
            self.close(t_us, if effect_us < self.freeze_us { effect_us } else { self.freeze_us }, false);
            self.schedule(t_us, t_us.saturating_add(micros(self.config.identification.step_s)));
        }
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
}
