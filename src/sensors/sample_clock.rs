//! Sample clock: times of a part's frames, from the times at which it is read.

/// Meaning of the time at which a source is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Trigger {
    /// Time of the part's interrupt: the newest frame was put out then.
    Interrupt,
    /// Any time: the newest frame was put out at most one period before.
    #[default]
    Polled,
}

/// Bits of the clock's fraction: its unit is a 256th of a microsecond.
const FRACTION: u32 = 8;
/// Shift of the phase's correction by an interrupt, per burst.
const PHASE_GAIN: u32 = 3;
/// Part of the period within which a prompt interrupt is served.
const PROMPT: i64 = 4;
/// Frames over which the period is measured, again and again.
const COUNTED: i64 = 1_024;

/// Clock of frames that a part's own oscillator paces, from their number and the times at which they were
/// taken.
///
/// Polled, each burst bounds the newest frame's time to one period or to the time since the last poll, and
/// the bounds are carried on: a stamp is the middle of their overlap, within a period of the truth and
/// usually much closer. With an interrupt the clock follows it, smoothed over eight bursts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleClock {
    nominal: i64,
    tolerance: i64,
    trigger: Trigger,
    period: i64,
    /// Largest error of the period.
    doubt: i64,
    /// Start of the period's measurement, and the frames since.
    anchor: Option<i64>,
    counted: i64,
    newest: Option<Newest>,
    /// Frames known and not yet taken out.
    pending: i64,
    /// True if frames may have been lost since the last burst.
    lossy: bool,
    /// Time at which the part was last asked; a new frame came after it.
    asked: Option<i64>,
}

/// Last known frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Newest {
    t: i64,
    /// Largest error of that time.
    doubt: i64,
    /// Time at which it became known; `None` if frames may be missing since.
    seen: Option<i64>,
}

/// Times of a burst's frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamps {
    /// Number of frames up to the newest in the part, and of those that are new.
    known: i64,
    new: i64,
    newest: i64,
    /// Interval between new frames.
    step: i64,
    /// Newest frame of the burst before.
    before: i64,
    period: i64,
    /// Frames that the part must have put out and that never came.
    pub lost: u32,
}

