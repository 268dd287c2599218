//! Supervision of a part, without its bus: silence, frozen sensors, readings not believed, restarts.

use crate::sensors::{
    Burst, Condition, Counters, Frame, Mounting, PartData, Scaled, StartError, Trigger,
    frozen::Frozen,
    innovation::Innovation,
    recovery::Recovery,
    sample_clock::{SampleClock, Stamps},
};

/// Periods without a frame after which the part is restarted.
const SILENT_PERIODS: u32 = 10;

/// Natural logarithm of the odds against chance at which a part that repeats the codes of all axes of all sensors is
/// not believed; the odds follow from its sensors' usual steps. A sound part so loses at most one reading in 1,000
/// (gyro and accelerometer) or in 50 (magnetometer, whose readings are fewer words and matter less), whatever its
/// noise, and hardly any in motion.
const REPEATED_INERTIAL: f32 = 6.9;
const REPEATED_MAGNETIC: f32 = 3.9;

/// Innovations that are always believed, see [`sure_steps`].
const SURE_FORCE_M_S2: f32 = 2.5;
const SURE_FIELD_UT: f32 = 5.0;

/// Supervision of a part, without its registers: everything of a [`Supervised`](super::blocking::Supervised)
/// source that needs no bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Supervision<const V: usize> {
    pub data: PartData<V>,
    pub counters: Counters,
    pub recovery: Recovery,
    clock: SampleClock,
    mounting: Mounting,
    frozen: [Frozen; V],
    innovation: [Innovation; V],
    was_frozen: bool,
    settling: u16,
    started_us: Option<u64>,
    last_t_us: Option<u64>,
}

