//! Session of a probe: what it has gathered from samples since its configuration, beside that of the parts that reset
//! themselves. This is where a time stamp is believed, and where a step of time is a gap.

use super::output::{Counters, count};
use crate::time_step::{GAP_PERIODS, LONGEST_BELIEVED_US, is_gap};

/// State gathered from samples. A new configuration resets it as one value.
pub(super) struct Session {
    pub counters: Counters,
    /// Time of the last accepted sample, microseconds; meaningless before the first.
    pub last_us: u64,
    /// Time stamp of the sample before, if that was refused as too far from the last accepted one to be believed alone,
    /// microseconds; else 0.
    doubted_us: u64,
    /// Samples refused since the last accepted one.
    refused: u32,
    /// True from the first sample of a time base on.
    has_begun: bool,
    /// True if a stored model was restored.
    #[cfg(feature = "storage")]
    pub is_restored: bool,
    /// True if the last sample began a new time base because the clock went back.
    pub began_afresh: bool,
    /// Time of validity of the last output, microseconds.
    last_valid_us: u64,
    /// Time at which the estimator's attitude is compared with the filter's, microseconds; 0: it was not asked for.
    pub look_due_us: u64,
    /// Units of identification work done beyond the budgets; the next calls do so many fewer.
    pub overspent: u32,
}

/// Judgement of a time stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stamp {
    /// Not believed; counted.
    Refused,
    /// Later than the sample before.
    Later,
    /// Earlier than the sample before, by a clock that went back.
    OfEarlierClock,
}

/// Time from the last accepted sample to this one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// True for the first sample of a time base.
    pub is_first: bool,
    /// By the time stamps.
    pub seconds: f32,
    /// The refused samples between, a period each, whatever their stamps say.
    pub refused_s: f32,
    pub is_gap: bool,
}

impl Step {
    /// Length of the gap, seconds; `None` if it is none.
    pub fn gap_s(&self) -> Option<f32> {
        self.is_gap.then_some(if self.refused_s > self.seconds { self.refused_s } else { self.seconds })
    }
}

impl Session {
    /// All zero, for a static.
    pub const ZERO: Self = Self {
        counters: Counters::ZERO,
        last_us: 0,
        doubted_us: 0,
        refused: 0,
        has_begun: false,
        #[cfg(feature = "storage")]
        is_restored: false,
        began_afresh: false,
        last_valid_us: 0,
        look_due_us: 0,
        overspent: 0,
    };

    /// Judges the time stamp of a sample, see [`Probe::push`](super::Probe::push).
    pub fn judge(&mut self, t_us: u64) -> Stamp {
        self.began_afresh = false;
        let last_us = if self.has_begun { self.last_us } else { t_us };
        let is_far = t_us.abs_diff(last_us) > LONGEST_BELIEVED_US;
        let doubted_us = core::mem::replace(&mut self.doubted_us, 0);
        let is_confirmed = doubted_us > 0 && doubted_us < t_us && t_us - doubted_us <= LONGEST_BELIEVED_US;
        let is_old = t_us <= last_us && self.has_begun;
        if if is_far { !is_confirmed } else { is_old } {
            self.doubted_us = if is_far { t_us } else { 0 };
            count(&mut self.counters.out_of_order);
            count(&mut self.refused);
            return Stamp::Refused;
        }
        if is_old { Stamp::OfEarlierClock } else { Stamp::Later }
    }

    /// Goes on with the counters of the session before: the clock went back.
    pub const fn begin_afresh(&mut self, counters: Counters) {
        self.counters = counters;
        count(&mut self.counters.gaps);
        self.began_afresh = true;
    }

    /// Steps to a sample whose time stamp is believed.
    pub fn step(&mut self, t_us: u64, period_us: u32) -> Step {
        let is_first = !core::mem::replace(&mut self.has_begun, true);
        let step_us = if is_first { 0 } else { t_us - self.last_us };
        let refused = core::mem::replace(&mut self.refused, 0);
        Step {
            is_first,
            seconds: step_us as f32 * 1e-6,
            refused_s: refused as f32 * period_us as f32 * 1e-6,
            is_gap: is_gap(step_us, period_us) || refused > GAP_PERIODS && !is_first || self.began_afresh,
        }
    }

    /// Returns the time of validity of an output, which never goes back: `t_us` is that by the delay that is known now.
    pub fn valid_at(&mut self, t_us: u64, is_first: bool) -> u64 {
        let is_later = is_first || t_us > self.last_valid_us;
        self.last_valid_us = if is_later { t_us } else { self.last_valid_us.saturating_add(1) };
        self.last_valid_us
    }
}
