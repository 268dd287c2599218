//! Drilling dynamics: vibration, shocks and stick-slip over an interval, 30 s by default.

use super::{
    SurveyInput,
    stationary::OLDEST_EVIDENCE_US,
    whirl::{Whirl, WhirlSums},
};
use crate::{
    attitude::Attitude,
    config::{DynamicsConfig, Earth},
    rotation::rotate_back,
};
use core::f32::consts::TAU;
use nalgebra::{Quaternion, Vector3};

/// Ratios to [`DynamicsConfig::shock_m_s2`] of the higher levels of shocks: 25, 50 and 100 g by default.
pub const SHOCK_LEVELS: [f32; 3] = [2.5, 5.0, 10.0];

/// Vibration, shocks and rotation of one interval. [`severity`](super::severity) grades them in levels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrillingDynamics {
    /// First sample of the interval, microseconds; pauses of over a second put it off by as much, so that the interval
    /// lasts as long as was measured.
    pub t_start_us: u64,
    /// Last sample of the interval, microseconds.
    pub t_end_us: u64,
    /// Root mean square of vibration along the tool axis, m/s^2. Vibration is specific force less gravity by
    /// the attitude. `None`: no reading with an attitude.
    pub axial_rms_m_s2: Option<f32>,
    /// Root mean square of vibration across the tool axis, m/s^2.
    pub lateral_rms_m_s2: Option<f32>,
    /// Largest vibration, m/s^2; a lower bound if `clipped` is not 0.
    pub peak_m_s2: Option<f32>,
    /// Number of shocks: vibration beyond the configured level, or a clipped accelerometer, counted once until
    /// vibration has been quiet for the configured pause.
    pub shocks: u32,
    /// Number of samples with a clipped accelerometer.
    pub clipped: u32,
    /// Rotation; `None` with fewer than two averages of the rate.
    pub rotation: Option<Rotation>,
    /// Largest vibration along the tool axis, m/s^2; a lower bound if `clipped` is not 0.
    pub axial_peak_m_s2: Option<f32>,
    /// Largest vibration across the tool axis, m/s^2; a lower bound if `clipped` is not 0.
    pub lateral_peak_m_s2: Option<f32>,
    /// Number of the shocks that reached each of [`SHOCK_LEVELS`]. A shock beyond the accelerometer's range counts only
    /// at the levels within that range.
    pub shocks_over: [u32; 3],
    /// Turning of lateral vibration; `None` without readings.
    pub whirl: Option<Whirl>,
}

/// Rotation about the tool axis over an interval, positive clockwise looking down-hole.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rotation {
    /// Least speed, revolutions per minute.
    pub min_rpm: f32,
    /// Mean speed, revolutions per minute.
    pub mean_rpm: f32,
    /// Largest speed, revolutions per minute.
    pub max_rpm: f32,
    /// Stick-slip index (largest - least) / (2 mean): 0 is steady, 1 sticks fully with a symmetric swing.
    /// `None` if the mean is below the speed at which the tool counts as rotating.
    pub stick_slip_index: Option<f32>,
}

/// Sums of the interval in progress; intervals do not overlap.
pub(crate) struct DynamicsInterval {
    start_us: Option<u64>,
    last_us: u64,
    readings: u32,
    axial_square: f32,
    lateral_square: f32,
    peak_square: f32,
    axial_peak_square: f32,
    lateral_peak_square: f32,
    shocks: u32,
    shocks_over: [u32; 3],
    clipped: u32,
    /// Time since vibration fell below half the level; `None` outside a shock.
    shock_quiet_s: Option<f32>,
    /// Number of [`SHOCK_LEVELS`] that this shock has reached.
    shock_reached: u8,
    rates: RateSpread,
    whirl: WhirlSums,
}

impl DynamicsInterval {
    pub(crate) const fn new() -> Self {
        Self {
            start_us: None,
            last_us: 0,
            readings: 0,
            axial_square: 0.0,
            lateral_square: 0.0,
            peak_square: 0.0,
            axial_peak_square: 0.0,
            lateral_peak_square: 0.0,
            shocks: 0,
            shocks_over: [0; 3],
            clipped: 0,
            shock_quiet_s: None,
            shock_reached: 0,
            rates: RateSpread::new(),
            whirl: WhirlSums::new(),
        }
    }

    /// Takes a sample. Returns the interval that it completes.
    pub(crate) fn push(
        &mut self,
        input: &SurveyInput,
        earth: &Earth,
        config: &DynamicsConfig,
        rotating_rad_s: f32,
    ) -> Option<DrillingDynamics> {
        let mut start_us = *self.start_us.get_or_insert(input.t_us);
        let mut step_us = if self.last_us == 0 { 0 } else { input.t_us.saturating_sub(self.last_us) };
        self.last_us = input.t_us;
        if step_us > OLDEST_EVIDENCE_US {
            // Nothing was measured in this pause.
            start_us = start_us.saturating_add(step_us);
            (self.start_us, step_us) = (Some(start_us), 0);
        }
        let step_s = step_us as f32 * 1e-6;
        self.shake(input, earth, config, step_s);
        if let Some([.., rate]) = input.rate_rad_s {
            self.rates.add(rate, step_s, config.rate_averaging_s);
        }
        if (input.t_us.saturating_sub(start_us) as f32) * 1e-6 < config.window_s {
            return None;
        }
        let part = |square: f32| (self.readings > 0).then(|| libm::sqrtf(square / self.readings as f32));
        let peak = |square: f32| (self.readings > 0).then(|| libm::sqrtf(square));
        let interval = DrillingDynamics {
            t_start_us: start_us,
            t_end_us: input.t_us,
            axial_rms_m_s2: part(self.axial_square),
            lateral_rms_m_s2: part(self.lateral_square),
            peak_m_s2: peak(self.peak_square),
            shocks: self.shocks,
            clipped: self.clipped,
            rotation: self.rates.rotation(rotating_rad_s),
            axial_peak_m_s2: peak(self.axial_peak_square),
            lateral_peak_m_s2: peak(self.lateral_peak_square),
            shocks_over: self.shocks_over,
            whirl: self.whirl.whirl(),
        };
        *self = Self {
            last_us: self.last_us,
            shock_quiet_s: self.shock_quiet_s,
            shock_reached: self.shock_reached,
            whirl: self.whirl.next(),
            ..Self::new()
        };
        Some(interval)
    }

