//! Health of the probe: counters, stack, delays, and the findings of a self-test.

use super::{Payload, ProbeId};
use crate::{
    attitude::AttitudeFlags,
    probe::Counters,
    sample::TurnFlags,
    sensors::MountingCheck,
    telemetry::{Kind, LineCounters, LinkCounters},
};
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// Health of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Unique number of the probe: its owner's commands name it.
    pub probe: ProbeId,
    /// Time of the report, microseconds.
    pub t_us: u64,
    /// The pipeline's counters.
    pub counters: Counters,
    /// Samples that were read.
    pub samples_acquired: u32,
    /// Samples that found the queue to the main loop full.
    pub sample_overruns: u32,
    /// Ticks of the sample clock at which nothing was read, because the reading before had not ended.
    pub missed_ticks: u32,
    /// Readings of the sensors that failed; their drivers start them anew.
    pub sensor_faults: u32,
    /// Longest time from the acquisition of a sample to its attitude, microseconds.
    pub worst_delay_us: u32,
    /// Attitudes that came later than 2 ms after the acquisition.
    pub late_attitudes: u32,
    /// Most stack in use at any time, bytes.
    pub stack_used_bytes: u32,
    /// Size of the stack, bytes.
    pub stack_size_bytes: u32,
    /// Resets by the watchdog since power came.
    pub watchdog_resets: u32,
    /// Instant from which the present gyro model flies, microseconds; `None`: since the start.
    pub model_since_us: Option<u64>,
    /// Results that newer ones replaced before the line had room.
    pub results_lost: u32,
    /// Counters of the sent frames.
    pub sent: LineCounters,
    /// Counters of the received frames.
    pub received: LinkCounters,
    /// Commands carried out.
    pub commands_accepted: u32,
    /// Commands refused.
    pub commands_refused: u32,
    /// Models stored since the start.
    pub models_stored: u32,
    /// Models and command counters that the storage refused, and writes and erasures that failed.
    pub storage_failures: u32,
    /// Findings of the self-test that asked for this report; `None` without one.
    pub self_test: Option<SelfTest>,
}

/// Findings of a self-test: the sensors as they read at rest, the turns of the last minutes, and the storage read anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct SelfTest {
    /// Faults of the last whole second: a sensor that is missing, clipped, frozen or not used, or a driver's fault, in
    /// more than a twentieth of the samples; of the magnetometer, which may be slower, in all of them.
    pub sensors: AttitudeFlags,
    /// True if the flash still holds all that was stored; `None` without a usable storage.
    pub storage_holds: Option<bool>,
    /// Norm of the specific force, mm/s^2; `None` without an accelerometer.
    pub gravity_mm_s2: Option<u32>,
    /// Norm of the field, nT; `None` without a magnetometer.
    pub field_nt: Option<u32>,
    /// Turns about the axes of the probe that have been seen well enough to judge.
    pub turns_seen: TurnFlags,
    /// Seen turns on which the sensors do not agree: a wrong sign, unit or axis.
    pub turns_wrong: TurnFlags,
}

impl SelfTest {
    /// Flags of an attitude that are a sensor's fault.
    pub const FAULTS: AttitudeFlags = AttitudeFlags::GYRO_HELD
        .union(AttitudeFlags::GYRO_CLIPPED)
        .union(AttitudeFlags::ACCEL_UNUSED)
        .union(AttitudeFlags::MAG_UNUSED)
        .union(AttitudeFlags::FAULT)
        .union(AttitudeFlags::FROZEN_SENSOR);

    /// Gravity that there is on earth, mm/s^2, and 5 % either way for an accelerometer within its data sheet.
    const GRAVITY_MM_S2: RangeInclusive<u32> = 9_290..=10_320;
    /// Fields that there are on earth, nT: 22,000 to 67,000, and some either way.
    const FIELD_NT: RangeInclusive<u32> = 20_000..=70_000;

    /// Findings of the sensors as they read, and of their mounting.
    #[must_use]
    pub fn of(sensors: AttitudeFlags, mounting: &MountingCheck, storage_holds: Option<bool>) -> Self {
        // Rounded; a number that is out of range is its end.
        let thousandths = |norm: Option<f32>| norm.map(|norm| libm::roundf(norm * 1e3) as u32);
        let [gravity, field] = mounting.norms();
        Self {
            sensors,
            storage_holds,
            gravity_mm_s2: thousandths(gravity),
            field_nt: thousandths(field),
            turns_seen: mounting.seen(),
            turns_wrong: mounting.wrong(),
        }
    }

    /// Returns true if gravity is that of the earth, in the unit that it should have.
    #[must_use]
    pub fn gravity_is_plausible(&self) -> bool {
        self.gravity_mm_s2.is_some_and(|gravity| Self::GRAVITY_MM_S2.contains(&gravity))
    }

    /// Returns true if the field is one that there is on earth, in the unit that it should have.
    #[must_use]
    pub fn field_is_plausible(&self) -> bool {
        self.field_nt.is_some_and(|field| Self::FIELD_NT.contains(&field))
    }

    /// Returns true if nothing is wrong. Turns that were not seen are not judged: see [`Self::turns_seen`].
    #[must_use]
    pub fn is_passed(&self) -> bool {
        let sensors_well = self.sensors.is_empty() && self.gravity_is_plausible() && self.field_is_plausible();
        sensors_well && self.turns_wrong.is_empty() && self.storage_holds == Some(true)
    }
}

impl Payload for Health {
    const KIND: Kind = Kind::Health;
}
