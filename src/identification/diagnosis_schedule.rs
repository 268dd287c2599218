use super::{micros, work::Work};
use crate::{
    compensation::GyroModel,
    config::Config,
    diagnosis::{BiasStepReport, DiagnosisJob, DiagnosisReport, History, Subject},
    window::{RestBias, SampleStream},
};
use heapless::Vec;
use nalgebra::Vector3;

/// What is kept of the increments, seconds, as long as a window; the configuration leaves room for the latency.
const MOST_KEPT_S: f32 = 50.0;

/// What changes when a diagnosis takes effect.
pub(super) struct Change {
    /// Whether the effects do.
    pub effects: bool,
    /// The flown bias, by this: the constant part of what the effects add to the gyro's reading.
    pub bias_rad_s: Vector3<f32>,
    /// Whether there are other effects of the gyro than before, not only of other size.
    pub others_of_gyro: bool,
    /// The bias stepped, by so much, compensated frame, rad/s.
    pub step: Option<(BiasStepReport, Vector3<f32>)>,
}

/// When the samples are diagnosed, and when what was found takes effect.
pub(super) struct DiagnosisSchedule {
    /// When the next one is due to begin.
    next_us: u64,
    /// Increments that diagnoses have looked at.
    seen_to: u32,
    /// When the last one before a freeze begins, early enough for what it finds.
    final_us: u64,
    /// When what is being found takes effect; 0: nothing is.
    effect_us: u64,
    /// The one that is to begin as soon as no window is fitted.
    to_do: Option<DiagnosisJob>,
    history: History,
    /// The report that waits for its instant.
    waiting: Vec<DiagnosisReport, 1>,
    /// The latest that has taken effect, until somebody takes it.
    diagnosed: Vec<DiagnosisReport, 1>,
    /// Diagnoses that were not done in time.
    pub overruns: u32,
    /// Reports that nobody took.
    pub lost: u32,
}

impl DiagnosisSchedule {
    pub const fn zero() -> Self {
        Self {
            next_us: 0,
            seen_to: 0,
            final_us: 0,
            effect_us: 0,
            to_do: None,
            history: History::zero(),
            waiting: Vec::new(),
            diagnosed: Vec::new(),
            overruns: 0,
            lost: 0,
        }
    }

    /// Begins anew. What the last diagnosis finds has to be there when the last window closes.
    pub fn configure(&mut self, config: &Config, final_close_us: u64) {
        self.final_us = final_close_us.saturating_sub(micros(config.diagnosis.latency_s));
        self.next_us = u64::MAX;
        self.effect_us = 0;
        self.seen_to = 0;
        self.to_do = None;
        self.history = History::zero();
        self.waiting.clear();
        self.diagnosed.clear();
        self.overruns = 0;
        self.lost = 0;
    }

    /// Sets when the next diagnosis begins.
    pub fn schedule(&mut self, now_us: u64, config: &Config) {
        let regular_us = now_us.saturating_add(micros(config.diagnosis.window_s));
        let latency_us = micros(config.diagnosis.latency_s);
        self.next_us = if now_us >= self.final_us || !config.effects {
            u64::MAX
        } else if regular_us.saturating_add(latency_us) > self.final_us {
            self.final_us
        } else {
            regular_us
        };
    }

    /// After a sample: a diagnosis of the latest ones that is due is to begin. One that the fit of a window would soon break off waits until that
    /// window closes, and looks at what comes until then, too.
    pub fn pushed(
        &mut self,
        t_us: u64,
        (stream, stream_from): (&SampleStream, u32),
        next_close_us: u64,
        config: &Config,
        flown: &GyroModel,
    ) {
        let latency_us = micros(config.diagnosis.latency_s);
        let breaks_off = next_close_us > t_us && next_close_us - t_us < latency_us && self.next_us != self.final_us;
        if t_us < self.next_us || breaks_off {
            return;
        }
        let due_us = self.next_us;
        let count = stream.increments.count();
        let window = stream.grid.increments_in(config.diagnosis.window_s) as u32;
        let kept = stream.grid.increments_in(MOST_KEPT_S - config.diagnosis.latency_s) as u32;
        let unseen = count.saturating_sub(self.seen_to);
        let most = if t_us > due_us && unseen > window { unseen.min(kept) } else { window };
        self.seen_to = count;
        let from = stream_from.max(count.saturating_sub(most));
        let length_us = u64::from(count - from) * u64::from(stream.grid.interval_us);
        self.to_do = Some(DiagnosisJob {
            t_start_us: t_us.saturating_sub(length_us),
            t_end_us: t_us,
            from,
            to: count,
            flown: *flown,
            unseen: if unseen < count - from { unseen as f32 / (count - from) as f32 } else { 1.0 },
            rest: stream.rest_as_read(t_us).unwrap_or(RestBias::UNKNOWN),
        });
        self.effect_us = t_us.saturating_add(latency_us);
        self.schedule(due_us, config);
    }

    /// Before a sample is compensated: a diagnosis that is due takes effect, or was not done in time.
    pub fn take_effect(&mut self, t_us: u64, stream: &mut SampleStream) -> Option<Change> {
        if self.effect_us == 0 || t_us < self.effect_us {
            return None;
        }
        self.effect_us = 0;
        let Some(mut report) = self.waiting.pop() else {
            self.overruns = self.overruns.saturating_add(1);
            return None;
        };
        report.t_effect_us = t_us;
        let effects = report.active();
        if self.diagnosed.pop().is_some() {
            self.lost = self.lost.saturating_add(1);
        }
        // Just emptied, so there is room.
        let _ = self.diagnosed.push(report);
        let before = *stream.effects();
        let step = report.believed_step();
        if (effects == before && step.is_none()) || !report.is_conclusive() {
            return None;
        }
        stream.set_effects(&effects);
        let same = |exactly: bool| effects.same_of_gyro(&before, stream.library(), exactly);
        let bias_rad_s = if same(true) { Vector3::zeros() } else { report.bias_change_rad_s.into() };
        Some(Change { effects: effects != before, bias_rad_s, others_of_gyro: !same(false), step })
    }

    /// The latest diagnosis that nobody has taken.
    pub fn take(&mut self) -> Option<DiagnosisReport> {
        self.diagnosed.pop()
    }

    /// A piece of the diagnosis, for which there is time when no window is being fitted; returns its size in work units.
    #[inline(never)]
    pub fn step(&mut self, work: &mut Work, stream: &SampleStream, config: &Config) -> u32 {
        let begun = self.to_do.take();
        if begun.is_some() {
            self.waiting.clear();
            work.begin_diagnosis();
        }
        let Work::Diagnosis(diagnosis) = work else { return 0 };
        let library = crate::diagnosis::candidates(stream.library());
        let subject = Subject { stream, config, library: &library };
        if let Some(job) = begun {
            diagnosis.start(&subject, job);
        }
        let units = diagnosis.step(&subject, &mut self.history);
        if let Some(report) = diagnosis.take_report(&subject) {
            // Emptied when the diagnosis was begun, so there is room.
            let _ = self.waiting.push(report);
        }
        units
    }
}
