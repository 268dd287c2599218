//! Reference of the earth's field, norm and dip, as it is learnt; a passing disturbance does not enter it.

use crate::{
    change::TURNING_RAD_S,
    config::{AttitudeConfig, Earth},
    rotation::sine_and_cosine,
};

// Times without a source of their own are VQF's defaults (Laidig and Seel, Information Fusion 91, 2023).

/// Averaging time of the reference, seconds: longer than a passing disturbance.
const REFERENCE_TIME_S: f32 = 20.0;
/// Smoothing of norm and dip before the comparison, seconds: longer than the sensor's noise, shorter than a
/// turn.
const SMOOTHING_S: f32 = 0.05;
/// Time of agreement required before the field is used again, seconds: a field that turns inside a disturbance passes
/// through the undisturbed values for moments.
const QUIET_S: f32 = 0.5;
/// Time for which a new reference must be steady while the probe turns, seconds. A disturbance fixed to the probe does
/// not keep norm and dip while the probe turns.
const NEW_FIELD_S: f32 = 20.0;
/// Time constant of a new reference's mean, seconds: after [`NEW_FIELD_S`] the first reading has 2 % of the weight.
const CANDIDATE_TIME_S: f32 = 0.25 * NEW_FIELD_S;
/// Weight of steady time while the probe stands still, where it proves little: a magnet may lie near for a minute, so
/// two minutes are required.
const STILL_WEIGHT: f32 = NEW_FIELD_S / 120.0;
/// Gate of the dip against the tilt's uncertainty, in deviations: exceeded by chance once in 400.
const TILT_GATE: f32 = 3.0;

/// Reference of the undisturbed magnetic field: total field and dip, the two numbers that do not depend on
/// heading.
#[derive(Clone, Copy)]
pub(crate) struct FieldReference {
    /// Total field of the reference, microtesla, 0 while unknown; then its dip, radians.
    norm_ut: f32,
    dip_rad: f32,
    /// Averaging time of the reference so far, at most its time constant, seconds.
    age_s: f32,
    /// True if the configuration gave both total field and dip.
    configured: bool,
    smooth_norm_ut: f32,
    smooth_dip_rad: f32,
    quiet_s: f32,
    candidate_norm_ut: f32,
    candidate_dip_rad: f32,
    candidate_s: f32,
}

impl FieldReference {
    pub(crate) const fn new() -> Self {
        Self {
            norm_ut: 0.0,
            dip_rad: 0.0,
            age_s: 0.0,
            configured: false,
            smooth_norm_ut: 0.0,
            smooth_dip_rad: 0.0,
            quiet_s: 0.0,
            candidate_norm_ut: 0.0,
            candidate_dip_rad: 0.0,
            candidate_s: 0.0,
        }
    }

    /// Starts from the configured field if both of its numbers are known; otherwise the first field read
    /// becomes the reference.
    pub(crate) fn start(earth: &Earth) -> Self {
        let mut reference = Self::new();
        if let (Some(norm_ut), Some(dip_rad)) = (earth.magnetic_field_ut, earth.dip_rad) {
            reference.norm_ut = norm_ut;
            reference.dip_rad = dip_rad;
            reference.age_s = REFERENCE_TIME_S;
            reference.configured = true;
            reference.quiet_s = QUIET_S;
        }
        reference
    }

    /// Returns the reference's total field, microtesla, and the sine and cosine of its dip.
    pub(crate) fn dip(&self) -> (f32, f32, f32) {
        let (sine, cosine) = sine_and_cosine(self.dip_rad);
        (self.norm_ut, sine, cosine)
    }

    /// Restarts the reference's average, from fields that agree with the old reference; a configured reference stays.
    pub(crate) const fn relearn(&mut self) {
        if !self.configured {
            self.age_s = 0.0;
        }
    }

