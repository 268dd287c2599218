//! Requests of a host without a key: one that asks without end, one that does not read.

use super::desk_board::{Desk, fly};
use meerkat_mwd::{
    compensation::{GyroModel, VectorModel},
    storage::{FactoryCalibration, FactoryRecord},
    telemetry::{Command, Kind, MAX_FRAME, MAX_PAYLOAD, Message, Outcome, encode_frame, encode_payload},
};

/// The same eleven bytes as fast as the line takes them: each asks for a boot of 530. The survey of the rest comes all
/// the same, at once.
#[test]
fn a_flood_of_requests_keeps_no_survey_from_the_line() {
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let payload = encode_payload(&Command::StartRecording { for_s: None }, &mut payload).unwrap();
    let frame = encode_frame(Kind::Command, 9, payload, &mut buffer).unwrap().to_vec();
    let desk = Desk::default();
    let (bytes_per_s, mut sent) = (u64::from(desk.bytes_per_s), 0);
    let flood = frame.clone();
    let line = move |now_us| {
        let due = (sent as u64 + 1) * 1_000_000 / bytes_per_s <= now_us;
        sent += usize::from(due);
        due.then(|| flood[(sent - 1) % flood.len()])
    };
    let seen = fly(Desk { line: Box::new(line), ..desk }, 20);
    let count = |kind: fn(&Message) -> bool| seen.messages.iter().filter(|(_, message)| kind(message)).count();
    let boots = count(|message| matches!(message, Message::Boot(_)));
    let answers = count(|message| matches!(message, Message::Acknowledgement(_)));
    let survey = seen.messages.iter().find_map(|(us, message)| match message {
        Message::Survey(survey) => Some(us - survey.survey.t_end_us),
        _ => None,
    });
    println!("{} bytes again and again: {boots} boots, {answers} answers; the survey {survey:?} us late", frame.len());
    assert!(survey.is_some_and(|late_us| late_us < 500_000), "{survey:?}");
    // The start's own, four at once and one in two seconds.
    assert!(boots <= 1 + 4 + 10 && (20..=8 + 4 * 20).contains(&answers), "{boots} boots, {answers} answers");
}

/// For 40 s the line takes nothing, as with a host that is busy elsewhere; then the host asks for a self-test, before
/// it reads on. Reports of health, one in 5 s, must not have taken the room of the answer, and of what was found.
#[test]
fn a_host_that_did_not_read_gets_its_answer() {
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let payload = encode_payload(&Command::SelfTest, &mut payload).unwrap();
    let frame = encode_frame(Kind::Command, 9, payload, &mut buffer).unwrap().to_vec();
    let mut sent = 0;
    let line = move |now_us| {
        let byte = frame.get(sent).filter(|_| now_us > 44_000_000).copied();
        sent += usize::from(byte.is_some());
        byte
    };
    let takes = |now_us| !(5_000_000..45_000_000).contains(&now_us);
    let seen = fly(Desk { takes, line: Box::new(line), ..Desk::default() }, 47);
    let late = seen.messages.iter().filter(|(us, _)| *us > 45_000_000);
    let answered = late.clone().any(|(_, message)| match message {
        Message::Acknowledgement(answer) => answer.sequence == 9 && answer.outcome == Outcome::Accepted,
        _ => false,
    });
    let found =
        late.clone().any(|(_, message)| matches!(message, Message::Health(health) if health.self_test.is_some()));
    assert!(answered && found, "answered: {answered}, found: {found}");
}

/// A calibration is written, and the flight starts anew from it. Whoever sends it again, without the key and while the
/// tool drills, has his answer and changes nothing.
#[test]
fn a_calibration_that_the_probe_holds_starts_no_flight_anew() {
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let (accel, mag) = (VectorModel::IDENTITY, VectorModel::IDENTITY);
    let calibration = FactoryCalibration { gyro: GyroModel::IDENTITY, accel, mag, serial_number: 7 };
    let record = FactoryRecord::Calibration(calibration);
    let payload = encode_payload(&Command::Provision { record, only_check: false }, &mut payload).unwrap();
    let mut bytes = Vec::new();
    for sequence in 1..=3 {
        bytes.extend(encode_frame(Kind::Command, sequence, payload, &mut buffer).unwrap());
    }
    let mut sent = 0;
    let line = move |now_us| {
        let byte = bytes.get(sent).filter(|_| now_us > 3_000_000).copied();
        sent += usize::from(byte.is_some());
        byte
    };
    let seen = fly(Desk { line: Box::new(line), ..Desk::default() }, 8);
    let boots = seen.messages.iter().filter(|(_, message)| matches!(message, Message::Boot(_))).count();
    let accepted = seen.messages.iter().filter(|(_, message)| match message {
        Message::Acknowledgement(answer) => answer.outcome == Outcome::Accepted,
        _ => false,
    });
    assert_eq!((accepted.count(), boots), (3, 2), "one boot of the start, one of the calibration");
}
