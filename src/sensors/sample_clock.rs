//! Sample clock: times of a part's frames, from the times at which the part is read.

/// Cause of a reading, which tells the meaning of its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Trigger {
    /// The part's interrupt: the newest frame was put out then.
    Interrupt,
    /// Nothing, at the time of the call: the newest frame was put out at most one period before. Its time is half a
    /// period before, and errs by up to as much.
    Polled,
}

/// Fractional bits of the clock's times: their unit is a 256th of a microsecond.
const FRACTION: u32 = 8;
/// Right shift of the phase's correction by an interrupt: an eighth per burst.
const PHASE_GAIN: u32 = 3;
/// Divisor of the period: an interrupt served within a quarter of it is prompt.
const PROMPT: i64 = 4;
/// Frames after which the measurement of the period starts again.
const COUNTED: i64 = 1_024;

/// Clock of frames that a part's own oscillator paces, from their number and the times at which they were
/// taken.
///
/// Polled, each burst bounds the newest frame's time to one period or to the time since the last poll, and the bounds
/// of earlier bursts are carried on: a stamp is the middle of their overlap, within a period of the truth and usually
/// much closer. The clock follows the times of interrupts, smoothed over eight bursts; what is read without one in
/// between, for it was noted late or missed, is bounded as by a poll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleClock {
    nominal: i64,
    tolerance: i64,
    period: i64,
    /// Largest error of the period.
    doubt: i64,
    /// Start of the period's measurement, and the frames since.
    anchor: Option<End>,
    counted: i64,
    newest: Option<Newest>,
    /// Frames known to be in the part and not yet taken out.
    pending: i64,
    /// True if frames may have been lost since the last burst.
    lossy: bool,
    /// Time of the last poll of the part; any new frame came after it.
    asked: Option<i64>,
}

/// Last known frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Newest {
    t: i64,
    /// Largest error of `t`.
    doubt: i64,
    /// Time at which the frame became known; `None` if frames may be missing since.
    seen: Option<i64>,
}

/// End of a measurement of the period: the time of a burst's newest frame by this burst alone.
#[derive(Clone, Copy, Debug, PartialEq)]
struct End {
    t: i64,
    /// Largest error of `t`.
    doubt: i64,
}

