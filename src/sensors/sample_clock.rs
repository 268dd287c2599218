/// How the time that a source is read at belongs to the part's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Trigger {
    /// It is the time of the part's interrupt: the newest frame was put out then.
    Interrupt,
    /// It is any time: the newest frame was put out at most one period before.
    #[default]
    Polled,
}

/// A 256th of a microsecond.
const FRACTION: u32 = 8;
/// The phase follows the interrupt by this power of two per burst.
const PHASE_GAIN: u32 = 3;
/// An interrupt is served within this part of the period.
const PROMPT: i64 = 4;
/// Frames over which the period is measured, again and again.
const COUNTED: i64 = 1_024;

/// Times of frames that a part's own oscillator paces, from their number and from the times at which they were taken.
///
/// Polled, each burst bounds the newest frame's time to one period or to the time since the last poll, and the bounds are carried on: a stamp is the middle of where they overlap,
/// within a period of the truth and usually much closer. With an interrupt it follows that, smoothed over eight bursts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleClock {
    nominal: i64,
    tolerance: i64,
    trigger: Trigger,
    period: i64,
    /// How far the period may be off.
    doubt: i64,
    /// Where the measurement of the period began, and the frames since.
    anchor: Option<i64>,
    counted: i64,
    newest: Option<Newest>,
    /// Frames known and not yet taken out.
    pending: i64,
    /// Frames may have been lost since the last burst.
    lossy: bool,
    /// When the part was last asked: a new frame came after that.
    asked: Option<i64>,
}

/// The last frame that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Newest {
    t: i64,
    /// How far that may be off.
    doubt: i64,
    /// When it became known; `None`: frames may be missing since.
    seen: Option<i64>,
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
    /// The newest frame of the burst before.
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

    /// Frames may be missing: those that are not are still in step with those before.
    pub fn interrupt(&mut self) {
        self.pending = 0;
        self.anchor = None;
        self.lossy = true;
    }

    /// The part was started anew: the next burst's newest frame is of the time at which it is taken.
    pub fn resynchronise(&mut self) {
        self.interrupt();
        if let Some(newest) = &mut self.newest {
            newest.seen = None;
        }
    }

    /// The part was asked, and had no new frame.
    pub fn had_none(&mut self, now_us: u64) {
        self.asked = Some(fixed(now_us));
    }

    /// How long ago the last frame was, in whole periods.
    pub fn periods_since(&self, now_us: u64) -> u32 {
        self.newest.map_or(0, |newest| u32::try_from((fixed(now_us) - newest.t) / self.period.max(1)).unwrap_or(0))
    }

    /// Whether a part without a FIFO cannot have measured again by now. `repeated`: it shows the codes of the frame before.
    pub fn is_early(&self, now_us: u64, repeated: bool) -> bool {
        let Some(Newest { t, doubt, seen: Some(seen) }) = self.newest else { return false };
        let (now, least) = (fixed(now_us), self.period - self.doubt);
        // There is a new reading within a period of the time at which the last was read.
        let again = repeated && now - seen < self.period + self.doubt;
        again || t - doubt + least > now + self.slack()
    }

    /// Times for a burst of `taken` frames after which `left` are still in the part, taken at `now_us`.
    pub fn stamp(&mut self, now_us: u64, taken: usize, left: u16) -> Stamps {
        let now = fixed(now_us);
        let (known, left) = (taken as i64 + i64::from(left), i64::from(left));
        let new = known - self.pending;
        let (mut lost, newest) = match self.newest {
            // The rest of what was left before.
            Some(newest) if new <= 0 && newest.seen.is_some() => (0, newest),
            Some(Newest { t, doubt, seen: Some(_) }) => {
                self.follow_period(now, new);
                let (lost, newest) = self.carried_on(now, t + new * self.period, doubt + new * self.doubt);
                if lost > 0 {
                    // Some may have been lost unseen before, and the period then is not what it seemed.
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
        // Between two bursts with no loss the frames are evenly spread, however the phase was put right.
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

    /// The newest frame, of which nothing is known but that it was there now.
    fn taken_now(&self, now: i64) -> Newest {
        let doubt = match self.trigger {
            Trigger::Interrupt => 0,
            Trigger::Polled => (now - self.earliest(now)) / 2,
        };
        Newest { t: now - doubt, doubt, seen: Some(now) }
    }

    /// The newest frame, which should have come at `t`, give or take a doubt, and how many are missing before it.
    fn carried_on(&self, now: i64, t: i64, doubt: i64) -> (i64, Newest) {
        let (period, slack) = (self.period.max(1), self.slack());
        if self.lossy && doubt > period / PROMPT {
            // It has been so long that the phase is not known any more.
            let newest = self.taken_now(now);
            return (rounded(newest.t - t, period), newest);
        }
        let late = now - t - doubt;
        let lost = rounded(late, period).max(0);
        // An interrupt that is served later than this says only what a poll does: the newest frame is of the last period.
        let prompt = (late - lost * period).abs() <= period / PROMPT;
        if self.trigger == Trigger::Interrupt && prompt {
            let t = t + lost * period;
            // While the period is not known well the interrupt knows better.
            let t = if doubt > slack { now } else { t + ((now - t) >> PHASE_GAIN) };
            return (lost, Newest { t, doubt: 0, seen: Some(now) });
        }
        let (earliest, latest) = (self.earliest(now) - slack, now + slack);
        let lost = if self.lossy {
            // The one of the times that it can be of that lies within the last period; fewer frames than there seemed to be where
            // what was read were none.
            (latest - t).div_euclid(period)
        } else {
            let missing = earliest - (t + doubt);
            let lost = if missing > 0 { 1 + missing / period } else { 0 };
            // Where there was no time for one frame more, the bounds are a little too narrow.
            if lost > 0 && t + lost * period - doubt > latest { lost - 1 } else { lost }
        };
        let t = t + lost * period;
        let least = if t - doubt > earliest { t - doubt } else { earliest };
        let most = if t + doubt < latest { t + doubt } else { latest };
        // More frames than there was time for: the newest is of now.
        let least = if least > most { most } else { least };
        (lost, Newest { t: (least + most) / 2, doubt: (most - least) / 2, seen: Some(now) })
    }

    /// The newest of the frames that are there now, and were not when the part was asked before, is not older than this.
    fn earliest(&self, now: i64) -> i64 {
        let a_period_ago = now - self.period;
        self.asked.map_or(a_period_ago, |asked| asked.max(a_period_ago))
    }

    /// How much earlier or later than it is said a frame may have been taken: what the bus takes.
    fn slack(&self) -> i64 {
        self.period >> 4
    }

    /// Measures the period: `n` of them are the time between two bursts, to a period.
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
            // So that it is measured once more within as many.
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
