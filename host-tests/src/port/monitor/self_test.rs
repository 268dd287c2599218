//! A self-test in words: what is wrong with the sensors, and the likely mistake.

use super::state::flags_text;
use crate::report::turned_axes::{axes_text, by_any, by_sensor};
use meerkat_mwd::{sample::TurnFlags, telemetry::SelfTest};

/// The findings of a self-test.
#[must_use]
pub fn self_test_text(test: &SelfTest) -> String {
    let mut found = Vec::new();
    found.push(if test.sensors.is_empty() { "sensors well".to_owned() } else { flags_text(test.sensors) });
    found.push(norm_text("gravity", test.gravity_mm_s2, "m/s^2", test.gravity_is_plausible(), "9.8 (its unit?)"));
    found.push(norm_text(
        "field",
        test.field_nt,
        "uT",
        test.field_is_plausible(),
        "20 to 70 (its unit, or iron near it?)",
    ));
    found.push(mounting_text(test.turns_seen, test.turns_wrong));
    found.push(
        match test.storage_holds {
            Some(true) => "the storage holds what it should",
            Some(false) => "the storage does not hold what it should",
            None => "there is no storage",
        }
        .to_owned(),
    );
    format!("{}: {}", if test.is_passed() { "passed" } else { "failed" }, found.join(", "))
}

fn norm_text(name: &str, thousandths: Option<u32>, unit: &str, is_plausible: bool, expected: &str) -> String {
    let Some(thousandths) = thousandths else { return format!("no {name}") };
    let norm = format!("{name} {:.2} {unit}", f64::from(thousandths) * 1e-3);
    if is_plausible { norm } else { format!("{norm} in place of {expected}") }
}

fn mounting_text(seen: TurnFlags, wrong: TurnFlags) -> String {
    let [accel, mag] = by_sensor(wrong);
    let both = [0, 1, 2].map(|axis| accel[axis] && mag[axis]);
    let mut told = Vec::new();
    if both.contains(&true) {
        told.push(format!("the gyro's sign, unit or axis about {} is wrong", axes_text(both)));
    }
    for (name, of_sensor) in [("accelerometer", accel), ("magnetometer", mag)] {
        let alone = [0, 1, 2].map(|axis| of_sensor[axis] && !both[axis]);
        if alone.contains(&true) {
            told.push(format!(
                "about {} gyro and {name} do not agree: {}",
                axes_text(alone),
                likely(name, alone, both)
            ));
        }
    }
    if told.is_empty() && !seen.is_empty() {
        told.push(format!("mounting right about {}", axes_text(by_any(seen))));
    }
    let unseen = by_any(seen).map(|is_seen| !is_seen);
    if unseen.contains(&true) {
        told.push(format!(
            "no turn about {} seen (turn the probe by hand about each of its axes and ask again)",
            axes_text(unseen)
        ));
    }
    told.join(", ")
}

/// Cause for which one sensor differs from the gyro about these axes. A vector with one sign turned, or two, turns the
/// wrong way about the two axes across; with two axes exchanged about all.
fn likely(name: &str, wrong: [bool; 3], of_gyro: [bool; 3]) -> String {
    let across = wrong.iter().position(|wrong| !wrong).filter(|axis| !of_gyro[*axis]);
    match (wrong.iter().filter(|wrong| **wrong).count(), across) {
        (2, Some(axis)) => format!("the sign of the {name}'s {}, likely", ["x", "y", "z"][axis]),
        (3, _) => format!("axes of the {name} exchanged, likely"),
        _ => format!("a sign or an axis of the {name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(seen: TurnFlags, wrong: TurnFlags) -> SelfTest {
        SelfTest {
            storage_holds: Some(true),
            gravity_mm_s2: Some(9_812),
            field_nt: Some(48_230),
            turns_seen: seen,
            turns_wrong: wrong,
            ..SelfTest::default()
        }
    }

    #[test]
    fn the_axis_and_the_likely_mistake_are_named() {
        let about_x = TurnFlags::X_BY_ACCEL | TurnFlags::X_BY_MAG;
        let two = TurnFlags::X_BY_ACCEL | TurnFlags::Y_BY_ACCEL;
        let by_mag = TurnFlags::X_BY_MAG | TurnFlags::Y_BY_MAG | TurnFlags::Z_BY_MAG;
        for (seen, wrong, said) in [
            (
                TurnFlags::all(),
                TurnFlags::empty(),
                "passed: sensors well, gravity 9.81 m/s^2, field 48.23 uT, mounting right about x, y, z, the storage",
            ),
            (
                TurnFlags::Z_BY_MAG,
                TurnFlags::empty(),
                "mounting right about z, no turn about x, y seen (turn the probe",
            ),
            (TurnFlags::empty(), TurnFlags::empty(), "uT, no turn about x, y, z seen"),
            (
                TurnFlags::all(),
                about_x,
                "failed: sensors well, gravity 9.81 m/s^2, field 48.23 uT, the gyro's sign, unit or axis about x is wrong",
            ),
            (
                TurnFlags::all(),
                two,
                "about x, y gyro and accelerometer do not agree: the sign of the accelerometer's z, likely",
            ),
            (
                TurnFlags::all(),
                by_mag,
                "about x, y, z gyro and magnetometer do not agree: axes of the magnetometer exchanged, likely",
            ),
        ] {
            let text = self_test_text(&test(seen, wrong));
            assert!(text.contains(said), "{text}");
        }
        let in_g = SelfTest { gravity_mm_s2: Some(1_000), ..test(TurnFlags::all(), TurnFlags::empty()) };
        assert!(self_test_text(&in_g).starts_with("failed: sensors well, gravity 1.00 m/s^2 in place of 9.8"));
    }
}
