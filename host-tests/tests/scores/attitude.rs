use super::motions::{cells, close, flight, from, swing, swing_rate, trace, turn, unturned};
use crate::rig::rotation::rotation;
use nalgebra::UnitQuaternion;
use testbed::{
    flight::Flight,
    score::{Settings, score},
    trace::{EarthFrame, Trace},
};

#[test]
fn a_heading_offset_is_all_heading_and_a_tilt_is_all_inclination() {
    let trace = trace(10_000, 10, swing, swing_rate);
    let heading = score(&trace, &flight(&trace, |_| turn(0.0, 0.0, -12.0)), &from(0)).unwrap().attitude_rms_deg;
    close(heading.total, 12.0, 1e-4);
    close(heading.heading, 12.0, 1e-4);
    close(heading.inclination, 0.0, 1e-4);
    let tilt = score(&trace, &flight(&trace, |_| turn(3.0, 4.0, 0.0)), &from(0)).unwrap().attitude_rms_deg;
    close(tilt.total, 5.0, 1e-4);
    close(tilt.heading, 0.0, 1e-4);
    close(tilt.inclination, 5.0, 1e-4);
    // Half of the samples 10 deg off: root mean square, not mean.
    let half = |t: f64| turn(0.0, 0.0, if t < 5.0 { 10.0 } else { 0.0 });
    close(score(&trace, &flight(&trace, half), &from(0)).unwrap().attitude_rms_deg.heading, 50_f64.sqrt(), 1e-2);
    close(score(&trace, &flight(&trace, half), &from(5_000_000)).unwrap().attitude_rms_deg.heading, 0.0, 1e-4);
}

#[test]
fn a_reference_in_east_north_up_scores_as_one_in_north_east_down() {
    let ned = trace(10_000, 10, swing, |t| swing_rate(t) * 1.01);
    let flown = flight(&ned, |t| turn(2.0, 1.0, 5.0 * t));
    // v_enu = (v_ned.y, v_ned.x, -v_ned.z), written as a matrix and turned into a quaternion apart from the
    // scorer's own.
    let swap = nalgebra::Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    let ned_to_enu = UnitQuaternion::from_matrix(&swap);
    let mut enu = ned.clone();
    enu.keys.earth_frame = EarthFrame::Enu;
    for cell in enu.reference.iter_mut().flatten() {
        *cell = cells(&(ned_to_enu * rotation(*cell)));
    }
    let (a, b) = (score(&ned, &flown, &from(0)).unwrap(), score(&enu, &flown, &from(0)).unwrap());
    close(a.attitude_rms_deg.total, b.attitude_rms_deg.total.unwrap(), 1e-6);
    close(a.attitude_rms_deg.heading, b.attitude_rms_deg.heading.unwrap(), 1e-6);
    close(a.attitude_rms_deg.inclination, b.attitude_rms_deg.inclination.unwrap(), 1e-6);
    close(a.orientation_2s_rms_deg.with_effects, b.orientation_2s_rms_deg.with_effects.unwrap(), 1e-6);
    // Taken for NED, the same columns are more than a right angle off.
    enu.keys.earth_frame = EarthFrame::Ned;
    assert!(score(&enu, &flown, &from(0)).unwrap().attitude_rms_deg.total.unwrap() > 90.0);
}

#[test]
fn true_and_magnetic_north_differ_by_the_declination() {
    let mut trace = trace(10_000, 4, swing, swing_rate);
    let heading = |trace: &Trace, flight: &Flight, settings: &Settings| {
        score(trace, flight, settings).unwrap().attitude_rms_deg.heading
    };
    // The flight counts from true north: 7 deg more azimuth than the magnetic reference.
    let true_north = flight(&trace, |_| turn(0.0, 0.0, 7.0));
    let configured = Settings { declination_deg: Some(7.0), ..Settings::default() };
    close(heading(&trace, &true_north, &configured), 0.0, 1e-4);
    close(heading(&trace, &true_north, &Settings::default()), 7.0, 1e-4);
    trace.keys.magnetic_declination_deg = Some(7.0);
    // A reference that counts from true north itself.
    trace.keys.reference_north = true;
    let same = flight(&trace, unturned);
    close(heading(&trace, &same, &configured), 0.0, 1e-4);
    // A magnetic flight against it, with the declination known and unknown.
    let magnetic = flight(&trace, |_| turn(0.0, 0.0, -7.0));
    close(heading(&trace, &magnetic, &Settings::default()), 0.0, 1e-4);
    trace.keys.magnetic_declination_deg = None;
    assert_eq!(heading(&trace, &magnetic, &Settings::default()), None);
    close(score(&trace, &magnetic, &from(0)).unwrap().attitude_rms_deg.inclination, 0.0, 1e-4);
}
