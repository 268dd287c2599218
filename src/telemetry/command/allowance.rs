//! Allowance of answers and reports for hosts without the key, so that a flood of commands takes a bounded share of
//! the line (docs/security.md). It is the generic cell rate algorithm (ATM Forum, Traffic Management 4.1, section
//! 4.4.2).

/// Rate of an allowance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rate {
    /// Time after which one more answer or report is allowed, microseconds.
    pub interval_us: u64,
    /// Number that is allowed at once.
    pub at_once: u64,
}

/// Remainder of an allowance, stored as the instant at which it is whole again, so that an unused one is all zero
/// (generic cell rate algorithm).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Allowance {
    whole_us: u64,
}

impl Allowance {
    /// The whole allowance.
    pub const fn new() -> Self {
        Self { whole_us: 0 }
    }

    /// Takes one; returns false if none is left.
    pub fn take(&mut self, rate: &Rate, now_us: u64) -> bool {
        let most_us = rate.interval_us.saturating_mul(rate.at_once);
        // An instant further ahead than `most_us` means that the clock has gone back.
        let is_ahead = self.whole_us > now_us && self.whole_us - now_us <= most_us;
        let from_us = if is_ahead { self.whole_us } else { now_us };
        let next_us = from_us.saturating_add(rate.interval_us);
        let may = next_us.saturating_sub(now_us) <= most_us;
        if may {
            self.whole_us = next_us;
        }
        may
    }
}

#[cfg(test)]
mod tests;
