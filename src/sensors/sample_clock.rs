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
/// The period is the mean over this power of two of frames; fewer at first.
const PERIOD_GAIN: u32 = 10;
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
    /// Frames that the period is the mean of, up to the greatest number.
    seen: i64,
}

/// Times of a burst's frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamps {
    /// How many frames there are up to the newest in the part, and how many of them are new.
    known: i64,
    new: i64,
    newest: i64,
    /// From new frame to new frame.
    step: i64,
    /// The newest frame of the burst before, and the step up to it.
    before: i64,
    period: i64,
    /// Frames that the part must have put out and that never came.
    pub lost: u32,
}

impl Stamps {
    /// When frame `k` of the burst was put out, microseconds; `None`: before time zero.
    pub fn t_us(&self, k: usize) -> Option<u64> {
        let back = self.known - 1 - k as i64;
        let t = if back < self.new {
            self.newest - back * self.step
        } else {
            self.before - (back - self.new) * self.period
        };
        u64::try_from(t >> FRACTION).ok()
    }
}

impl SampleClock {
    pub fn new(period_us: u32, tolerance: f32, trigger: Trigger) -> Self {
        let nominal = i64::from(period_us.max(1)) << FRACTION;
        let tolerance = (nominal as f32 * tolerance) as i64;
        Self { nominal, tolerance, trigger, period: nominal, newest: None, pending: 0, seen: 0 }
    }

    /// Frames may be missing, or the part was started anew: the next burst's newest frame is of the time at which it is taken.
    pub fn resynchronise(&mut self) {
        self.pending = 0;
        if let Some((newest, _)) = self.newest {
            self.newest = Some((newest, i64::MIN));
        }
    }

    /// How long ago the last frame was, in whole periods.
    pub fn periods_since(&self, now_us: u64) -> u32 {
        let now = fixed(now_us);
        self.newest.map_or(0, |(newest, _)| u32::try_from((now - newest) / self.period.max(1)).unwrap_or(0))
    }

    /// Whether a part without a FIFO cannot have measured again by now. `repeated`: it shows the codes of the frame before.
    pub fn is_early(&self, now_us: u64, repeated: bool) -> bool {
        let Some((newest, seen)) = self.newest else { return false };
        let now = fixed(now_us);
        // There is a new reading within a period of the time at which the last was read; a stamp is known to a period only.
        let again = repeated && now.saturating_sub(seen) < self.period + self.period / 16;
        seen != i64::MIN && (again || newest + self.period - now > self.period / 8 * 7)
    }

    /// Times for a burst of `taken` frames after which `left` are still in the part, taken at `now_us`.
    pub fn stamp(&mut self, now_us: u64, taken: usize, left: u16) -> Stamps {
        let now = fixed(now_us);
        let (known, left) = (taken as i64 + i64::from(left), i64::from(left));
        let new = known - self.pending;
        let rest = match self.trigger {
            Trigger::Interrupt => 0,
            Trigger::Polled => self.period / 2,
        };
        let mut lost = 0;
        let newest = match self.newest {
            None => now - rest,
            Some((newest, i64::MIN)) => {
                lost = rounded(now - rest - newest, self.period) - new;
                now - rest
            }
            Some((newest, seen)) => {
                self.follow_period(now - seen, new);
                let predicted = newest + new * self.period;
                match self.trigger {
                    Trigger::Interrupt => {
                        lost = rounded(now - predicted, self.period);
                        let late = now - predicted - lost * self.period;
                        predicted + lost * self.period + (late >> PHASE_GAIN)
                    }
                    Trigger::Polled => {
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
        };
        let before = self.newest.map_or(newest - new * self.period, |(before, _)| before);
        // Between two bursts with no loss the frames are evenly spread, however the phase was put right.
        let step = if lost <= 0 && new == 1 {
            newest - before
        } else if lost <= 0 && new > 1 {
            ((newest - before) / new).min(self.period * 2)
        } else {
            self.period
        };
        self.newest = Some((newest, now));
        self.pending = left;
        Stamps { known, new, newest, step, before, period: self.period, lost: u32::try_from(lost).unwrap_or(0) }
    }

    /// The mean over all frames so far, as a power of two.
    fn gain(&self) -> u32 {
        self.seen.max(1).ilog2().min(PERIOD_GAIN)
    }

    fn follow_period(&mut self, elapsed: i64, new: i64) {
        // Beyond the tolerance it is a gap or a surplus, which says nothing about the period.
        let surplus = elapsed - new * self.period;
        if surplus.abs() <= self.period + new * self.tolerance {
            self.seen = (self.seen + new).min(1 << PERIOD_GAIN);
            let period = self.period + (surplus >> self.gain());
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
    // The usual case, without a division of 64 bits.
    if 2 * numerator.abs() < denominator {
        return 0;
    }
    (numerator + denominator / 2).div_euclid(denominator.max(1))
}
