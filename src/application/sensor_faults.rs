//! Faults of the sensors over a second, for a self-test.

use crate::{attitude::AttitudeFlags, telemetry::SelfTest};

/// A second: some readings of the slowest magnetometer.
const SECOND_US: u32 = 1_000_000;

/// One sample in so many may have a fault. A wide margin: of a sound gyro or accelerometer the supervision does not
/// believe one reading in 1,000.
const ONE_FAULTY_IN: u32 = 20;

/// Faults that count in some of the samples. A magnetometer slower than the samples is in some of them alone: it is at
/// fault if it is in none.
const NOW_AND_THEN: AttitudeFlags = SelfTest::FAULTS.difference(AttitudeFlags::MAG_UNUSED);

/// Faults of the last whole second, and those of the one that goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct SensorFaults {
    /// `None` in the first second.
    found: Option<AttitudeFlags>,
    /// Low half of the time.
    from_us: u32,
    samples: u32,
    faulty: u32,
    in_any: AttitudeFlags,
    /// Flags that some sample has not.
    not_in_all: AttitudeFlags,
}

impl SensorFaults {
    pub const fn new() -> Self {
        let none = AttitudeFlags::empty();
        Self { found: None, from_us: 0, samples: 0, faulty: 0, in_any: none, not_in_all: none }
    }

    /// Counts a sample of time `t_us`.
    pub fn update(&mut self, t_us: u64, flags: AttitudeFlags) {
        // A clock that went back begins anew, too.
        let t_us = t_us as u32;
        if t_us.wrapping_sub(self.from_us) >= SECOND_US || self.samples == 0 {
            let found = (self.samples > 0).then(|| self.found_so_far());
            *self = Self { found, from_us: t_us, ..Self::new() };
        }
        self.samples += 1;
        self.faulty += u32::from(flags.intersects(NOW_AND_THEN));
        self.in_any |= flags;
        self.not_in_all |= !flags;
    }

    /// Faults of the last whole second, or of the first so far.
    pub fn found(&self) -> AttitudeFlags {
        self.found.unwrap_or_else(|| self.found_so_far())
    }

    fn found_so_far(&self) -> AttitudeFlags {
        let now_and_then = if self.faulty > self.samples / ONE_FAULTY_IN {
            self.in_any & NOW_AND_THEN
        } else {
            AttitudeFlags::empty()
        };
        (now_and_then | !self.not_in_all) & SelfTest::FAULTS
    }
}