impl<const V: usize> Supervision<V> {
    pub fn new(data: PartData<V>, mounting: Mounting) -> Self {
        Self {
            data,
            counters: Counters::default(),
            recovery: Recovery::NEW,
            clock: SampleClock::new(data.period_us, data.period_tolerance),
            mounting,
            frozen: [Frozen::default(); V],
            innovation: [Innovation::NEW; V],
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
        self.innovation = [Innovation::NEW; V];
        self.clock.resynchronise();
        self.recovery.started(now_us);
    }

    pub fn bus_failed(&mut self, now_us: u64) {
        add(&mut self.counters.bus_errors, 1);
        self.clock.interrupt();
        self.recovery.bus_failed(now_us);
    }

    /// Records that the part has lost its settings, and with them the frames of this burst.
    pub fn was_reset(&mut self) {
        add(&mut self.counters.resets, 1);
        self.clock.resynchronise();
        self.recovery.restart();
    }

    /// Returns true if the part has been silent for so long that it must restart.
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

    /// Returns true if a frame should have come by now.
    pub fn is_overdue(&self, now_us: u64) -> bool {
        self.last_t_us.is_none() || self.clock.periods_since(now_us) > 1
    }

    /// Hands each believable frame of a burst to `out`, oldest first.
    pub fn take(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        burst: &Burst<V>,
        mut out: impl FnMut(Scaled<V>),
    ) -> Condition {
        if burst.overrun {
            add(&mut self.counters.overruns, 1);
            self.clock.interrupt();
        }
        add(&mut self.counters.corrupt_frames, burst.corrupt.into());
        if burst.corrupt > 0 {
            self.clock.interrupt();
        }
        let frames = burst.frames();
        if frames.is_empty() {
            self.clock.had_none(now_us);
        } else if !self.is_early(now_us, frames) {
            let stamps = self.clock.stamp(now_us, trigger, frames.len(), burst.left);
            add(&mut self.counters.lost_frames, stamps.lost);
            self.innovation.iter_mut().for_each(|innovation| innovation.skip(stamps.lost));
            for (k, frame) in frames.iter().enumerate() {
                if let Some(scaled) = self.believed(k, frame, &stamps) {
                    add(&mut self.counters.readings, 1);
                    out(scaled);
                }
            }
        }
        let silent = self.innovation.iter().any(Innovation::is_silent);
        let well = !self.was_frozen && !silent;
        self.recovery.was_read(now_us, well);
        if well {
            return Condition::Running;
        }
        // The newest frame tells: in a backlog the BMI088 has no codes of its accelerometer for the older ones.
        if (self.was_frozen || burst.left == 0) && self.recovery.restart_later(now_us) && silent {
            add(&mut self.counters.silences, 1);
        }
        Condition::Frozen
    }

    /// Returns true if a part without a FIFO shows a reading again, or one that it cannot have measured yet.
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

    /// Stamps and scales frame `k` of a burst; `None` while the part settles, or if the time is not after the last
    /// one's.
    fn believed(&mut self, k: usize, frame: &Frame<V>, stamps: &Stamps) -> Option<Scaled<V>> {
        let t_us = stamps.t_us(k)?;
        if self.last_t_us.is_some_and(|last| t_us <= last) {
            add(&mut self.counters.early_frames, 1);
            return None;
        }
        self.last_t_us = Some(t_us);
        if self.settling > 0 {
            self.settling -= 1;
            // The dropped frames still teach the usual innovations.
            self.doubts(frame);
            return None;
        }
        Some(self.scaled(t_us, frame))
    }

    /// Marks the sensors whose codes are not to be believed.
    fn doubts(&mut self, frame: &Frame<V>) -> [bool; V] {
        let mut doubts = [false; V];
        let sure = sure_steps::<V>(self.data.period_us);
        let sensors = self.data.sensors.iter().zip(sure).zip(&mut self.innovation).zip(frame.codes);
        let repeats = if V == 1 { REPEATED_MAGNETIC } else { REPEATED_INERTIAL };
        for (doubt, (((sensor, sure), innovation), codes)) in doubts.iter_mut().zip(sensors) {
            match codes {
                Some(codes) => *doubt = !innovation.believes(codes, sure / sensor.per_code, sensor.clip_code, repeats),
                None => innovation.misses(),
            }
        }
        let all = self.innovation.iter().map(Innovation::repeated);
        if all.clone().all(|repeated| repeated > 0.0) && all.sum::<f32>() > repeats {
            doubts = [true; V];
        }
        doubts
    }

    fn scaled(&mut self, t_us: u64, frame: &Frame<V>) -> Scaled<V> {
        let mut scaled = Scaled { t_us, vectors: [None; V], clipped: [false; V], temperature_c: None };
        let mut any_frozen = false;
        let doubts = self.doubts(frame);
        let sensors = self.data.sensors.iter().zip(&mut self.frozen).zip(frame.codes.into_iter().zip(doubts));
        for (place, ((vector, clipped), ((sensor, frozen), (codes, doubt)))) in
            scaled.vectors.iter_mut().zip(&mut scaled.clipped).zip(sensors).enumerate()
        {
            let Some(codes) = codes else { continue };
            if frozen.sees(codes, sensor.clip_code, self.data.frozen_frames) {
                any_frozen = true;
                continue;
            }
            *clipped = codes.iter().any(|code| code.abs() >= sensor.clip_code);
            // A blow on the accelerometer jumps to the end of the range. As clipped the reading is as little used as a
            // missing one, but the blow is counted, and nothing is put in its place.
            if doubt && !(*clipped && place == ACCELEROMETER) {
                *clipped = false;
                add(&mut self.counters.implausible, 1);
                continue;
            }
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

/// Place of the accelerometer, behind the gyro.
const ACCELEROMETER: usize = 1;

/// Innovations always believed in one frame, SI, whether motion or a flipped bit caused them. Gyro: a turn of the
/// attitude by 0.1 deg within a period, on all three axes together. Accelerometer and magnetometer: an innovation
/// that the attitude filter takes for noise, or for a disturbance, of one frame.
fn sure_steps<const V: usize>(period_us: u32) -> [f32; V] {
    let gyro_rad_s = 0.1_f32.to_radians() / libm::sqrtf(3.0) * 1e6 / period_us as f32;
    let mut steps = [SURE_FIELD_UT; V];
    if let [gyro, accel] = steps.as_mut_slice() {
        (*gyro, *accel) = (gyro_rad_s, SURE_FORCE_M_S2);
    }
    steps
}

/// Adds to a counter, which stops at its largest value.
pub(super) fn add(counter: &mut u32, number: u32) {
    *counter = counter.saturating_add(number);
}
