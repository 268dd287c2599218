//! The check of the mounting on recordings of real sensors: in hands, on a table, with magnets, on a robot's gimbal.

use meerkat_mwd::{Sample, sample::TurnFlags, sensors::MountingCheck};
use testbed::trace::{
    Trace,
    recordings::{bundled, given, name},
};

/// All turns that were ever seen, and all that were ever wrong, in a recording so changed.
fn checked(trace: &Trace, change: impl Fn(&mut Sample)) -> [TurnFlags; 2] {
    let mut check = MountingCheck::new();
    let mut ever = [TurnFlags::empty(); 2];
    for (k, mut sample) in trace.samples().enumerate() {
        change(&mut sample);
        check.update(&sample, [0.0; 3]);
        ever[1] |= check.wrong();
        if k % 100 == 0 {
            ever[0] |= check.seen();
        }
    }
    ever
}

/// Turns about one axis of the three.
fn about(axis: usize) -> TurnFlags {
    TurnFlags::from_bits_truncate(0b001_001 << axis)
}

#[test]
fn no_sound_sensor_is_ever_called_wrong_and_a_turned_axis_is_where_it_is_seen() {
    let mut judged = 0;
    for path in bundled().unwrap().into_iter().chain(given().unwrap()) {
        let trace = Trace::read(&path).unwrap();
        let [seen, wrong] = checked(&trace, |_| ());
        assert_eq!(wrong, TurnFlags::empty(), "{}", name(&path));
        for axis in 0..3 {
            let [of_turned, wrong] = checked(&trace, |sample| sample.gyro_rad_s[axis] *= -1.0);
            assert_eq!((of_turned, wrong), (seen, seen & about(axis)), "{} {axis}", name(&path));
            judged += (seen & about(axis)).iter().count();
        }
        let turned = checked(&trace, |sample| sample.accel_m_s2[2] *= -1.0);
        let across = seen & (TurnFlags::X_BY_ACCEL | TurnFlags::Y_BY_ACCEL);
        assert_eq!(turned, [seen, across], "{}", name(&path));
    }
    // Two of the bundled recordings are of turns alone.
    assert!(judged >= 5, "{judged}");
}
