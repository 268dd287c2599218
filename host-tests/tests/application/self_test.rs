//! A probe that is turned by hand on a desk and asked for a self-test.

use super::desk_board::{Desk, fly};
use meerkat_mwd::{
    Sample, SampleFlags,
    attitude::AttitudeFlags,
    identification::{Decision, Refusal},
    sample::TurnFlags,
    survey::{Checked, Grade},
    telemetry::{Command, Kind, MAX_FRAME, MAX_PAYLOAD, Message, SelfTest, encode_frame, encode_payload},
};
use nalgebra::{Rotation3, Vector3};
use std::f32::consts::TAU;

/// Turns about x, y and z, a quarter there and back, twice each in 24 s; then rest.
fn turned_by_hand(period_s: f32, mount: fn(&mut Sample)) -> impl FnMut(Sample) -> Sample {
    let mut body_to_desk = Rotation3::identity();
    move |at_rest: Sample| {
        let t_s = at_rest.t_us as f32 * 1e-6;
        let rate = match (t_s / 8.0) as usize {
            axis @ 0..=2 => Vector3::ith(axis, 1.25 * libm::sinf(TAU * t_s / 4.0)),
            _ => Vector3::zeros(),
        };
        body_to_desk *= Rotation3::new(rate * period_s);
        let turned = |vector: [f32; 3]| <[f32; 3]>::from(body_to_desk.inverse() * Vector3::from(vector));
        let mut sample = Sample {
            gyro_rad_s: (Vector3::from(at_rest.gyro_rad_s) + rate).into(),
            accel_m_s2: turned(at_rest.accel_m_s2),
            mag_ut: turned(at_rest.mag_ut),
            ..at_rest
        };
        mount(&mut sample);
        sample
    }
}

fn self_test(mount: fn(&mut Sample)) -> SelfTest {
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let payload = encode_payload(&Command::SelfTest, &mut payload).unwrap();
    let frame = encode_frame(Kind::Command, 9, payload, &mut buffer).unwrap().to_vec();
    let mut sent = 0;
    let line = move |now_us| {
        let byte = frame.get(sent).filter(|_| now_us > 30_000_000).copied();
        sent += usize::from(byte.is_some());
        byte
    };
    let desk = Desk::default();
    let reads = Box::new(turned_by_hand(desk.period_us as f32 * 1e-6, mount));
    let seen = fly(Desk { line: Box::new(line), reads, ..desk }, 32);
    let found = seen.messages.iter().find_map(|(_, message)| match message {
        Message::Health(health) => health.self_test,
        _ => None,
    });
    found.unwrap()
}

/// A minute on a desk, of which the probe is turned by hand for 24 s: grades and reasons of the surveys that began
/// after that, and decisions of the windows.
fn minute(mount: fn(&mut Sample)) -> (Vec<(Grade, Checked)>, Vec<Decision>) {
    let desk = Desk::default();
    let reads = Box::new(turned_by_hand(desk.period_us as f32 * 1e-6, mount));
    let seen = fly(Desk { reads, ..desk }, 62);
    let (mut surveys, mut windows) = (Vec::new(), Vec::new());
    for (_, message) in seen.messages {
        match message {
            Message::Survey(report) if report.survey.t_start_us > 24_000_000 => {
                surveys.push((report.quality.grade, report.quality.reason.checked));
            }
            Message::Identification(window) => windows.push(window.report.decision),
            _ => {}
        }
    }
    (surveys, windows)
}

#[test]
fn no_survey_is_good_and_no_p_is_accepted_while_the_sensors_do_not_agree_on_a_turn() {
    let (surveys, windows) = minute(|_| ());
    assert!(!surveys.is_empty() && surveys.iter().all(|(grade, _)| *grade == Grade::Good), "{surveys:?}");
    assert_eq!(windows, [Decision::Accepted]);
    for (mount, turns) in [
        ((|sample| sample.gyro_rad_s[1] *= -1.0) as fn(&mut Sample), TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG),
        (|sample| sample.mag_ut[2] *= -1.0, TurnFlags::X_BY_MAG | TurnFlags::Y_BY_MAG),
        (|sample| sample.accel_m_s2[0] *= -1.0, TurnFlags::Y_BY_ACCEL | TurnFlags::Z_BY_ACCEL),
    ] {
        let (surveys, windows) = minute(mount);
        assert!(!surveys.is_empty() && surveys.iter().all(|it| *it == (Grade::Bad, Checked::Mounting)), "{surveys:?}");
        assert_eq!(windows, [Decision::Refused(Refusal::WrongMounting { turns })]);
    }
}

#[test]
fn turns_by_hand_show_a_wrong_sign_or_unit() {
    let well = self_test(|_| ());
    assert_eq!((well.turns_seen, well.turns_wrong), (TurnFlags::all(), TurnFlags::empty()), "{well:?}");
    assert!(well.gravity_is_plausible() && well.field_is_plausible(), "{well:?}");
    let gyro = self_test(|sample| sample.gyro_rad_s[1] *= -1.0);
    assert_eq!(gyro.turns_wrong, TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG, "{gyro:?}");
    let magnetometer = self_test(|sample| sample.mag_ut[2] *= -1.0);
    assert_eq!(magnetometer.turns_wrong, TurnFlags::X_BY_MAG | TurnFlags::Y_BY_MAG, "{magnetometer:?}");
    let in_gauss = self_test(|sample| sample.mag_ut = sample.mag_ut.map(|x| 0.01 * x));
    assert!(!in_gauss.is_passed() && !in_gauss.field_is_plausible(), "{in_gauss:?}");
}

/// The number of a sample of the desk's board.
const fn number(sample: &Sample) -> u64 {
    sample.t_us / 5_000
}

/// A magnetometer slower than the samples is in some of them alone, and of a sound part a reading in 1,000 is not
/// believed.
#[test]
fn a_sound_sensor_is_at_fault_at_no_time() {
    for mount in [
        (|sample| sample.flags.set(SampleFlags::MAG_MISSING, !number(sample).is_multiple_of(4))) as fn(&mut Sample),
        (|sample| sample.flags.set(SampleFlags::MAG_MISSING, number(sample) % 4 != 1)),
        (|sample| sample.flags.set(SampleFlags::MAG_MISSING, number(sample) % 4 != 2)),
        (|sample| sample.flags.set(SampleFlags::MAG_MISSING, number(sample) % 4 != 3)),
        // Sooner than the samples that are still on their way as the command comes.
        (|sample| sample.flags.set(SampleFlags::ACCEL_MISSING, (5_980..5_984).contains(&number(sample)))),
        (|sample| sample.flags.set(SampleFlags::GYRO_MISSING, (5_980..5_984).contains(&number(sample)))),
    ] {
        assert_eq!(self_test(mount).sensors, AttitudeFlags::empty());
    }
}

#[test]
fn a_sensor_that_reads_now_and_then_is_at_fault() {
    for (mount, fault) in [
        ((|sample| sample.flags.insert(SampleFlags::MAG_MISSING)) as fn(&mut Sample), AttitudeFlags::MAG_UNUSED),
        (|sample| sample.flags.set(SampleFlags::GYRO_MISSING, number(sample) % 10 == 5), AttitudeFlags::GYRO_HELD),
        (|sample| sample.flags.set(SampleFlags::ACCEL_MISSING, number(sample) % 10 == 5), AttitudeFlags::ACCEL_UNUSED),
    ] {
        assert_eq!(self_test(mount).sensors, fault);
    }
}
