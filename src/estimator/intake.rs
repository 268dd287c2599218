//! Intake of the estimator: samples become increments, which wait with the requests between them.

use super::{
    Settings,
    increment::{Builder, Composition, Item},
    real::Real,
    waiting::Waiting,
};
use crate::{compensation::GyroModel, sample::Reading};

/// State of the intake.
pub(super) struct Intake<T> {
    builder: Builder<T>,
    /// Time of the sample before, microseconds; `None` before the first.
    last_us: Option<u64>,
    /// Seconds before the next sample that the samples' times do not show.
    waited_s: f32,
    waiting: Waiting<T>,
    /// Model with which rotations are composed: the flown one, so that both change at the same instants.
    composed_with: Composition<T>,
}

impl<T: Real> Intake<T> {
    pub const fn zero() -> Self {
        Self {
            builder: Builder::zero(),
            last_us: None,
            waited_s: 0.0,
            waiting: Waiting::new(),
            composed_with: Composition::zero(),
        }
    }

    /// Clears the queue, and composes increments with the factory's gyro model from now on.
    pub fn start(&mut self, settings: &Settings) {
        (self.last_us, self.waited_s) = (None, 0.0);
        self.waiting.clear();
        self.compose_with(&settings.factory);
        self.builder.start(settings.sample_period_s, settings.is_instant);
    }

    /// Takes one sample, see [`Estimator::push`](super::Estimator::push). Returns true if an increment ends with it.
    pub fn push(&mut self, t_us: u64, readings: [Reading; 3], warming_k: Option<f32>) -> bool {
        self.builder.warm(warming_k);
        let waited_s = core::mem::replace(&mut self.waited_s, 0.0);
        let step_s = self.last_us.map_or(0.0, |last_us| t_us.saturating_sub(last_us) as f32 * 1e-6 + waited_s);
        self.last_us = Some(t_us);
        let item = self.builder.push((t_us, step_s), &self.composed_with, readings);
        item.map(|item| self.waiting.push(item)).is_some()
    }

    /// Notes seconds before the next sample that the samples' times do not show.
    pub const fn wait(&mut self, seconds: f32) {
        self.waited_s = seconds;
    }

    /// Sets the model with which rotations are composed from the next sample on.
    pub fn compose_with(&mut self, model: &GyroModel) {
        if let Some(composition) = Composition::new(model) {
            self.composed_with = composition;
        }
    }

    /// Queues a request; it is answered after all samples that are queued already.
    pub fn ask(&mut self, request: Item<T>) {
        self.waiting.push(request);
    }

    /// Returns true if there is room for a request.
    pub fn has_room(&self) -> bool {
        self.waiting.has_room()
    }

    /// Takes the oldest item.
    pub fn pop(&mut self) -> Option<Item<T>> {
        self.waiting.pop()
    }

    /// Length of an increment, seconds.
    pub fn increment_s(&self) -> T {
        self.builder.seconds()
    }

    /// Number of increments and requests that were dropped because the queue was full.
    pub const fn lost(&self) -> u32 {
        self.waiting.lost
    }
}
