//! When the samples are diagnosed, and when what was found takes effect.

use super::{
    Diagnosis, DiagnosisJob, DiagnosisReport, History, Subject, candidates,
    stream::{RestBias, SampleStream},
};
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel},
    config::{Config, micros},
    sample::Reading,
};
use core::mem::ManuallyDrop;
use heapless::Vec;
use nalgebra::Vector3;

/// What changes when a diagnosis takes effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Change {
    /// Whether the effects do.
    pub effects: bool,
    /// The flown bias, by this, raw frame, rad/s: the constant part of what the effects add to the gyro's reading.
    pub bias_rad_s: Vector3<f32>,
    /// Whether there are other effects of the gyro than before, not only of other size.
    pub others_of_gyro: bool,
    /// The bias stepped.
    pub step: Option<Stepped>,
}

/// A step of the gyro's bias, raw frame, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stepped {
    /// By how much.
    pub by_rad_s: Vector3<f32>,
    /// What it is since.
    pub bias_rad_s: Vector3<f32>,
}

/// The diagnosis of the samples as they come: what it works on, when it does, and what it has found.
pub(crate) struct DiagnosisSchedule {
    stream: SampleStream,
    /// First increment since the start or the last gap.
    stream_from: u32,
    /// When the next one is due to begin.
    next_us: u64,
    /// Increments that diagnoses have looked at.
    seen_to: u32,
    /// When the last one before a freeze begins, early enough for what it finds.
    final_us: u64,
    /// When what is being found takes effect; 0: nothing is.
    effect_us: u64,
    /// The one that is to begin.
    to_do: Option<DiagnosisJob>,
    history: History,
    // Nothing in it has to be dropped; with drop glue an assignment goes by way of the stack.
    diagnosis: ManuallyDrop<Diagnosis>,
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
            stream: SampleStream::zero(),
            stream_from: 0,
            next_us: 0,
            seen_to: 0,
            final_us: 0,
            effect_us: 0,
            to_do: None,
            history: History::zero(),
            diagnosis: ManuallyDrop::new(Diagnosis::zero()),
            waiting: Vec::new(),
            diagnosed: Vec::new(),
            overruns: 0,
            lost: 0,
        }
    }

    /// Begins anew. What the last diagnosis finds has to be there by `final_us`.
    pub fn configure(&mut self, config: &Config, final_us: u64) {
        self.stream.configure(config);
        self.final_us = final_us.saturating_sub(micros(config.diagnosis.latency_s));
        self.next_us = u64::MAX;
        self.effect_us = 0;
        self.seen_to = 0;
        self.to_do = None;
        self.history = History::zero();
        self.clear();
        self.waiting.clear();
        self.diagnosed.clear();
        self.overruns = 0;
        self.lost = 0;
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64, config: &Config) {
        self.stream.start(t_us);
        self.stream_from = 0;
        self.schedule(t_us, config);
    }

    /// A gap: no diagnosis that begins after it looks across it.
    pub fn gap(&mut self, t_us: u64) {
        self.stream.restart(t_us);
        self.stream_from = self.stream.increments.count();
    }

    /// Sets when the next diagnosis begins.
    fn schedule(&mut self, now_us: u64, config: &Config) {
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

    /// Takes one sample: raw rate, calibrated gravity and field. A diagnosis of the latest ones that is due is to begin.
    pub fn push(
        &mut self,
        t_us: u64,
        readings: [Reading; 3],
        temperature_c: Option<f32>,
        (config, flown): (&Config, &GyroModel),
    ) {
        self.stream.push(t_us, readings, temperature_c);
        if t_us < self.next_us {
            return;
        }
        let count = self.stream.increments.count();
        let window = self.stream.grid.increments_in(config.diagnosis.window_s) as u32;
        let unseen = count.saturating_sub(self.seen_to);
        self.seen_to = count;
        let from = self.stream_from.max(count.saturating_sub(window));
        let length_us = u64::from(count - from) * u64::from(self.stream.grid.interval_us);
        self.to_do = Some(DiagnosisJob {
            t_start_us: t_us.saturating_sub(length_us),
            t_end_us: t_us,
            from,
            to: count,
            flown: *flown,
            unseen: if unseen < count - from { unseen as f32 / (count - from) as f32 } else { 1.0 },
            rest: self.stream.rest_as_read(t_us).unwrap_or(RestBias::UNKNOWN),
        });
        self.effect_us = t_us.saturating_add(micros(config.diagnosis.latency_s));
        self.schedule(t_us, config);
    }

    /// Before a sample is compensated: a diagnosis that is due takes effect, or was not done in time.
    pub fn take_effect(&mut self, t_us: u64, flown: &GyroModel) -> Option<Change> {
        if self.effect_us == 0 || t_us < self.effect_us {
            return None;
        }
        self.effect_us = 0;
        let Some(mut report) = self.waiting.pop() else {
            self.overruns = self.overruns.saturating_add(1);
            return None;
        };
        report.t_effect_us = t_us;
        if self.diagnosed.pop().is_some() {
            self.lost = self.lost.saturating_add(1);
        }
        // Just emptied, so there is room.
        let _ = self.diagnosed.push(report);
        if !report.is_conclusive() {
            return None;
        }
        let (effects, before) = (report.active(), *self.effects());
        self.stream.set_effects(&effects);
        let step = self.take_step(&report, flown);
        if effects == before && step.is_none() {
            return None;
        }
        let same = |exactly: bool| effects.same_of_gyro(&before, self.library(), exactly);
        let bias_rad_s = if same(true) { Vector3::zeros() } else { report.bias_change_rad_s.into() };
        Some(Change { effects: effects != before, bias_rad_s, others_of_gyro: !same(false), step })
    }

    /// The step of the bias that a diagnosis has found: all that was read before it is moved by it, once.
    #[inline(never)]
    fn take_step(&mut self, report: &DiagnosisReport, flown: &GyroModel) -> Option<Stepped> {
        let (step, by_rad_s) = report.believed_step()?;
        let by_rad_s = flown.p_matrix().try_inverse()? * by_rad_s;
        let bias_rad_s = Vector3::from(step.bias_rad_s(flown)?);
        if !bias_rad_s.iter().chain(&by_rad_s).all(|b| b.is_finite()) {
            return None;
        }
        self.stream.step_bias(step.until, step.t_us, &by_rad_s);
        Some(Stepped { by_rad_s, bias_rad_s })
    }

    /// The latest diagnosis that nobody has taken.
    pub fn take(&mut self) -> Option<DiagnosisReport> {
        self.diagnosed.pop()
    }

    /// A piece of the diagnosis; returns its size in work units, 0 when there is nothing to do.
    #[inline(never)]
    pub fn step(&mut self, config: &Config) -> u32 {
        let begun = self.to_do.take();
        if begun.is_some() {
            self.waiting.clear();
            self.clear();
        }
        let Self { stream, diagnosis, history, .. } = self;
        let library = candidates(stream.library());
        let subject = Subject { stream, config, library: &library };
        if let Some(job) = begun {
            diagnosis.start(&subject, job);
        }
        let units = diagnosis.step(&subject, history);
        if let Some(report) = diagnosis.take_report(&subject) {
            // Emptied when the diagnosis was begun, so there is room.
            let _ = self.waiting.push(report);
        }
        units
    }

    /// Drops what is under way.
    #[inline(never)]
    fn clear(&mut self) {
        // A constant of all zeros, so that it is written where it belongs: the value would go by way of the stack.
        const NOTHING: ManuallyDrop<Diagnosis> = ManuallyDrop::new(Diagnosis::zero());
        self.diagnosis = NOTHING;
    }

    /// Sets the effects that are looked for.
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.stream.set_library(library);
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.stream.library()
    }

    /// The effects that are taken out.
    pub const fn effects(&self) -> &ActiveEffects {
        self.stream.effects()
    }

    /// Takes these effects out from the first sample on; to be called between `configure` and `start`.
    #[cfg(feature = "storage")]
    pub const fn restore(&mut self, effects: &ActiveEffects) {
        self.stream.set_effects(effects);
    }

    /// When the tool was last at rest, and the raw bias since without the part of the effects; `None` before the first rest.
    pub fn last_rest(&self, t_us: u64) -> Option<(u64, RestBias)> {
        Some((self.stream.last_rest_us()?, self.stream.rest_bias(t_us)?))
    }
}
