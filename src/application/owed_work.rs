//! Identification work that samples have brought and that is not done yet.

/// Units of work in one piece: 50,000 cycles. Work that cannot be divided overshoots this; the next pieces are then
/// shorter.
const SLICE_UNITS: u32 = 100;

/// Most work that is put off while the loop is short of time, in samples' budgets: a second at 200 Hz.
const OWED_SAMPLES: u32 = 200;

/// Units of work that are owed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwedWork(u32);

impl OwedWork {
    /// Adds the budget of one sample.
    pub fn add(&mut self, budget: u32) {
        let most = budget.saturating_mul(OWED_SAMPLES);
        self.0 = self.0.saturating_add(budget);
        if self.0 > most {
            self.0 = most;
        }
    }

    /// Takes one piece; returns its units, 0 if nothing is owed.
    pub fn take_piece(&mut self) -> u32 {
        let units = if self.0 < SLICE_UNITS { self.0 } else { SLICE_UNITS };
        self.0 -= units;
        units
    }

    /// Returns true if nothing is owed.
    pub const fn is_done(self) -> bool {
        self.0 == 0
    }
}
