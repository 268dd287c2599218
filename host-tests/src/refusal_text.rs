//! Why P was refused, in words.

use meerkat_mwd::identification::{Decision, Refusal};

/// A window's outcome.
#[must_use]
pub fn decision_text(decision: &Decision) -> String {
    match decision {
        Decision::Accepted => "accepted".to_owned(),
        Decision::Refused(refusal) => format!("refused: {}", refusal_text(refusal)),
        other => format!("{other:?}"),
    }
}

/// The reason as a reader of the report wants it, with its figures and units.
#[must_use]
pub fn refusal_text(refusal: &Refusal) -> String {
    match *refusal {
        Refusal::WindowTooShort { length_s, needed_s, cut_by_gap } => {
            let cut = if cut_by_gap { ", cut by a gap in time" } else { "" };
            format!("the window is too short: {length_s:.1} s of the {needed_s:.1} s needed{cut}")
        }
        Refusal::Overrun => "the result was not ready when it should have taken effect".to_owned(),
        Refusal::NoMagnetometer { accel_norm_error_m_s2 } => {
            let accel = accel_norm_error_m_s2.map_or_else(
                || "the accelerometer has no calibration on record".to_owned(),
                |error| {
                    format!(
                        "the accelerometer is not calibrated: its norm at rest is up to {error:.3} m/s^2 from gravity"
                    )
                },
            );
            format!("no magnetometer, or none with usable readings: rotation about the vertical cannot be seen; {accel}")
        }
        Refusal::NoAccelerometer => "no usable accelerometer reading".to_owned(),
        Refusal::AccelerometerUncalibrated { norm_error_m_s2 } => {
            format!("the accelerometer is not calibrated: its norm at rest is {norm_error_m_s2:.3} m/s^2 from gravity")
        }
        Refusal::NotEnoughExcitation { rank } => {
            format!("the tool turned too little: {rank} of 12 parameter directions are observable")
        }
        Refusal::TooLittleMotion { groups } => {
            format!("too little of the window moved with usable readings: {groups} groups to cross-validate with")
        }
        Refusal::NoClearWin { p_value } => {
            format!("no clear win on unseen blocks: chance alone does as well with probability {p_value:.3}")
        }
        Refusal::MisfitNotExplained { explained } => format!(
            "the fit explains only {:.0} % of the misfit on unseen blocks: what is wrong is not mainly P",
            100.0 * explained
        ),
        Refusal::ChangeTooSmall { change_rad, sigma_rad } => format!(
            "the change is too small to be worth its risk: {:.4} deg rms per second, 1-sigma {:.4} deg",
            change_rad.to_degrees(),
            sigma_rad.to_degrees()
        ),
        Refusal::Degenerate => "the fit is degenerate, not finite or not plausible".to_owned(),
        Refusal::RotationDisagrees { sigmas } => format!(
            "with the fit, gyro and accelerometer disagree more on how far the tool turned, by {sigmas:.1} sigma"
        ),
        Refusal::RolledBack { p_value } => format!(
            "the P that flew no longer beats the factory's on unseen blocks (p of the factory's win = {p_value:.3}), and is rolled back"
        ),
        Refusal::Contradiction { square } => format!(
            "the window contradicts what earlier ones taught, which is forgotten: squared distance {square:.0} of 12 parameters"
        ),
        Refusal::FieldDoubtful => {
            "the magnetometer's axes are turned or a magnet came or left, and P changes by no more than that may look like".to_owned()
        }
        Refusal::GyroUnusable { share } => format!(
            "the gyro gives too few usable readings: {:.0} % of the seconds have missing, clipped or frozen ones",
            100.0 * share
        ),
        // Variants may be added to the library before they have words here.
        ref other => format!("{other:?}"),
    }
}
