//! Tests every order of a few operations on a small lane against a plain list of payloads.

use super::*;
use crate::telemetry::{Frame, FrameDecoder, Kind};

/// Bytes of the lane: two short payloads, or a long one; the ring's ends meet at every byte.
const ROOM: usize = 31;
const LENGTHS: [usize; 4] = [0, 3, 11, ROOM];
/// Operations: write a payload of each length; write over the oldest; take the oldest; drop the oldest.
const CHOICES: usize = LENGTHS.len() + 3;
const STEPS: u32 = if cfg!(miri) { 3 } else { 7 };

/// Payload: a byte, repeated this many times.
struct Bytes(u8, usize);

impl serde::Serialize for Bytes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(self.1)?;
        for _ in 0..self.1 {
            tuple.serialize_element(&self.0)?;
        }
        tuple.end()
    }
}

impl Payload for Bytes {
    const KIND: Kind = Kind::Sample;
}

/// Payloads that the lane should hold: byte and length.
type Listed = heapless::Deque<(u8, usize), 8>;

fn used(listed: &Listed) -> usize {
    listed.iter().map(|(_, length)| ENTRY_HEADER + length).sum()
}

/// Tells if a frame is this payload's.
fn is(frame: &[u8], (byte, length): (u8, usize)) -> bool {
    let mut decoder = FrameDecoder::<64>::new();
    frame.iter().any(|each| {
        let whole = decoder.push(*each);
        whole.is_some_and(|Frame { payload, .. }| payload.len() == length && payload.iter().all(|it| *it == byte))
    })
}

fn step(lane: &mut Lane<ROOM>, listed: &mut Listed, number: u8, choice: usize) {
    match choice {
        0..4 => {
            let length = LENGTHS[choice];
            let written = lane.write(number.into(), &Bytes(number, length));
            let fits = used(listed) + ENTRY_HEADER + length <= ROOM;
            assert_eq!(written.is_ok(), fits);
            if fits {
                listed.push_back((number, length)).unwrap();
            } else if listed.is_empty() {
                assert!(matches!(written, Err(Refused::TooLong)));
            }
        }
        4 => {
            let mut forgotten = 0;
            lane.write_over(number.into(), &Bytes(number, 11), &mut forgotten);
            let mut expected = 0;
            while used(listed) + ENTRY_HEADER + 11 > ROOM {
                listed.pop_front();
                expected += 1;
            }
            listed.push_back((number, 11)).unwrap();
            assert_eq!(forgotten, expected);
        }
        5 => {
            let mut buffer = [0; MAX_FRAME];
            let frame = lane.take(number.into(), &mut buffer);
            match listed.pop_front() {
                Some(payload) => assert!(frame.is_some_and(|frame| is(frame, payload))),
                None => assert!(frame.is_none()),
            }
        }
        _ => {
            lane.forget_oldest();
            listed.pop_front();
        }
    }
    assert_eq!(lane.room(), ROOM - used(listed));
    assert_eq!(lane.is_empty(), listed.is_empty());
    let waits = listed.front().map(|(oldest, _)| number - oldest);
    assert_eq!(lane.oldest_is_over(number.into(), 1), waits > Some(1));
}

#[test]
fn a_lane_holds_what_was_written_in_its_order_whatever_is_done() {
    for begun in 0..CHOICES.pow(STEPS) {
        let (mut lane, mut listed) = (Lane::<ROOM>::new(), Listed::new());
        let mut order = begun;
        // Not at 0: the numbers are the times, and a lane may be asked about one that was not yet.
        for number in (1..).take(STEPS as usize) {
            step(&mut lane, &mut listed, number, order % CHOICES);
            order /= CHOICES;
        }
    }
}
