//! Schedule of updates and windows. A result takes effect at an instant that is fixed when it is asked for, in the
//! samples' own time, so that attitude does not depend on how fast the work is done (docs/architecture.md, "A fixed
//! swap instant").

use crate::config::{Config, micros};
use heapless::Vec;

/// One update of the flown model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Update {
    /// Latest sample that its result may depend on, microseconds.
    pub t_us: u64,
    /// Instant at which its result takes effect, microseconds.
    pub effect_us: u64,
    /// True if a window closes with it; then that window's start.
    pub is_window: bool,
    pub window_start_us: u64,
    /// `t_us` since the first sample of all, microseconds.
    pub since_start_us: u64,
}

/// Progress of an update.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Idle,
    /// The update is asked for, and has no result yet.
    Asked,
    /// The result waits for its instant.
    Ready,
}

/// Instants at which updates are asked for, and at which their results `T` take effect: instants of the samples' own
/// time, whatever work is done between them.
pub(super) struct Schedule<T> {
    update_us: u64,
    window_us: u64,
    step_us: u64,
    latency_us: u64,
    start_us: u64,
    /// Instants of the next update and of the next window.
    next_us: u64,
    next_window_us: u64,
    /// Instant of the last update before a freeze, and of the freeze.
    final_us: u64,
    freeze_us: u64,
    state: State,
    update: Update,
    result: Vec<T, 1>,
}

impl<T> Schedule<T> {
    pub const fn zero() -> Self {
        Self {
            update_us: 0,
            window_us: 0,
            step_us: 0,
            latency_us: 0,
            start_us: 0,
            next_us: 0,
            next_window_us: 0,
            final_us: 0,
            freeze_us: 0,
            state: State::Idle,
            update: Update { t_us: 0, effect_us: 0, is_window: false, window_start_us: 0, since_start_us: 0 },
            result: Vec::new(),
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let id = &config.identification;
        self.update_us = micros(id.update_s);
        self.window_us = micros(id.window_s);
        self.step_us = micros(id.step_s);
        self.latency_us = micros(id.latency_s);
        (self.final_us, self.freeze_us) = (u64::MAX, u64::MAX);
        self.state = State::Idle;
        self.result.clear();
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        self.start_us = t_us;
        self.next_window_us = t_us.saturating_add(self.window_us);
        self.schedule(t_us, t_us);
    }

    /// Lets nothing new take effect after an instant: the last window ends one latency before, and lands on it.
    pub fn freeze(&mut self, at_us: u64) {
        self.freeze_us = at_us;
        self.final_us = at_us.saturating_sub(self.latency_us);
        if self.next_us < u64::MAX {
            self.next_us = self.or_last(self.next_us);
        }
    }

    /// Instant from which nothing new takes effect; `u64::MAX`: never.
    pub const fn freeze_us(&self) -> u64 {
        self.freeze_us
    }

    /// Sets the next update after `now_us`: a regular one, whole periods after `due_us`, or the last before a freeze.
    fn schedule(&mut self, now_us: u64, due_us: u64) {
        self.next_us =
            if now_us >= self.final_us { u64::MAX } else { self.or_last(after(now_us, due_us, self.update_us)) };
    }

    /// Instant of a regular update, or of the last one before a freeze: where that comes first, or so soon after it
    /// that the regular one's result would not have landed.
    const fn or_last(&self, regular_us: u64) -> u64 {
        if regular_us.saturating_add(self.latency_us) > self.final_us { self.final_us } else { regular_us }
    }

    /// Delays a pending result by a gap from `last_us` to `t_us`: no work is done in a gap, so it does not count into
    /// the latency. After a freeze nothing new takes effect, except a result that was due in the gap and is ready.
    pub fn gap(&mut self, last_us: u64, t_us: u64) {
        let latest_us = if self.freeze_us > t_us { self.freeze_us } else { t_us };
        let delayed_us = self.update.effect_us.saturating_add(t_us.saturating_sub(last_us));
        self.update.effect_us = if delayed_us > latest_us { latest_us } else { delayed_us };
    }

    /// Returns the update to be asked for with this sample. One that is due before the last result has taken effect
    /// waits for that.
    pub fn push(&mut self, t_us: u64) -> Option<Update> {
        if t_us < self.next_us || self.state != State::Idle {
            return None;
        }
        if t_us >= self.freeze_us {
            // The update was due in a gap, and its result would come after the freeze.
            self.next_us = u64::MAX;
            return None;
        }
        let due_us = self.next_us;
        let is_window = due_us == self.final_us || due_us.saturating_add(self.update_us / 2) > self.next_window_us;
        if is_window {
            self.next_window_us = after(t_us, self.next_window_us, self.step_us);
        }
        let effect_us = t_us.saturating_add(self.latency_us);
        let window_start_us = t_us.saturating_sub(self.window_us);
        self.update = Update {
            t_us,
            // By less than a sample period the last result would come after the freeze.
            effect_us: if effect_us < self.freeze_us { effect_us } else { self.freeze_us },
            is_window,
            window_start_us: if window_start_us > self.start_us { window_start_us } else { self.start_us },
            since_start_us: t_us.saturating_sub(self.start_us),
        };
        self.state = State::Asked;
        self.result.clear();
        self.schedule(t_us, due_us);
        Some(self.update)
    }

    /// Returns the update that is asked for and has no result.
    pub fn asked(&self) -> Option<Update> {
        (self.state == State::Asked).then_some(self.update)
    }

    /// Returns true if no update is asked for or waits.
    pub fn is_idle(&self) -> bool {
        self.state == State::Idle
    }

    /// Returns true if there will be no further update.
    pub fn is_over(&self) -> bool {
        self.is_idle() && self.next_us == u64::MAX
    }

    /// Stores the result of the update that is asked for.
    pub fn conclude(&mut self, result: T) {
        if self.state == State::Asked {
            // The slot was emptied when the update was asked for, so there is room.
            let _ = self.result.push(result);
            self.state = State::Ready;
        }
    }

    /// Returns true if an update is due before this sample.
    pub fn is_due(&self, t_us: u64) -> bool {
        self.state != State::Idle && t_us >= self.update.effect_us
    }

    /// Returns the update that is due before this sample, with its result; `None` in the result's place is an
    /// overrun.
    pub fn take_effect(&mut self, t_us: u64) -> Option<(Update, Option<T>)> {
        if !self.is_due(t_us) {
            return None;
        }
        self.state = State::Idle;
        Some((self.update, self.result.pop()))
    }
}

/// Returns the first instant after `now_us` that is whole periods after `due_us`.
fn after(now_us: u64, due_us: u64, period_us: u64) -> u64 {
    let passed = now_us.saturating_sub(due_us).checked_div(period_us).unwrap_or(0);
    due_us.saturating_add(period_us.saturating_mul(passed.saturating_add(1)))
}

#[cfg(test)]
mod tests;
