//! Latest magnet intervals, kept for the report.

use super::super::hard_iron_interval::{HardIronCounts, HardIronInterval};

/// Number of intervals kept for the report: the latest.
const KEPT: usize = 8;

/// Ring of the latest intervals, with the counters since the configuration.
pub(super) struct KeptIntervals {
    intervals: [HardIronInterval; KEPT],
    pub counts: HardIronCounts,
    /// True if the last interval still lasts.
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

    /// Kept intervals, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &HardIronInterval> {
        let count = self.counts.intervals as usize;
        (count.saturating_sub(KEPT)..count).filter_map(|number| self.intervals.get(number % KEPT))
    }

    /// Interval that still lasts, if any.
    pub fn lasting(&self) -> Option<&HardIronInterval> {
        self.last().filter(|_| self.on)
    }

    /// Latest interval.
    pub fn last(&self) -> Option<&HardIronInterval> {
        self.intervals.get((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    pub fn last_mut(&mut self) -> Option<&mut HardIronInterval> {
        self.intervals.get_mut((self.counts.intervals as usize).checked_sub(1)? % KEPT)
    }

    /// Begins a new interval.
    pub fn begin(&mut self, interval: HardIronInterval) {
        if let Some(slot) = self.intervals.get_mut(self.counts.intervals as usize % KEPT) {
            *slot = interval;
        }
        self.counts.intervals = self.counts.intervals.wrapping_add(1);
        self.on = true;
    }

    /// Ends the lasting interval, if there is one.
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
