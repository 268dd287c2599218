//! Damage on the line: nothing that was not sent is taken for a frame, and the next whole frame is.

use crate::flown::{self, Decoder};
use meerkat_mwd::telemetry::{AttitudeFormat, Message};

#[test]
fn what_a_flight_says_arrives() {
    let (config, samples) = flown::recording("broad_06");
    let bytes = flown::stream(&config, &samples, AttitudeFormat::Compact);
    let messages = flown::messages(&bytes);
    let of = |is: fn(&Message) -> bool| messages.iter().filter(|message| is(message)).count();
    assert_eq!(messages.first(), Some(&Message::Boot(meerkat_mwd::telemetry::Boot::new(config))));
    assert_eq!(of(|m| matches!(m, Message::Sample(_))), samples.len());
    let flight = mwd::flight::fly(&config, &samples, |_| ()).unwrap();
    let outputs = flight.outputs.len();
    assert_eq!(of(|m| matches!(m, Message::Attitude(_))), outputs);
    assert_eq!(of(|m| matches!(m, Message::Identification(_))), flight.reports.len());
    assert_eq!(of(|m| matches!(m, Message::Diagnosis(_))), flight.diagnoses.len());
    let mut decoder = Decoder::new();
    let longest = flown::frames(&mut decoder, &bytes).into_iter().map(|(kind, _, payload)| (payload.len(), kind)).max();
    println!("{} bytes, {} messages, longest payload {longest:?}", bytes.len(), messages.len());
}
