//! Axes of turns, by their names.

use meerkat_mwd::sample::TurnFlags;

/// For x, y and z: whether flags have the turn about it, by the accelerometer and by the magnetometer.
#[must_use]
pub fn by_sensor(flags: TurnFlags) -> [[bool; 3]; 2] {
    [
        [TurnFlags::X_BY_ACCEL, TurnFlags::Y_BY_ACCEL, TurnFlags::Z_BY_ACCEL],
        [TurnFlags::X_BY_MAG, TurnFlags::Y_BY_MAG, TurnFlags::Z_BY_MAG],
    ]
    .map(|sensor| sensor.map(|flag| flags.contains(flag)))
}

/// For x, y and z: whether flags have the turn about it, by whichever sensor.
#[must_use]
pub fn by_any(flags: TurnFlags) -> [bool; 3] {
    let [accel, mag] = by_sensor(flags);
    [0, 1, 2].map(|axis| accel[axis] || mag[axis])
}

/// Names of the axes that hold.
#[must_use]
pub fn axes_text(which: [bool; 3]) -> String {
    let names: Vec<&str> = ["x", "y", "z"].into_iter().zip(which).filter(|(_, it)| *it).map(|(name, _)| name).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_named_once_whichever_sensor_saw_its_turn() {
        let flags = TurnFlags::X_BY_MAG | TurnFlags::Z_BY_ACCEL | TurnFlags::Z_BY_MAG;
        assert_eq!(by_sensor(flags), [[false, false, true], [true, false, true]]);
        assert_eq!(axes_text(by_any(flags)), "x, z");
        assert_eq!(axes_text(by_any(TurnFlags::empty())), "");
    }
}
