use super::super::hard_iron_interval::{HardIronCounts, HardIronInterval};

/// Intervals kept for the report.
const KEPT: usize = 8;

/// The latest intervals, and what has been counted since the start.
pub(super) struct KeptIntervals {
    intervals: [HardIronInterval; KEPT],
    pub counts: HardIronCounts,
    /// Whether the last of them lasts.
    pub on: bool,
}

impl KeptIntervals {
    pub const fn zero() -> Self {
        Self {
            intervals: [HardIronInterval::NONE; KEPT],
            counts: HardIronCounts { intervals: 0, suspicions: 0, dismissed: 0 },
            on: false,
        }
    }

    /// The oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &HardIronInterval> {
        let count = self.counts.intervals as usize;
        (count.saturating_sub(KEPT)..count).filter_map(|number| self.intervals.get(number % KEPT))
    }

    /// The one that lasts.
    pub fn lasting(&self) -> Option<&HardIronInterval> {
        self.last().filter(|_| self.on)
    }

    /// The latest.
    pub fn last(&self) -> Option<&HardIronInterval> {
        self.intervals.get((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    pub fn last_mut(&mut self) -> Option<&mut HardIronInterval> {
        self.intervals.get_mut((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    /// A new one begins.
    pub fn begin(&mut self, interval: HardIronInterval) {
        if let Some(slot) = self.intervals.get_mut(self.counts.intervals as usize % KEPT) {
            *slot = interval;
        }
        self.counts.intervals = self.counts.intervals.wrapping_add(1);
        self.on = true;
    }

    /// The one that lasts, if one does, ends.
    pub fn close(&mut self, t_us: u64) {
        if core::mem::take(&mut self.on)
            && let Some(last) = self.last_mut()
        {
            last.to_us = Some(t_us);
        }
    }

    pub fn suspect(&mut self) {
        self.counts.suspicions = self.counts.suspicions.saturating_add(1);
    }

    pub fn dismiss(&mut self) {
        self.counts.dismissed = self.counts.dismissed.saturating_add(1);
    }
}
