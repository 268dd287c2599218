/// How the time that a source is read at belongs to the part's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Trigger {
    /// It is the time of the part's interrupt: the newest frame was put out then.
    Interrupt,
    /// It is any time: the newest frame was put out at most one period before.
    #[default]
    Polled,
}

/// A 256th of a microsecond.
const FRACTION: u32 = 8;
/// The period follows what is seen by this power of two per burst.
const PERIOD_GAIN: u32 = 9;
/// An interrupt that is served within this part of the period is prompt, and says when the newest frame was put out. Of a later one only this is
/// known: the newest frame is of the last period.
const PROMPT: i64 = 4;
/// After so many late bursts in a row it is the clock that is off.
const LATE_BURSTS: u8 = 8;
/// The phase follows the interrupt by this power of two per burst.
const PHASE_GAIN: u32 = 3;

/// Times of frames that a part's own oscillator paces, from their number and from the times at which they were taken.
///
/// The part's period is estimated within its tolerance. With an interrupt a stamp is within an eighth of the interrupt's jitter; polled, within
/// a period of the truth, and steady from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleClock {
    nominal: i64,
    tolerance: i64,
    trigger: Trigger,
    period: i64,
    /// The last frame known, and when it became known.
    newest: Option<(i64, i64)>,
    /// Frames known and not yet taken out.
    pending: i64,
    /// The part has not been started anew since the last frame.
    in_phase: bool,
    /// Frames may have been lost since the last burst.
    lossy: bool,
    /// Frames at which the interrupt comes: more of them were taken late.
    watermark: i64,
    /// Bursts in a row that were taken late.
    late_bursts: u8,
}

/// Times of a burst's frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamps {
    first: i64,
    period: i64,
    /// Frames that the part must have put out and that never came.
    pub lost: u32,
}

impl Stamps {
    /// When frame `k` of the burst was put out, microseconds; `None`: before time zero.
    pub fn t_us(&self, k: usize) -> Option<u64> {
        u64::try_from((self.first + self.period * k as i64) >> FRACTION).ok()
    }
}

impl SampleClock {
    pub fn new(period_us: u32, tolerance: f32, watermark: u16, trigger: Trigger) -> Self {
        let nominal = i64::from(period_us.max(1)) << FRACTION;
        let tolerance = (nominal as f32 * tolerance) as i64;
        Self {
            nominal,
            tolerance,
            trigger,
            period: nominal,
            newest: None,
            pending: 0,
            in_phase: false,
            lossy: false,
            watermark: watermark.into(),
            late_bursts: 0,
        }
    }

    /// The part was started anew: the next burst's newest frame is of the time at which it is taken.
    pub fn restart(&mut self) {
        self.pending = 0;
        self.in_phase = false;
    }

    /// Frames may be missing: those that are not are still in step with those before.
    pub fn interrupt(&mut self) {
        self.pending = 0;
        self.lossy = true;
    }

    /// How long ago the last frame was, in whole periods.
    pub fn periods_since(&self, now_us: u64) -> u32 {
        let now = fixed(now_us);
        self.newest.map_or(0, |(newest, _)| u32::try_from((now - newest) / self.period.max(1)).unwrap_or(0))
    }

    /// Half a period, microseconds.
    pub fn half_a_period_us(&self) -> u64 {
        u64::try_from(self.period >> (FRACTION + 1)).unwrap_or(0)
    }

    /// Times for a burst of `taken` frames after which `left` are still in the part, taken at `now_us`.
    pub fn stamp(&mut self, now_us: u64, taken: usize, left: u16) -> Stamps {
        let now = fixed(now_us);
        let (known, left) = (taken as i64 + i64::from(left), i64::from(left));
        let new = known - self.pending;
        let rest = match self.trigger {
            Trigger::Interrupt if known <= self.watermark => 0,
            _ => self.period / 2,
        };
        let mut lost = 0;
        let newest = match self.newest {
            Some((newest, seen)) if self.in_phase => {
                let predicted = newest + new * self.period;
                match self.trigger {
                    Trigger::Interrupt => {
                        // The newest frame is of the last period. A burst that is no larger than usual was most likely taken as promptly as
                        // usual; a larger one was not, and says how many frames there were, unless some may have been lost.
                        let doubt = match (known > self.watermark, self.lossy) {
                            (false, _) => self.period / PROMPT,
                            (true, true) => self.period / (2 * PROMPT),
                            (true, false) => -self.period / PROMPT,
                        };
                        lost = (now - predicted + doubt).div_euclid(self.period.max(1)).max(0);
                        let expected = predicted + lost * self.period;
                        let late = now - expected;
                        self.late_bursts =
                            if late > self.period / PROMPT { self.late_bursts.saturating_add(1) } else { 0 };
                        if lost == 0 && self.late_bursts == 0 {
                            self.follow_period(now - seen, new);
                        }
                        if late < -self.period / PROMPT {
                            now
                        } else if self.late_bursts == 0 || self.late_bursts > LATE_BURSTS {
                            expected + (late >> PHASE_GAIN)
                        } else if expected > now {
                            now
                        } else {
                            expected
                        }
                    }
                    Trigger::Polled => {
                        self.follow_period(now - seen, new);
                        lost = rounded(now - predicted, self.period) - 1;
                        let kept = predicted + lost.max(0) * self.period;
                        if kept > now {
                            now
                        } else if kept < now - self.period {
                            now - self.period
                        } else {
                            kept
                        }
                    }
                }
            }
            Some((newest, _)) => {
                lost = rounded(now - rest - newest, self.period) - new;
                now - rest
            }
            None => now - rest,
        };
        (self.in_phase, self.lossy) = (true, false);
        self.newest = Some((newest, now));
        self.pending = left;
        Stamps {
            first: newest - (known - 1) * self.period,
            period: self.period,
            lost: u32::try_from(lost).unwrap_or(0),
        }
    }

    fn follow_period(&mut self, elapsed: i64, new: i64) {
        // Beyond the tolerance it is a gap or a surplus, which says nothing about the period.
        let expected = new * self.period;
        if (elapsed - expected).abs() <= self.period.max(expected / 4) {
            let period = self.period + ((elapsed - expected) >> PERIOD_GAIN);
            let (least, most) = (self.nominal - self.tolerance, self.nominal + self.tolerance);
            self.period = if period < least {
                least
            } else if period > most {
                most
            } else {
                period
            };
        }
    }
}

fn fixed(t_us: u64) -> i64 {
    i64::try_from(t_us).unwrap_or(i64::MAX) << FRACTION
}

fn rounded(numerator: i64, denominator: i64) -> i64 {
    (numerator + denominator / 2).div_euclid(denominator.max(1))
}
