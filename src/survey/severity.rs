//! Severity of vibration and of stick-slip in eight levels, whether the tool whirls, and the dose of a run.
//!
//! Levels count from 0 to 7, as those of many makers do. The bounds of vibration are this library's own choice: makers'
//! tables differ, and none that is published was at hand to be checked against. [`level`] takes the bounds of your
//! tool's manual. Vibration above half of the probe's sample rate, or beyond its accelerometer's range, is in none of
//! these figures.

use super::{DrillingDynamics, Rotation, WhirlKind};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Root mean square of vibration, along the axis or across it, from which each level above 0 applies, g.
pub const VIBRATION_BOUNDS_G: [f32; 7] = [0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 15.0];
/// Stick-slip index from which each level above 0 applies; level 7 is a string that turned backwards. The index is half
/// of (largest - least) / mean, whose published bounds are 0.4 to 2.4 in steps of 0.4: slight, moderate, moderately
/// severe, severe, very severe, extreme (`dataanalysis.oilFunc.StickSlip`, an open program for drilling data on
/// GitHub).
pub const STICK_SLIP_BOUNDS: [f32; 6] = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2];
/// Speed from which a string turned backwards, revolutions per minute: half of that at which a tool counts as rotating.
const BACKWARDS_RPM: f32 = 2.5;
/// Circularity from which vibration counts as whirl: three quarters of its power turn one way.
const CIRCULAR: f32 = 0.5;
/// Number of levels.
pub const LEVELS: usize = 8;

/// Level of a value by any table: the number of bounds that it reaches.
#[must_use]
pub fn level(value: f32, bounds: &[f32]) -> u8 {
    bounds.iter().filter(|bound| value >= **bound).count() as u8
}

/// Level of a root mean square of vibration, m/s^2: 0 to 7 by [`VIBRATION_BOUNDS_G`].
#[must_use]
pub fn of_vibration(rms_m_s2: f32) -> u8 {
    level(rms_m_s2 / STANDARD_GRAVITY_M_S2, &VIBRATION_BOUNDS_G)
}

impl DrillingDynamics {
    /// Severity of vibration along the tool axis, 0 to 7.
    #[must_use]
    pub fn axial_severity(&self) -> Option<u8> {
        self.axial_rms_m_s2.map(of_vibration)
    }

    /// Severity of vibration across the tool axis, 0 to 7.
    #[must_use]
    pub fn lateral_severity(&self) -> Option<u8> {
        self.lateral_rms_m_s2.map(of_vibration)
    }

    /// Kind of whirl in this interval. `None`: lateral vibration is under level 1, the tool does not rotate, or less
    /// than three quarters of the vibration's power turn one way.
    #[must_use]
    pub fn whirl_kind(&self) -> Option<WhirlKind> {
        let Rotation { mean_rpm, stick_slip_index: Some(_), .. } = self.rotation? else { return None };
        let whirl = self.whirl?;
        if self.lateral_severity()? == 0 || whirl.circularity.abs() < CIRCULAR {
            return None;
        }
        // Whirl's speed over the string's, and circularity with the string's sign: above 0 where both turn one way.
        let (around, circularity) = (whirl.rpm / mean_rpm, whirl.circularity * mean_rpm);
        if around <= -0.5 {
            Some(WhirlKind::Backward)
        } else if around > 1.0 && circularity > 0.0 {
            Some(WhirlKind::Forward)
        } else {
            None
        }
    }
}

impl Rotation {
    /// Severity of stick-slip, 0 to 7; `None` if the tool does not rotate.
    #[must_use]
    pub fn stick_slip_severity(&self) -> Option<u8> {
        let index = self.stick_slip_index?;
        let slowest = if self.mean_rpm < 0.0 { -self.max_rpm } else { self.min_rpm };
        let backwards = slowest <= -BACKWARDS_RPM;
        Some(if backwards { 7 } else { level(index, &STICK_SLIP_BOUNDS) })
    }
}

/// Dose of vibration that a tool has taken: time at each level, and shocks. Limits of components are hours at a level.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VibrationDose {
    /// Time at each level of axial vibration, seconds.
    pub axial_s: [f32; LEVELS],
    /// Time at each level of lateral vibration, seconds.
    pub lateral_s: [f32; LEVELS],
    /// Time at each level of stick-slip, seconds.
    pub stick_slip_s: [f32; LEVELS],
    /// Number of shocks.
    pub shocks: u32,
    /// Number of shocks over each of the higher levels, see [`DrillingDynamics::shocks_over`].
    pub shocks_over: [u32; 3],
}

impl VibrationDose {
    /// No dose.
    pub const NONE: Self = Self {
        axial_s: [0.0; LEVELS],
        lateral_s: [0.0; LEVELS],
        stick_slip_s: [0.0; LEVELS],
        shocks: 0,
        shocks_over: [0; 3],
    };

    /// Adds a window.
    pub fn add(&mut self, window: &DrillingDynamics) {
        let time_s = window.t_end_us.saturating_sub(window.t_start_us) as f32 * 1e-6;
        let stick_slip = window.rotation.as_ref().and_then(Rotation::stick_slip_severity);
        let levels = [window.axial_severity(), window.lateral_severity(), stick_slip];
        for (times, level) in [&mut self.axial_s, &mut self.lateral_s, &mut self.stick_slip_s].into_iter().zip(levels) {
            if let Some(time) = level.and_then(|level| times.get_mut(usize::from(level))) {
                *time += time_s;
            }
        }
        self.shocks = self.shocks.saturating_add(window.shocks);
        for (sum, count) in self.shocks_over.iter_mut().zip(window.shocks_over) {
            *sum = sum.saturating_add(count);
        }
    }
}

#[cfg(test)]
mod tests;
