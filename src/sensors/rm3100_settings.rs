//! Settings of the RM3100: rate and cycle counts.

use super::{MagneticData, PartData, SensorData};

/// Rate of the RM3100 in continuous mode: its TMRC register (user manual 5.2.1, table 5-4). The rates of its own
/// oscillator have a standard deviation of 7 %. Slower rates are left out: the default is 37 Hz, and a reset to it
/// could not be told from a setting to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[repr(u8)]
pub enum Rm3100Rate {
    /// About 600 Hz.
    Hz600 = 0x92,
    /// About 300 Hz.
    Hz300 = 0x93,
    /// About 150 Hz.
    #[default]
    Hz150 = 0x94,
    /// About 75 Hz.
    Hz75 = 0x95,
}

/// Settings of an RM3100.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rm3100Settings {
    cycle_count: u16,
    rate: Rm3100Rate,
}

/// Cycle count outside the user manual's advice (5.1): under 30 the steps are coarser than the noise, over
/// 400 nothing is gained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct CycleCountError {
    /// Cycle count that was requested.
    pub cycle_count: u16,
}

impl core::fmt::Display for CycleCountError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "RM3100: a cycle count of {} is not within 30 to 400", self.cycle_count)
    }
}

impl core::error::Error for CycleCountError {}

impl Rm3100Settings {
    /// Creates settings with a cycle count, 30 to 400 oscillations of each axis's circuit, and a rate. More
    /// oscillations give a finer reading that takes longer: if three axes take longer than the rate allows, they set
    /// the rate.
    ///
    /// # Errors
    /// Rejects a cycle count out of range.
    pub const fn new(cycle_count: u16, rate: Rm3100Rate) -> Result<Self, CycleCountError> {
        if cycle_count < 30 || cycle_count > 400 {
            return Err(CycleCountError { cycle_count });
        }
        Ok(Self { cycle_count, rate })
    }

    /// Codes of one microtesla: 0.3671 times the cycle count plus 1.5, within 0.5 % of the user manual's 20, 38 and
    /// 75 codes at 50, 100 and 200 cycles (table 3-1).
    #[must_use]
    pub fn codes_per_ut(&self) -> f32 {
        0.3671 * f32::from(self.cycle_count) + 1.5
    }

    /// Conversion time of one axis, microseconds: a straight line through the greatest single-axis rates of table
    /// 3-1: 1600, 850 and 440 Hz at 50, 100 and 200 cycles.
    #[must_use]
    pub fn axis_us(&self) -> u32 {
        77 + 11 * u32::from(self.cycle_count)
    }

    /// Noise of a reading, microtesla rms: 0.03, 0.02 and 0.015 at 50, 100 and 200 cycles (table 3-1), falling with
    /// the square root of the cycle count.
    #[must_use]
    pub fn noise_ut(&self) -> f32 {
        0.015 * libm::sqrtf(200.0 / f32::from(self.cycle_count))
    }

    pub(super) const fn cycle_count(&self) -> u16 {
        self.cycle_count
    }

    pub(super) const fn rate(&self) -> Rm3100Rate {
        self.rate
    }

    pub(super) fn data(&self) -> MagneticData {
        const FULL_SCALE_UT: f32 = 800.0;
        let timer_us = match self.rate {
            Rm3100Rate::Hz600 => 1_667,
            Rm3100Rate::Hz300 => 3_333,
            Rm3100Rate::Hz150 => 6_667,
            Rm3100Rate::Hz75 => 13_333,
        };
        let axis_us = self.axis_us();
        let period_us = if 3 * axis_us > timer_us { 3 * axis_us } else { timer_us };
        // The part measures X, then Y, then Z, each as the mean over its conversion; all come out after the third.
        let axis_s = axis_us as f32 * 1e-6;
        PartData {
            name: "RM3100",
            source: "PNI RM3100 user manual 1017252, tables 3-1 and 5-4",
            sensors: [SensorData {
                full_scale: FULL_SCALE_UT,
                per_code: 1.0 / self.codes_per_ut(),
                clip_code: (FULL_SCALE_UT * self.codes_per_ut()) as i32,
                latency_s: [2.5 * axis_s, 1.5 * axis_s, 0.5 * axis_s],
                // Readings are independent: their noise spreads over half the output rate.
                noise_density: Some(self.noise_ut() * libm::sqrtf(2e-6 * period_us as f32)),
            }],
            temperature: None,
            period_us,
            period_tolerance: 0.25,
            fifo_frames: 1,
            watermark_frames: 1,
            settling_frames: 1,
            frozen_frames: 20,
        }
    }
}

impl Default for Rm3100Settings {
    /// Settings with the part's default cycle count, 200, at the highest rate that three axes allow: 146 Hz.
    fn default() -> Self {
        Self { cycle_count: 200, rate: Rm3100Rate::Hz150 }
    }
}