    fn shake(&mut self, input: &SurveyInput, earth: &Earth, config: &DynamicsConfig, step_s: f32) {
        let vibration = match (input.force_m_s2, &input.attitude) {
            (Some(force), Some(attitude)) => Some(Vector3::from(force) + gravity_in_tool(attitude, earth)),
            _ => None,
        };
        let square = vibration.map_or(0.0, |v| v.norm_squared());
        if let Some(v) = vibration {
            self.readings = self.readings.saturating_add(1);
            let (axial, lateral) = (v.z * v.z, v.x * v.x + v.y * v.y);
            self.axial_square += axial;
            self.lateral_square += lateral;
            let peaks = [&mut self.peak_square, &mut self.axial_peak_square, &mut self.lateral_peak_square];
            for (peak, square) in peaks.into_iter().zip([square, axial, lateral]) {
                if square > *peak {
                    *peak = square;
                }
            }
        }
        self.whirl.add(vibration.map(|v| [v.x, v.y]), input.rate_rad_s.map(|[.., rate]| rate), step_s);
        if input.accel_clipped {
            self.clipped = self.clipped.saturating_add(1);
        }
        let level = config.shock_m_s2 * config.shock_m_s2;
        let hit = input.accel_clipped || square >= level;
        self.shock_quiet_s = match self.shock_quiet_s {
            None if hit => {
                self.shocks = self.shocks.saturating_add(1);
                self.shock_reached = 0;
                Some(0.0)
            }
            None => None,
            Some(_) if hit || square >= 0.25 * level => Some(0.0),
            Some(quiet_s) => (quiet_s + step_s < config.shock_pause_s).then_some(quiet_s + step_s),
        };
        // With gravity in it, which is no matter at the end of a range.
        let square = if input.accel_clipped { Vector3::from(input.raw_accel_m_s2).norm_squared() } else { square };
        for (ratio, count) in SHOCK_LEVELS.iter().zip(&mut self.shocks_over).skip(self.shock_reached.into()) {
            if hit && square >= level * ratio * ratio {
                *count = count.saturating_add(1);
                self.shock_reached += 1;
            }
        }
    }
}

/// Gravity in tool axes, m/s^2, positive down.
fn gravity_in_tool(attitude: &Attitude, earth: &Earth) -> Vector3<f32> {
    let [w, x, y, z] = attitude.q;
    rotate_back(&Quaternion::new(w, x, y, z), &Vector3::new(0.0, 0.0, earth.gravity_m_s2))
}

/// Least, mean and largest of short averages of the axial rate.
struct RateSpread {
    angle_rad: f32,
    time_s: f32,
    least_rad_s: f32,
    largest_rad_s: f32,
    sum_rad_s: f32,
    count: u32,
}

impl RateSpread {
    const fn new() -> Self {
        Self { angle_rad: 0.0, time_s: 0.0, least_rad_s: 0.0, largest_rad_s: 0.0, sum_rad_s: 0.0, count: 0 }
    }

    fn add(&mut self, rate_rad_s: f32, step_s: f32, averaging_s: f32) {
        if step_s > averaging_s {
            // Rates on the two sides of a gap are not averaged.
            (self.angle_rad, self.time_s) = (0.0, 0.0);
            return;
        }
        self.angle_rad += rate_rad_s * step_s;
        self.time_s += step_s;
        if self.time_s + 0.5 * step_s < averaging_s {
            return;
        }
        let mean = self.angle_rad / self.time_s;
        if self.count == 0 || mean < self.least_rad_s {
            self.least_rad_s = mean;
        }
        if self.count == 0 || mean > self.largest_rad_s {
            self.largest_rad_s = mean;
        }
        self.sum_rad_s += mean;
        self.count = self.count.saturating_add(1);
        (self.angle_rad, self.time_s) = (0.0, 0.0);
    }

    fn rotation(&self, rotating_rad_s: f32) -> Option<Rotation> {
        if self.count < 2 {
            return None;
        }
        let mean = self.sum_rad_s / self.count as f32;
        let index = (self.largest_rad_s - self.least_rad_s) / (2.0 * mean.abs());
        let rpm = 60.0 / TAU;
        Some(Rotation {
            min_rpm: self.least_rad_s * rpm,
            mean_rpm: mean * rpm,
            max_rpm: self.largest_rad_s * rpm,
            stick_slip_index: (mean.abs() >= rotating_rad_s).then_some(index),
        })
    }
}

#[cfg(test)]
mod tests;
