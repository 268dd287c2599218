//! Who has no key and asks without end.

use super::desk_board::{Desk, fly};
use meerkat_mwd::telemetry::{Command, Kind, MAX_FRAME, MAX_PAYLOAD, Message, encode_frame, encode_payload};

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
