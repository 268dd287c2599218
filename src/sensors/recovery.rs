//! Recovery: when a part that failed is started again.

/// Pause before the second start, microseconds; each further one is twice as long.
const FIRST_PAUSE_US: u32 = 10_000;
/// Longest pause, microseconds.
const LONGEST_PAUSE_US: u32 = 5_120_000;
/// Time without an incident after which a part is well again, microseconds: the next pause is [`FIRST_PAUSE_US`].
const WELL_AFTER_US: u64 = 2_000_000;
/// Bus errors in a row after which the part pauses and starts anew.
const ERRORS_IN_A_ROW: u8 = 5;

/// Schedule of a part's starts, readings and pauses. It knows no bus: its caller reports each event, and asks for the
/// next action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Recovery {
    state: State,
    pause_us: u32,
    errors: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Starting { step: u8, not_before_us: u64 },
    Measuring { since_us: u64, restart_at_us: Option<u64> },
}

/// Next action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Do this step of the start.
    Step(u8),
    /// Read the part.
    Read,
    /// Wait: the start continues later.
    Wait,
    /// Leave the part alone.
    Pause,
}

impl Recovery {
    pub const NEW: Self =
        Self { state: State::Starting { step: 0, not_before_us: 0 }, pause_us: FIRST_PAUSE_US, errors: 0 };

    pub fn next(&mut self, now_us: u64) -> Next {
        match self.state {
            State::Starting { step: 0, not_before_us } if now_us < not_before_us => Next::Pause,
            State::Starting { not_before_us, .. } if now_us < not_before_us => Next::Wait,
            State::Starting { step, .. } => Next::Step(step),
            State::Measuring { restart_at_us: Some(at_us), .. } if now_us >= at_us => {
                self.state = State::Starting { step: 0, not_before_us: 0 };
                Next::Step(0)
            }
            State::Measuring { .. } => Next::Read,
        }
    }

    /// Records a step of the start; the next step comes after `after_us` microseconds.
    pub fn stepped(&mut self, now_us: u64, step: u8, after_us: u32) {
        let not_before_us = now_us.saturating_add(after_us.into());
        self.state = State::Starting { step: step.saturating_add(1), not_before_us };
    }

    /// Records that the part measures.
    pub fn started(&mut self, now_us: u64) {
        self.state = State::Measuring { since_us: now_us, restart_at_us: None };
        self.errors = 0;
    }

    /// Records a burst; `well` means that nothing is wrong with it.
    pub fn was_read(&mut self, now_us: u64, well: bool) {
        self.errors = 0;
        let State::Measuring { since_us, restart_at_us } = &mut self.state else { return };
        if !well {
            *since_us = now_us;
        } else {
            *restart_at_us = None;
            if now_us.saturating_sub(*since_us) >= WELL_AFTER_US {
                self.pause_us = FIRST_PAUSE_US;
            }
        }
    }

    /// Records a bus failure while reading. Returns true if the part now pauses, after [`ERRORS_IN_A_ROW`] failures.
    pub fn bus_failed(&mut self, now_us: u64) -> bool {
        self.errors = self.errors.saturating_add(1);
        if self.errors < ERRORS_IN_A_ROW {
            return false;
        }
        self.pause(now_us);
        true
    }

    /// Restarts the part at once.
    pub fn restart(&mut self) {
        self.state = State::Starting { step: 0, not_before_us: 0 };
    }

    /// Pauses, then restarts the part.
    pub fn pause(&mut self, now_us: u64) {
        let not_before_us = now_us.saturating_add(self.longer_pause_us());
        self.state = State::Starting { step: 0, not_before_us };
        self.errors = 0;
    }

    /// Restarts the part after a pause, and reads it until then. Returns false if that was so before.
    pub fn restart_later(&mut self, now_us: u64) -> bool {
        let State::Measuring { restart_at_us: None, since_us } = self.state else { return false };
        let at_us = now_us.saturating_add(self.longer_pause_us());
        self.state = State::Measuring { since_us, restart_at_us: Some(at_us) };
        true
    }

    fn longer_pause_us(&mut self) -> u64 {
        let pause_us = self.pause_us;
        self.pause_us = pause_us.saturating_mul(2).min(LONGEST_PAUSE_US);
        pause_us.into()
    }
}
