use crate::sensors::{
    Burst, Condition, Counters, Frame, Mounting, PartData, Scaled, StartError, Trigger,
    frozen::Frozen,
    recovery::Recovery,
    sample_clock::{SampleClock, Stamps},
};

/// After so many periods without a frame the part is started anew.
const SILENT_PERIODS: u32 = 10;

/// What is known of a part beside its registers: everything of a [`Supervised`](super::blocking::Supervised) source that needs no bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Supervision<const V: usize> {
    pub data: PartData<V>,
    pub counters: Counters,
    pub recovery: Recovery,
    clock: SampleClock,
    mounting: Mounting,
    frozen: [Frozen; V],
    was_frozen: bool,
    settling: u16,
    started_us: Option<u64>,
    last_t_us: Option<u64>,
}

impl<const V: usize> Supervision<V> {
    pub fn new(data: PartData<V>, mounting: Mounting, trigger: Trigger) -> Self {
        Self {
            data,
            counters: Counters::default(),
            recovery: Recovery::NEW,
            clock: SampleClock::new(data.period_us, data.period_tolerance, trigger),
            mounting,
            frozen: [Frozen::default(); V],
            was_frozen: false,
            settling: 0,
            started_us: None,
            last_t_us: None,
        }
    }

    pub fn start_failed<E>(&mut self, now_us: u64, error: &StartError<E>) {
        let count = match error {
            StartError::Bus(_) => &mut self.counters.bus_errors,
            StartError::WrongIdentity { .. } => &mut self.counters.wrong_identity,
            _ => &mut self.counters.failed_starts,
        };
        add(count, 1);
        self.recovery.pause(now_us);
    }

    pub fn started(&mut self, now_us: u64) {
        if self.started_us.is_some() {
            add(&mut self.counters.restarts, 1);
        }
        self.started_us = Some(now_us);
        self.settling = self.data.settling_frames;
        self.clock.resynchronise();
        self.recovery.started(now_us);
    }

    pub fn bus_failed(&mut self, now_us: u64) {
        add(&mut self.counters.bus_errors, 1);
        self.clock.resynchronise();
        self.recovery.bus_failed(now_us);
    }

    /// The part has lost its settings, and with them the frames of this burst.
    pub fn was_reset(&mut self) {
        add(&mut self.counters.resets, 1);
        self.clock.resynchronise();
        self.recovery.restart();
    }

    /// Whether the part has put nothing out for so long that it is to be started anew.
    pub fn is_silent(&mut self, now_us: u64) -> bool {
        let period_us = u64::from(self.data.period_us);
        let since_start = self.started_us.map_or(0, |started_us| now_us.saturating_sub(started_us));
        let silent = since_start > u64::from(SILENT_PERIODS) * period_us
            && (self.last_t_us.is_none() || self.clock.periods_since(now_us) > SILENT_PERIODS);
        if silent {
            add(&mut self.counters.silences, 1);
            self.recovery.pause(now_us);
        }
        silent
    }

    /// Whether a frame should have come by now.
    pub fn is_overdue(&self, now_us: u64) -> bool {
        self.last_t_us.is_none() || self.clock.periods_since(now_us) > 1
    }

    /// Hands each frame of a burst that may be believed to `out`, oldest first.
    pub fn take(&mut self, now_us: u64, burst: &Burst<V>, mut out: impl FnMut(Scaled<V>)) -> Condition {
        if burst.overrun {
            add(&mut self.counters.overruns, 1);
            self.clock.resynchronise();
        }
        add(&mut self.counters.corrupt_frames, burst.corrupt.into());
        let frames = burst.frames();
        if frames.is_empty() {
            self.clock.had_none(now_us);
        } else if !self.is_early(now_us, frames) {
            let stamps = self.clock.stamp(now_us, frames.len(), burst.left);
            add(&mut self.counters.lost_frames, stamps.lost);
            for (k, frame) in frames.iter().enumerate() {
                if let Some(scaled) = self.believed(k, frame, &stamps) {
                    add(&mut self.counters.readings, 1);
                    out(scaled);
                }
            }
        }
        self.recovery.was_read(now_us, !self.was_frozen);
        if self.was_frozen {
            self.recovery.restart_later(now_us);
            Condition::Frozen
        } else {
            Condition::Running
        }
    }

    /// Whether a part without a FIFO shows a reading again, or one that it cannot have measured yet.
    fn is_early(&mut self, now_us: u64, frames: &[Frame<V>]) -> bool {
        let repeats = |frame: &Frame<V>| {
            frame.codes.iter().zip(&self.frozen).all(|(codes, frozen)| codes.is_none_or(|codes| frozen.saw(codes)))
        };
        let early = self.data.fifo_frames == 1 && self.clock.is_early(now_us, frames.iter().all(repeats));
        if early {
            add(&mut self.counters.early_frames, 1);
        }
        early
    }

    /// Frame `k` of a burst with its time and units, unless the part has not settled.
    fn believed(&mut self, k: usize, frame: &Frame<V>, stamps: &Stamps) -> Option<Scaled<V>> {
        let t_us = stamps.t_us(k)?;
        if self.last_t_us.is_some_and(|last| t_us <= last) {
            add(&mut self.counters.early_frames, 1);
            return None;
        }
        self.last_t_us = Some(t_us);
        if self.settling > 0 {
            self.settling -= 1;
            return None;
        }
        Some(self.scaled(t_us, frame))
    }

    fn scaled(&mut self, t_us: u64, frame: &Frame<V>) -> Scaled<V> {
        let mut scaled = Scaled { t_us, vectors: [None; V], clipped: [false; V], temperature_c: None };
        let mut any_frozen = false;
        let sensors = self.data.sensors.iter().zip(&mut self.frozen).zip(frame.codes);
        for ((vector, clipped), ((sensor, frozen), codes)) in
            scaled.vectors.iter_mut().zip(&mut scaled.clipped).zip(sensors)
        {
            let Some(codes) = codes else { continue };
            if frozen.sees(codes, sensor.clip_code, self.data.frozen_frames) {
                any_frozen = true;
                continue;
            }
            *clipped = codes.iter().any(|code| code.abs() >= sensor.clip_code);
            *vector = Some(self.mounting.body(codes.map(|code| code as f32 * sensor.per_code)));
        }
        if any_frozen && !self.was_frozen {
            add(&mut self.counters.frozen, 1);
        }
        self.was_frozen = any_frozen;
        if let (Some(thermometer), Some(code)) = (self.data.temperature, frame.temperature) {
            scaled.temperature_c = Some(thermometer.offset_c + thermometer.per_code_c * code as f32);
        }
        scaled
    }
}

/// Counts, as far as the counter goes.
pub(super) fn add(counter: &mut u32, number: u32) {
    *counter = counter.saturating_add(number);
}
