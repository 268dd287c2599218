//! Shocks, after which the gyro's bias may be another: shaking beyond the vibration of the last half minute.

use super::STEPS;
use crate::algebra::quantile;

/// Most half seconds from which the vibration is known.
const KNOWN: usize = 64;
/// Half seconds before which no shock is detected.
const FEWEST: usize = 16;
/// Length of a piece of which the hardest shaking is noted, microseconds.
const PIECE_US: u64 = 500_000;
/// Interquartile distances by which the largest specific force of a half second has to be over the median of these
/// maxima. Maxima of vibration are Gumbel-distributed, with quartiles at 0.327, -0.367 and -1.246 scales from the mode:
/// one in 1,000 is so large, one in eight minutes. A short shock is diluted by the sample period.
const SHOCK: f32 = (6.907 - 0.367) / (1.246 + 0.327);
/// Least excess over the median for a shock, m/s^2: half of gravity.
const LEAST: f32 = 4.9;
/// Pause after which a peak is another shock and no ringing, microseconds.
const APART_US: u64 = 500_000;

/// Time after which a bias step of 0.1 deg/s has begun to show, microseconds; and the log Bayes factor from which a
/// step gives its place to no other.
const SHOWN_US: u64 = 5_000_000;
const KEPT: f32 = 2.0;

/// Shocks, and the steps of the bias that are looked for at them.
pub(super) struct Shocks {
    /// The hardest shaking of each of the latest half seconds, m/s^2.
    peaks: [f32; KNOWN],
    count: u32,
    peak: f32,
    until_us: u64,
    /// Specific force from which on there is a shock, m/s^2; 0: not known yet.
    least: f32,
    latest_us: u64,
    /// Time of each bias step's shock, microseconds; 0: no step.
    at_us: [u64; STEPS],
    /// Strength of each step's shock, m/s^2, and the step's log Bayes factor.
    hard: [f32; STEPS],
    shown: [f32; STEPS],
    /// Shocks so far, and those for whose bias step there was no place.
    pub seen: u32,
    pub lost: u32,
}

impl Shocks {
    pub const fn zero() -> Self {
        Self {
            peaks: [0.0; KNOWN],
            count: 0,
            peak: 0.0,
            until_us: 0,
            least: 0.0,
            latest_us: 0,
            at_us: [0; STEPS],
            hard: [0.0; STEPS],
            shown: [0.0; STEPS],
            seen: 0,
            lost: 0,
        }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Time of a bias step, microseconds.
    pub fn at_us(&self, step: u8) -> Option<u64> {
        self.at_us.get(usize::from(step)).copied().filter(|us| *us > 0)
    }

    pub fn drop_step(&mut self, step: u8) {
        if let Some(us) = self.at_us.get_mut(usize::from(step)) {
            *us = 0;
        }
    }

    /// Takes the hardest specific force of an increment, m/s^2. Returns true if a shock begins.
    pub fn look_at(&mut self, end_us: u64, peak: f32) -> bool {
        let mut is_new = false;
        if self.least > 0.0 && peak > self.least {
            if end_us > self.latest_us.saturating_add(APART_US) {
                self.seen = self.seen.saturating_add(1);
                is_new = true;
            }
            self.latest_us = end_us;
        }
        self.peak = if peak > self.peak { peak } else { self.peak };
        if end_us >= self.until_us {
            self.until_us = end_us.saturating_add(PIECE_US);
            self.learn();
        }
        is_new
    }

    /// Place for a bias step at a shock: a free one; else of the step with the least evidence among those that have had
    /// the time to show; else of the softest shock, if it was softer than this one. `None` if all keep their places.
    fn place(&self, now_us: u64, hard: f32) -> Option<u8> {
        let mut least: Option<(u8, [f32; 2])> = None;
        for (((step, us), shown), shock) in (0..).zip(&self.at_us).zip(&self.shown).zip(&self.hard) {
            if *us == 0 {
                return Some(step);
            }
            let rank = match us.saturating_add(SHOWN_US) < now_us {
                true if *shown < KEPT => [0.0, *shown],
                false if *shown < KEPT && *shock < hard => [1.0, *shock],
                _ => continue,
            };
            if least.is_none_or(|(_, known)| rank < known) {
                least = Some((step, rank));
            }
        }
        least.map(|(step, _)| step)
    }

    /// Looks for a bias step at a shock. Returns the place that it takes, perhaps from another step; `None`: there is
    /// none.
    pub fn begin_step(&mut self, at_us: u64, hard: f32) -> Option<u8> {
        let place = self.place(at_us, hard);
        let slot = place.map(usize::from);
        let slots = (&mut self.at_us, &mut self.shown, &mut self.hard);
        match slot.and_then(|slot| Some((slots.0.get_mut(slot)?, slots.1.get_mut(slot)?, slots.2.get_mut(slot)?))) {
            Some((us, shown, shock)) => (*us, *shown, *shock) = (at_us, 0.0, hard),
            None => self.lost = self.lost.saturating_add(1),
        }
        place
    }

    /// Notes the evidence of a step, a log Bayes factor.
    pub fn show(&mut self, step: u8, evidence: f32) {
        if let Some(shown) = self.shown.get_mut(usize::from(step)) {
            *shown = evidence;
        }
    }

    fn learn(&mut self) {
        if let Some(slot) = self.peaks.get_mut(self.count as usize % KNOWN) {
            *slot = core::mem::replace(&mut self.peak, 0.0);
        }
        self.count = self.count.wrapping_add(1);
        let known = if (self.count as usize) < KNOWN { self.count as usize } else { KNOWN };
        if known < FEWEST {
            return;
        }
        let mut peaks = self.peaks;
        let peaks = peaks.get_mut(..known).unwrap_or_default();
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|share| quantile(peaks, share));
        let over = SHOCK * (high - low);
        self.least = middle + if over > LEAST { over } else { LEAST };
    }
}
