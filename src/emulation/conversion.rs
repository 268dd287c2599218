//! Conversion times of a part, and the truth at these times as words of the part.

use crate::sample::Sample;

/// Times at which a part converts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Conversions {
    /// At the output data rate that its registers ask for, from the instant it was switched on. The truth between two
    /// samples is on the straight line between them.
    #[default]
    AtItsRate,
    /// Once with every sample that is played, whatever the rate in the registers; powered down, never. A recording was
    /// sampled by a part already, so that its samples pass unchanged.
    WithEverySample,
}

/// The truth that has been played so far.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(super) struct Played {
    before: Option<Sample>,
    now: Option<Sample>,
}

impl Played {
    pub const fn nothing() -> Self {
        Self { before: None, now: None }
    }

    pub fn take(&mut self, sample: &Sample) {
        self.before = self.now;
        self.now = Some(*sample);
    }

    /// The time up to which the truth is known; nothing converts after it.
    pub fn known_until_ns(&self) -> u64 {
        self.now.map_or(0, |sample| nanoseconds(sample.t_us))
    }

    /// Returns the truth at an instant between the last two samples; outside, the nearer of the two.
    pub fn at(&self, t_ns: u64) -> Option<Sample> {
        let now = self.now?;
        let Some(before) = self.before else { return Some(now) };
        let (from, to) = (nanoseconds(before.t_us), nanoseconds(now.t_us));
        if t_ns >= to || to <= from {
            return Some(now);
        }
        // Within a step of the recording: exact enough in f32, and the same on every machine.
        let part = t_ns.saturating_sub(from) as f32 / (to - from) as f32;
        let line = |a: f32, b: f32| a + part * (b - a);
        let lines = |a: [f32; 3], b: [f32; 3]| {
            let ([ax, ay, az], [bx, by, bz]) = (a, b);
            [line(ax, bx), line(ay, by), line(az, bz)]
        };
        Some(Sample {
            t_us: t_ns / 1_000,
            gyro_rad_s: lines(before.gyro_rad_s, now.gyro_rad_s),
            accel_m_s2: lines(before.accel_m_s2, now.accel_m_s2),
            mag_ut: lines(before.mag_ut, now.mag_ut),
            temperature_c: line(before.temperature_c, now.temperature_c),
            flags: before.flags | now.flags,
        })
    }
}

/// Conversion times of one sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Ticks {
    next_ns: Option<u64>,
}

impl Ticks {
    pub const fn stopped() -> Self {
        Self { next_ns: None }
    }

    /// Sets a rate that was written: the first conversion is one period after `now_ns`. `None` is power-down.
    pub fn set(&mut self, period_ns: Option<u64>, now_ns: u64) {
        self.next_ns = period_ns.map(|period| now_ns.saturating_add(period));
    }

    /// Returns the next conversion if it is not after `until_ns`.
    pub fn next_until(&self, until_ns: u64) -> Option<u64> {
        self.next_ns.filter(|next| *next <= until_ns)
    }

    pub fn done(&mut self, period_ns: u64) {
        self.next_ns = self.next_ns.map(|next| next.saturating_add(period_ns));
    }
}

pub(super) const fn nanoseconds(t_us: u64) -> u64 {
    t_us.saturating_mul(1_000)
}

/// Quantises a value to a two's complement code: value over unit, rounded to nearest, halves away from zero, held at
/// `limits`; a value that is no number becomes 0.
pub(super) fn quantised(value: f32, unit: f32, limits: (i32, i32)) -> i32 {
    let counts = libm::roundf(value / unit);
    // `as` saturates and makes 0 of NaN; both limits are exact in f32 (at most 24 bits).
    (counts as i32).min(limits.1).max(limits.0)
}

#[cfg(test)]
mod tests;