/// Times of a burst's frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamps {
    /// Number of frames taken out or left in the part, and of those that are new in this burst.
    known: i64,
    new: i64,
    newest: i64,
    /// Interval between new frames.
    step: i64,
    /// Time of the newest frame of the burst before.
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
    pub fn new(period_us: u32, tolerance: f32) -> Self {
        let nominal = i64::from(period_us.max(1)) << FRACTION;
        let tolerance = (nominal as f32 * tolerance) as i64;
        Self {
            nominal,
            tolerance,
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

    /// Notes that frames may be missing; those that come are in phase with the frames before.
    pub fn interrupt(&mut self) {
        self.pending = 0;
        self.anchor = None;
        self.lossy = true;
    }

    /// Notes a new start of the part: the phase is lost, and the next burst's newest frame gets the time at which it
    /// is taken.
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
    pub fn stamp(&mut self, now_us: u64, trigger: Trigger, taken: usize, left: u16) -> Stamps {
        let now = fixed(now_us);
        // Frames that were counted before an interruption may be counted again.
        let was_lossy = self.lossy;
        let (end, taken_now) = (self.end(now, trigger), self.taken_now(now, trigger));
        let (known, left) = (taken as i64 + i64::from(left), i64::from(left));
        let new = known - self.pending;
        let (mut lost, newest) = match self.newest {
            // All these frames were known before: the part held them after an earlier burst.
            Some(newest) if new <= 0 && newest.seen.is_some() => (0, newest),
            Some(Newest { t, doubt, seen: Some(_) }) => {
                self.follow_period(end, new);
                let (lost, newest) =
                    self.carried_on(now, trigger, taken_now, t + new * self.period, doubt + new * self.doubt);
                if lost > 0 {
                    // Earlier losses may have gone unnoticed, so that the measured period is wrong.
                    (self.period, self.doubt) = (self.nominal, self.tolerance);
                }
                (lost, newest)
            }
            Some(Newest { t, .. }) => (rounded(taken_now.t - t, self.period) - new, taken_now),
            None => (0, taken_now),
        };
        lost = lost.max(0);
        if lost > 0 || self.anchor.is_none() {
            (self.anchor, self.counted) = (Some(end), 0);
        }
        let before = self.newest.map_or(newest.t - new * self.period, |newest| newest.t);
        // Between two bursts without loss the frames are evenly spread, however the phase was corrected.
        let step = match new {
            1 if lost == 0 && !was_lossy => newest.t - before,
            2.. if lost == 0 && !was_lossy => (newest.t - before) / new,
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

    /// Time of the newest frame, known only to be in the part by `now`.
    fn taken_now(&self, now: i64, trigger: Trigger) -> Newest {
        let doubt = match trigger {
            Trigger::Interrupt => 0,
            Trigger::Polled => (now - self.earliest(now)) / 2,
        };
        Newest { t: now - doubt, doubt, seen: Some(now) }
    }

    /// Returns the number of frames lost before the newest, and the newest, expected at `t` within `doubt`.
    fn carried_on(&self, now: i64, trigger: Trigger, taken_now: Newest, t: i64, doubt: i64) -> (i64, Newest) {
        let (period, slack) = (self.period.max(1), self.slack());
        if self.lossy && doubt > period / PROMPT {
            // The error has grown beyond a quarter of the period: the phase is unknown.
            return (rounded(taken_now.t - t, period), taken_now);
        }
        let late = now - t - doubt;
        let lost = rounded(late, period).max(0);
        // An interrupt served late bounds the newest frame only as a poll does: to the last period.
        let prompt = (late - lost * period).abs() <= period / PROMPT;
        if trigger == Trigger::Interrupt && prompt {
            let t = t + lost * period;
            // While the period is uncertain the interrupt's time is better.
            let t = if doubt > slack { now } else { t + ((now - t) >> PHASE_GAIN) };
            return (lost, Newest { t, doubt: 0, seen: Some(now) });
        }
        let (earliest, latest) = (self.earliest(now) - slack, now + slack);
        let lost = if self.lossy {
            // Whole periods that bring the expected time into the last period; negative, for fewer frames than there
            // seemed to be, if some that were read were not real.
            (latest - t).div_euclid(period)
        } else {
            let missing = earliest - (t + doubt);
            let lost = if missing > 0 { 1 + missing / period } else { 0 };
            // If there was no time for the last of them, it was not lost: the bounds are a little too narrow.
            if lost > 0 && t + lost * period - doubt > latest { lost - 1 } else { lost }
        };
        let t = t + lost * period;
        let least = if t - doubt > earliest { t - doubt } else { earliest };
        let most = if t + doubt < latest { t + doubt } else { latest };
        // More frames came than there was time for: the newest gets the latest possible time.
        let least = if least > most { most } else { least };
        (lost, Newest { t: (least + most) / 2, doubt: (most - least) / 2, seen: Some(now) })
    }

    /// Earliest possible time of the newest frame: the last poll, or a period ago if that is later.
    fn earliest(&self, now: i64) -> i64 {
        let a_period_ago = now - self.period;
        self.asked.map_or(a_period_ago, |asked| asked.max(a_period_ago))
    }

    /// Tolerance of a frame's time, for the time that the bus takes.
    fn slack(&self) -> i64 {
        self.period >> 4
    }

    /// Time of a burst's newest frame, by this burst alone. A poll soon after another tells no more than any other:
    /// frames may have been lost between them unnoticed.
    fn end(&self, now: i64, trigger: Trigger) -> End {
        let doubt = match trigger {
            Trigger::Interrupt => 0,
            Trigger::Polled => self.period / 2,
        };
        End { t: now - doubt, doubt: doubt + self.slack() }
    }

    /// Measures the period: the time since the anchor over the frames counted, exact to the doubts of both ends.
    fn follow_period(&mut self, end: End, new: i64) {
        let Some(anchor) = self.anchor else { return };
        self.counted += new;
        let ends = anchor.doubt + end.doubt;
        if self.counted * self.doubt > ends {
            let counted = self.counted.max(1);
            let period = (end.t - anchor.t) / counted;
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
            (self.anchor, self.counted) = (Some(end), 0);
            // Widen the doubt, so that the period is measured again within the next `COUNTED` frames.
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
