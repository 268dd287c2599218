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
    /// True if the next interval's slot holds an offset that came, but could not be told from a change of the earth's
    /// field.
    holds_untold: bool,
    /// Slots whose interval has begun or ended since it was taken, a bit each.
    news: u8,
}

impl KeptIntervals {
    pub const fn zero() -> Self {
        Self {
            intervals: [HardIronInterval::NONE; KEPT],
            counts: HardIronCounts { intervals: 0, suspicions: 0, dismissed: 0 },
            on: false,
            holds_untold: false,
            news: 0,
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
        let number = self.counts.intervals as usize % KEPT;
        if let Some(slot) = self.intervals.get_mut(number) {
            *slot = interval;
        }
        self.news |= 1 << number;
        self.counts.intervals = self.counts.intervals.wrapping_add(1);
        self.on = true;
        self.holds_untold = false;
    }

    /// Holds an offset that came and could not be told, until the next one or the next interval. Nothing is held where
    /// an older interval would have to go.
    pub fn hold_untold(&mut self, interval: HardIronInterval) {
        if let Some(slot) = self.intervals.get_mut(self.counts.intervals as usize) {
            *slot = interval;
            self.holds_untold = true;
        }
    }

    /// Offset that came and could not be told, if one is held.
    pub fn untold(&self) -> Option<&HardIronInterval> {
        self.intervals.get(self.counts.intervals as usize).filter(|_| self.holds_untold)
    }

    /// Ends the lasting interval, if there is one.
    pub fn close(&mut self, t_us: u64) {
        if core::mem::take(&mut self.on)
            && let Some(last) = self.last_mut()
        {
            last.to_us = Some(t_us);
            self.news |= 1 << (self.counts.intervals.wrapping_sub(1) as usize % KEPT);
        }
    }

    /// Returns an interval that has begun or ended since it was taken, and takes it.
    pub fn take_news(&mut self) -> Option<HardIronInterval> {
        let interval = self.intervals.get(self.news.trailing_zeros() as usize)?;
        // The lowest bit.
        self.news &= self.news.wrapping_sub(1);
        Some(*interval)
    }

    pub fn suspect(&mut self) {
        self.counts.suspicions = self.counts.suspicions.saturating_add(1);
    }

    pub fn dismiss(&mut self) {
        self.counts.dismissed = self.counts.dismissed.saturating_add(1);
    }
}
