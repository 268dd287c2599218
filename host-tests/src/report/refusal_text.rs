//! Reasons of refusal in words.

use meerkat_mwd::identification::{Decision, Refusal};

use super::turned_axes::{axes_text, by_any};

/// Outcome of a window in words.
#[must_use]
pub fn decision_text(decision: &Decision) -> String {
    match decision {
        Decision::Accepted => "accepted".to_owned(),
        Decision::Refused(refusal) => format!("refused: {}", refusal_text(refusal)),
        other => format!("{other:?}"),
    }
}

/// Reason of a refusal with its figures and units.
#[must_use]
pub fn refusal_text(refusal: &Refusal) -> String {
    match *refusal {
        Refusal::NotEnoughMotion { motion_s, needed_s } => format!(
            "the tool has moved too little: {motion_s:.1} s of motion with a usable gyro since the start, {needed_s:.1} s are \
             needed; turn it about more than one axis"
        ),
        Refusal::Overrun => {
            "the result was not ready when it should have taken effect: the processor has too little time left \
                             between samples; sample less often or leave out effects"
                .to_owned()
        }
        Refusal::NoAccelerometer => {
            "no usable accelerometer reading: nothing to hold the gyro against; check its wiring and its full scale"
                .to_owned()
        }
        Refusal::GyroUnusable { share } => format!(
            "the gyro gives too few usable readings: {:.0} % of the time they are missing, clipped or frozen, or contradict the field; check its full scale \
             and its wiring",
            100.0 * share
        ),
        Refusal::Diverged { nis } => format!(
            "the sensors contradict each other more than their noise allows: squared innovations are {nis:.1} times what was \
             expected; a sensor is loose, disturbed or delayed, which a diagnosis may name"
        ),
        Refusal::MagnetometerUncalibrated { hard_iron_share } => format!(
            "the magnetometer is not calibrated: its offset is {:.0} % of the field; calibrate it from turns in all directions",
            100.0 * hard_iron_share
        ),
        Refusal::NoMagnetometer { share } => format!(
            "{:.0} % of the motion has no usable field, and without one rotation about gravity cannot be seen; check the magnetometer, \
             and whether a magnet is near",
            100.0 * share
        ),
        Refusal::Implausible { sigmas } => format!(
            "P is {sigmas:.1} deviations of its prior from the factory's, more than any data sheet allows; check the gyro's axes, signs, \
             units and full scale"
        ),
        Refusal::WrongMounting { turns } => format!(
            "the sensors do not agree on turns about {}: a sign, a unit or an axis of one of them is wrong; a self-test names \
             the likely one",
            axes_text(by_any(turns))
        ),
        // The library may gain reasons that have no words here yet.
        ref other => format!("{other:?}"),
    }
}