    /// Compares the field of the last `dt_s` seconds with the reference. `tilt_variance` (rad^2) is that of the tilt
    /// against which the dip is read; it excuses as much of the dip's difference. Returns the squared deviation
    /// relative to the total field if the field is undisturbed, `None` if it must not be used.
    ///
    /// The deviation is from a declared field: one that comes slowly, as beside casing, takes the reference along.
    pub(crate) fn compare(
        &mut self,
        [norm_ut, dip_rad]: [f32; 2],
        rate_rad_s: f32,
        dt_s: f32,
        tilt_variance: f32,
        (config, earth): (&AttitudeConfig, &Earth),
    ) -> Option<f32> {
        if self.norm_ut <= 0.0 {
            (self.norm_ut, self.dip_rad, self.quiet_s) = (norm_ut, dip_rad, QUIET_S);
        }
        if self.smooth_norm_ut <= 0.0 {
            (self.smooth_norm_ut, self.smooth_dip_rad) = (norm_ut, dip_rad);
        }
        let k = dt_s / (SMOOTHING_S + dt_s);
        self.smooth_norm_ut += k * (norm_ut - self.smooth_norm_ut);
        self.smooth_dip_rad += k * (dip_rad - self.smooth_dip_rad);
        let (smooth_norm_ut, smooth_dip_rad) = (self.smooth_norm_ut, self.smooth_dip_rad);
        let tolerance = config.mag_dip_tolerance_rad;
        let dip_tolerance_rad = libm::sqrtf(tolerance * tolerance + TILT_GATE * TILT_GATE * tilt_variance);
        let agrees = |norm_ut: f32, dip_rad: f32| {
            (smooth_norm_ut - norm_ut).abs() < config.mag_norm_tolerance * norm_ut
                && (smooth_dip_rad - dip_rad).abs() < dip_tolerance_rad
        };
        if agrees(self.norm_ut, self.dip_rad) {
            self.quiet_s += if self.quiet_s < QUIET_S { dt_s } else { 0.0 };
            self.candidate_s = 0.0;
            self.age_s += if self.age_s < REFERENCE_TIME_S { dt_s } else { 0.0 };
            let k = dt_s / self.age_s;
            self.norm_ut += k * (smooth_norm_ut - self.norm_ut);
            self.dip_rad += k * (smooth_dip_rad - self.dip_rad);
        } else {
            self.quiet_s = 0.0;
            if agrees(self.candidate_norm_ut, self.candidate_dip_rad) {
                self.candidate_s += if rate_rad_s > TURNING_RAD_S { dt_s } else { dt_s * STILL_WEIGHT };
                let k = dt_s / CANDIDATE_TIME_S;
                self.candidate_norm_ut += k * (smooth_norm_ut - self.candidate_norm_ut);
                self.candidate_dip_rad += k * (smooth_dip_rad - self.candidate_dip_rad);
            } else {
                (self.candidate_norm_ut, self.candidate_dip_rad) = (smooth_norm_ut, smooth_dip_rad);
                self.candidate_s = 0.0;
            }
            if self.candidate_s > NEW_FIELD_S {
                (self.norm_ut, self.dip_rad) = (self.candidate_norm_ut, self.candidate_dip_rad);
                (self.candidate_s, self.configured) = (0.0, false);
            }
        }
        if self.quiet_s < QUIET_S {
            return None;
        }
        let (norm_ut, dip_rad) = match (self.configured, earth.magnetic_field_ut, earth.dip_rad) {
            (true, Some(norm_ut), Some(dip_rad)) => (norm_ut, dip_rad),
            _ => (self.norm_ut, self.dip_rad),
        };
        let norm_part = (smooth_norm_ut - norm_ut) / norm_ut;
        let dip_part = smooth_dip_rad - dip_rad;
        let beyond_tilt = dip_part * dip_part - tilt_variance;
        Some(norm_part * norm_part + if beyond_tilt > 0.0 { beyond_tilt } else { 0.0 })
    }
}

#[cfg(test)]
mod tests;