impl Stamps {
    /// Time of output of frame `k` of the burst, microseconds; `None` before time zero.
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
        Self {
            nominal,
            tolerance,
            trigger,
            period: nominal,
            doubt: tolerance,
            anchor: None,
            counted: 0,
            newest: None,
            pending: 0,
            lossy: false,
            asked: None,
        }
    }

    /// Notes that frames may be missing; those that are not remain in step with those before.
    pub fn interrupt(&mut self) {
        self.pending = 0;
        self.anchor = None;
        self.lossy = true;
    }

    /// Notes a new start of the part: the next burst's newest frame is of the time at which it is taken.
    pub fn resynchronise(&mut self) {
        self.interrupt();
        if let Some(newest) = &mut self.newest {
            newest.seen = None;
        }
    }

    /// Notes that the part was asked and had no new frame.
    pub fn had_none(&mut self, now_us: u64) {
        self.asked = Some(fixed(now_us));
    }

    /// Whole periods since the last frame.
    pub fn periods_since(&self, now_us: u64) -> u32 {
        self.newest.map_or(0, |newest| u32::try_from((fixed(now_us) - newest.t) / self.period.max(1)).unwrap_or(0))
    }

    /// Returns true if a part without a FIFO cannot have measured again by now; `repeated` means that it
    /// shows the codes of the frame before.
    pub fn is_early(&self, now_us: u64, repeated: bool) -> bool {
        let Some(Newest { t, doubt, seen: Some(seen) }) = self.newest else { return false };
        let (now, least) = (fixed(now_us), self.period - self.doubt);
        // There is a new reading within a period of the time at which the last was read.
        let again = repeated && now - seen < self.period + self.doubt;
        again || t - doubt + least > now + self.slack()
    }

    /// Stamps a burst of `taken` frames, after which `left` are still in the part, taken at `now_us`.
    pub fn stamp(&mut self, now_us: u64, taken: usize, left: u16) -> Stamps {
        let now = fixed(now_us);
        let (known, left) = (taken as i64 + i64::from(left), i64::from(left));
        let new = known - self.pending;
        let (mut lost, newest) = match self.newest {
            // These are the rest of what was left before.
            Some(newest) if new <= 0 && newest.seen.is_some() => (0, newest),
            Some(Newest { t, doubt, seen: Some(_) }) => {
                self.follow_period(now, new);
                let (lost, newest) = self.carried_on(now, t + new * self.period, doubt + new * self.doubt);
                if lost > 0 {
                    // Frames may have been lost unseen before, so that the period is not what it seemed.
                    (self.period, self.doubt) = (self.nominal, self.tolerance);
                }
                (lost, newest)
            }
            Some(Newest { t, .. }) => {
                let newest = self.taken_now(now);
                (rounded(newest.t - t, self.period) - new, newest)
            }
            None => (0, self.taken_now(now)),
        };
        lost = lost.max(0);
        if lost > 0 || self.anchor.is_none() {
            (self.anchor, self.counted) = (Some(now), 0);
        }
        let before = self.newest.map_or(newest.t - new * self.period, |newest| newest.t);
        // Between two bursts without loss the frames are evenly spread, however the phase was corrected.
        let step = match new {
            1 if lost == 0 => newest.t - before,
            2.. if lost == 0 => (newest.t - before) / new,
            _ => self.period,
        };
        self.newest = Some(newest);
        self.asked = Some(now);
        self.pending = left;
        self.lossy = false;
        Stamps {
            known,
            new,
            newest: newest.t,
            step,
            before,
            period: self.period,
            lost: u32::try_from(lost).unwrap_or(0),
        }
    }

    /// Newest frame, known only to be there now.
    fn taken_now(&self, now: i64) -> Newest {
        let doubt = match self.trigger {
            Trigger::Interrupt => 0,
            Trigger::Polled => (now - self.earliest(now)) / 2,
        };
        Newest { t: now - doubt, doubt, seen: Some(now) }
    }

    /// Newest frame, expected at `t` within a doubt, and the number missing before it.
    fn carried_on(&self, now: i64, t: i64, doubt: i64) -> (i64, Newest) {
        let (period, slack) = (self.period.max(1), self.slack());
        if self.lossy && doubt > period / PROMPT {
            // After so long a time the phase is not known any more.
            let newest = self.taken_now(now);
            return (rounded(newest.t - t, period), newest);
        }
        let late = now - t - doubt;
        let lost = rounded(late, period).max(0);
        // A later interrupt says only what a poll does: the newest frame is of the last period.
        let prompt = (late - lost * period).abs() <= period / PROMPT;
        if self.trigger == Trigger::Interrupt && prompt {
            let t = t + lost * period;
            // While the period is uncertain the interrupt is better.
            let t = if doubt > slack { now } else { t + ((now - t) >> PHASE_GAIN) };
            return (lost, Newest { t, doubt: 0, seen: Some(now) });
        }
        let (earliest, latest) = (self.earliest(now) - slack, now + slack);
        let lost = if self.lossy {
            // The expected time that lies within the last period; fewer frames than there seemed to be where
            // some that were read were none.
            (latest - t).div_euclid(period)
        } else {
            let missing = earliest - (t + doubt);
            let lost = if missing > 0 { 1 + missing / period } else { 0 };
            // If there was no time for one frame more, the bounds are a little too narrow.
            if lost > 0 && t + lost * period - doubt > latest { lost - 1 } else { lost }
        };
        let t = t + lost * period;
        let least = if t - doubt > earliest { t - doubt } else { earliest };
        let most = if t + doubt < latest { t + doubt } else { latest };
        // More frames than there was time for: the newest is of now.
        let least = if least > most { most } else { least };
        (lost, Newest { t: (least + most) / 2, doubt: (most - least) / 2, seen: Some(now) })
    }

    /// Earliest time of the newest of the frames that came since the part was last asked.
    fn earliest(&self, now: i64) -> i64 {
        let a_period_ago = now - self.period;
        self.asked.map_or(a_period_ago, |asked| asked.max(a_period_ago))
    }

    /// Tolerance of a frame's time, for the time that the bus takes.
    fn slack(&self) -> i64 {
        self.period >> 4
    }

    /// Measures the period: `n` of them span the time between two bursts, to a period.
    fn follow_period(&mut self, now: i64, new: i64) {
        let Some(anchor) = self.anchor else { return };
        self.counted += new;
        let ends = self.period + 2 * self.slack();
        if self.counted * self.doubt > ends {
            let counted = self.counted.max(1);
            let period = (now - anchor) / counted;
            let (least, most) = (self.nominal - self.tolerance, self.nominal + self.tolerance);
            self.period = if period < least {
                least
            } else if period > most {
                most
            } else {
                period
            };
            self.doubt = ends / counted;
        }
        if self.counted >= COUNTED {
            (self.anchor, self.counted) = (Some(now), 0);
            // So that it is measured again within as many frames.
            self.doubt = ends / (COUNTED / 2);
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
