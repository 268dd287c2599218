//! Messages of a flight arrive, and fit into frames.

use crate::{
    flown,
    frames::{self, Decoder},
};
use meerkat_mwd::{
    Config,
    attitude::{Attitude, AttitudeFlags},
    compensation::FoundEffect,
    probe::Output,
    survey::SurveyKind,
    telemetry::{
        AttitudeFormat, AttitudeFrame, Boot, Command, Frame, Kind, MAX_PAYLOAD, Message, PayloadError, encode_payload,
    },
};
use proptest::prelude::*;
use std::f32::consts::{PI, TAU};

#[test]
fn what_a_flight_says_arrives() {
    let (config, samples) = flown::recording("broad_06");
    let flight = testbed::flight::fly(&config, &samples, |_| ()).unwrap();
    for format in [AttitudeFormat::Compact, AttitudeFormat::Exact] {
        let bytes = flown::stream(&config, &samples, format);
        let messages = frames::messages(&bytes);
        assert_eq!(messages.first(), Some(&Message::Boot(Boot::new(config))));
        let (mut raw, mut reports, mut diagnoses, mut surveys, mut attitudes) =
            (vec![], vec![], vec![], vec![], vec![]);
        let mut outputs = vec![];
        for message in messages {
            match message {
                Message::Sample(sample) => raw.push(sample),
                Message::Identification(identification) => reports.push(identification.report),
                Message::Diagnosis(report) => diagnoses.push(report),
                Message::Survey(report) => surveys.push(report),
                Message::Attitude(attitude) => attitudes.push(attitude),
                Message::Output(output) => outputs.push(output),
                _ => {}
            }
        }
        assert!(raw.iter().map(|raw| raw.sample).eq(samples.iter().map(|sample| sample.sanitised())));
        assert!(raw.iter().map(|raw| raw.number).eq(0..samples.len() as u32));
        assert_eq!(reports, flight.reports);
        assert_eq!(diagnoses, flight.diagnoses);
        assert!(surveys.iter().all(|report| report.survey.kind == SurveyKind::Stationary));
        if format == AttitudeFormat::Exact {
            assert_eq!(outputs, flight.outputs);
        } else {
            let expected: Vec<AttitudeFrame> = flight.outputs.iter().map(AttitudeFrame::of).collect();
            assert_eq!(attitudes, expected);
        }
    }
}

/// No report is longer than a frame, whatever is in it: all that can be long is, and every count of time at
/// its largest.
#[test]
fn the_longest_payloads_fit() {
    let (config, samples) = flown::recording("broad_35");
    let bytes = flown::stream(&config, &samples, AttitudeFormat::Compact);
    let mut buffer = [0; 4096];
    let mut longest: std::collections::BTreeMap<u8, usize> = std::collections::BTreeMap::new();
    for (kind, _, payload) in frames::frames(&mut Decoder::new(), &bytes) {
        let most = longest.entry(kind).or_default();
        *most = payload.len().max(*most);
    }
    let diagnosis = frames::messages(&bytes).into_iter().find_map(|message| match message {
        Message::Diagnosis(report) => Some(report),
        _ => None,
    });
    let mut diagnosis = diagnosis.expect("a diagnosis");
    (diagnosis.t_start_us, diagnosis.t_end_us, diagnosis.t_effect_us) = (u64::MAX, u64::MAX, u64::MAX);
    diagnosis.count = diagnosis.effects.len() as u8;
    for effect in &mut diagnosis.effects {
        effect.found = FoundEffect { index: 200, ..effect.found };
        effect.rivals = u32::MAX;
        (effect.step_us, effect.found_us, effect.taken_out_us) = (u64::MAX, u64::MAX, u64::MAX);
    }
    let length = encode_payload(&diagnosis, &mut buffer).unwrap().len();
    println!("longest payloads by kind: {longest:?}; a diagnosis with everything {length}");
    // All that has a variable width is at its widest.
    assert!(length <= MAX_PAYLOAD);
    let full = Config { seed: u64::MAX, ..config };
    assert!(encode_payload(&Command::Configure(full), &mut buffer).unwrap().len() + 24 < MAX_PAYLOAD);
}

fn attitude(angles: [f32; 4], sigmas: [f32; 3]) -> Output {
    let [inclination_rad, azimuth_rad, gravity_toolface_rad, magnetic_toolface_rad] = angles;
    let [sigma_inclination_rad, sigma_azimuth_rad, sigma_toolface_rad] = sigmas;
    let attitude = Attitude {
        q: [1.0, 0.0, 0.0, 0.0],
        inclination_rad,
        azimuth_rad,
        gravity_toolface_rad,
        magnetic_toolface_rad,
        sigma_inclination_rad,
        sigma_azimuth_rad,
        sigma_toolface_rad,
        flags: AttitudeFlags::NEAR_VERTICAL,
    };
    Output { t_us: 1, rate_rad_s: [0.0; 3], attitude: Some(attitude) }
}

proptest! {
    #[test]
    fn a_compact_attitude_is_within_half_a_step(
        inclination in 0.0..=PI, turns in prop::array::uniform3(0.0..TAU), sigmas in prop::array::uniform3(0.0..=PI),
    ) {
        let angles = [inclination, turns[0], turns[1], turns[2]];
        let compact = AttitudeFrame::of(&attitude(angles, sigmas)).angles.unwrap();
        let told = [
            compact.inclination_rad(), compact.azimuth_rad(), compact.gravity_toolface_rad(),
            compact.magnetic_toolface_rad(),
        ];
        for (angle, told) in angles.into_iter().zip(told) {
            let apart = libm::remainder(f64::from(angle) - f64::from(told), std::f64::consts::TAU);
            prop_assert!(apart.abs() <= std::f64::consts::TAU / 65_536.0 / 2.0 + 1e-6, "{angle} {told}");
        }
        for (sigma, told) in sigmas.into_iter().zip(compact.sigmas_rad()) {
            prop_assert!((sigma - told).abs() <= 0.000_051 || (sigma < 0.000_1 && told > 0.0));
            prop_assert_eq!(sigma > 0.0, told > 0.0);
        }
        prop_assert_eq!(compact.flags(), AttitudeFlags::NEAR_VERTICAL);
    }
}

#[test]
fn an_attitude_that_is_no_number_is_none() {
    let angles = |angles, sigmas| AttitudeFrame::of(&attitude(angles, sigmas)).angles;
    assert!(angles([f32::NAN, 0.0, 0.0, 0.0], [0.0; 3]).is_none());
    assert!(angles([0.0; 4], [0.0, f32::INFINITY, 0.0]).is_none());
    assert!(angles([0.0; 4], [0.0; 3]).is_some());
}

#[test]
fn another_versions_frames_are_told_and_never_misread() {
    let decode = |kind, payload| Message::decode(&Frame { kind, sequence: 0, payload });
    assert_eq!(decode(200, &[]), Err(PayloadError::UnknownKind { kind: 200 }));
    assert_eq!(decode(Kind::Command.number(), &[]), Err(PayloadError::UnknownKind { kind: 64 }));
    let mut buffer = [0; 64];
    let sent = encode_payload(&AttitudeFrame { t_us: 300, angles: None }, &mut buffer).unwrap().to_vec();
    let kind = Kind::Attitude;
    assert!(decode(kind.number(), &sent).is_ok());
    let longer = [&sent[..], &[0]].concat();
    for other in [&sent[..sent.len() - 1], &longer, &[]] {
        assert_eq!(decode(kind.number(), other), Err(PayloadError::Malformed { kind }));
    }
}
