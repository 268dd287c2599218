//! Damage on the line: nothing that was not sent is taken for a frame, and the next whole frame is.
//!
//! A frame with a wrong check passes once in 2^32: of the 10^7 damaged ones here, with fixed seeds, none
//! does.

use crate::{
    commands, flown,
    frames::{self, Decoder},
};
use meerkat_mwd::telemetry::{AttitudeFormat, FrameDecoder, Kind, MAX_FRAME, encode_frame};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// A frame on the line, with its zero, and what it says.
#[derive(Clone)]
struct OnLine {
    bytes: Vec<u8>,
    says: (u8, u16, Vec<u8>),
}

fn split(bytes: &[u8]) -> Vec<OnLine> {
    let bytes = bytes.strip_prefix(&[0]).unwrap_or(bytes);
    let frames = bytes.split_inclusive(|&byte| byte == 0).map(|bytes| {
        let says = frames::frames(&mut Decoder::new(), bytes);
        assert_eq!(says.len(), 1);
        OnLine { bytes: bytes.to_vec(), says: says[0].clone() }
    });
    frames.collect()
}

/// Half a second of everything, and every result of a flight.
fn telemetry() -> Vec<OnLine> {
    let (config, samples) = flown::recording("broad_06");
    let whole = split(&flown::stream(&config, &samples, AttitudeFormat::Compact));
    let streamed = [Kind::Attitude, Kind::Sample, Kind::Health].map(Kind::number);
    let mut kept = whole[..250].to_vec();
    kept.extend(whole[250..].iter().filter(|frame| !streamed.contains(&frame.says.0)).cloned());
    kept.extend(whole.iter().filter(|frame| frame.says.0 == Kind::Health.number()).take(2).cloned());
    kept
}

/// Frames that a host sends: every command, plain and authenticated.
fn orders() -> Vec<OnLine> {
    split(&commands::every_command_on_line())
}

/// Every byte of every frame, made each other byte: what is accepted was sent, only this frame is lost, and
/// with its zero the next one.
fn single_bytes(frames: &[OnLine]) -> u64 {
    let mut tried = 0;
    for (index, frame) in frames.iter().enumerate() {
        let following = [&frames[(index + 1) % frames.len()], &frames[(index + 2) % frames.len()]];
        let mut bytes = frame.bytes.clone();
        for place in 0..bytes.len() {
            let right = bytes[place];
            for wrong in (0..=255).filter(|&wrong| wrong != right) {
                bytes[place] = wrong;
                tried += 1;
                let mut decoder = Decoder::new();
                let mut accepted = frames::frames(&mut decoder, &bytes);
                accepted.extend(frames::frames(&mut decoder, &following[0].bytes));
                accepted.extend(frames::frames(&mut decoder, &following[1].bytes));
                let last = place + 1 == bytes.len();
                let expected: &[&OnLine] = if last { &following[1..] } else { &following };
                // Some codes of COBS may be changed without a change of what is said.
                let same = accepted.len() > expected.len() && accepted[0] == frame.says;
                let others = &accepted[usize::from(same)..];
                assert!(others.iter().eq(expected.iter().map(|frame| &frame.says)), "byte {place} of {:?}", frame.says);
                let counters = decoder.counters();
                assert!(same || counters.bad + counters.oversize > 0);
            }
            bytes[place] = right;
        }
    }
    tried
}

#[test]
fn no_single_byte_is_changed_unnoticed_in_telemetry() {
    let frames = telemetry();
    println!("{} single bytes changed in {} frames of telemetry", single_bytes(&frames), frames.len());
}

#[test]
fn no_single_byte_is_changed_unnoticed_in_commands() {
    let frames = orders();
    println!("{} single bytes changed in {} frames of commands", single_bytes(&frames), frames.len());
}

/// Damages the bytes somewhere; gives the first and the last place that is no longer what it was, as places
/// before the damage.
fn damage(bytes: &mut Vec<u8>, rng: &mut Xoshiro128PlusPlus) -> (usize, usize) {
    let mut below = |limit: usize| rng.next_u32() as usize % limit;
    let at = below(bytes.len());
    match below(5) {
        0 => {
            // Bits flip, near each other.
            let mut last = at;
            for _ in 0..=below(8) {
                let place = (at + below(16)).min(bytes.len() - 1);
                bytes[place] ^= 1 << below(8);
                last = last.max(place);
            }
            (at, last)
        }
        1 => {
            let noise: Vec<u8> = (0..=below(16)).map(|_| below(256) as u8).collect();
            bytes.splice(at..at, noise);
            (at, at)
        }
        2 => {
            let end = (at + 1 + below(64)).min(bytes.len());
            bytes.drain(at..end);
            (at, end - 1)
        }
        3 => {
            let end = (at + 1 + below(64)).min(bytes.len());
            bytes[at..end].fill_with(|| below(256) as u8);
            (at, end - 1)
        }
        _ => {
            // The line breaks: it reads 0 or 1 all the time.
            let end = (at + 1 + below(32)).min(bytes.len());
            let stuck = if below(2) == 0 { 0 } else { 255 };
            bytes[at..end].fill(stuck);
            (at, end - 1)
        }
    }
}

fn random_damage(frames: &[OnLine], times: u32, seed: u64) {
    const RUN: usize = 6;
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut lost = 0;
    for _ in 0..times {
        let first = rng.next_u32() as usize % (frames.len() - RUN);
        let run = &frames[first..first + RUN];
        let mut bytes = Vec::new();
        // One before the first place of each frame, and one behind the last.
        let mut starts = vec![0];
        for frame in run {
            bytes.extend_from_slice(&frame.bytes);
            starts.push(bytes.len());
        }
        let (from, to) = damage(&mut bytes, &mut rng);
        let accepted = frames::frames(&mut Decoder::new(), &bytes);

        let mut expected = run.iter().map(|frame| &frame.says);
        assert!(accepted.iter().all(|said| expected.any(|sent| sent == said)), "something else, or another order");
        // Whole before the damage, or behind the zero after it.
        let hit = starts.partition_point(|&start| start <= to) - 1;
        let zero_hit = to + 1 == starts[hit + 1];
        for (index, frame) in run.iter().enumerate() {
            let before = starts[index + 1] <= from;
            let behind = index > hit + usize::from(zero_hit);
            assert!(!(before || behind) || accepted.contains(&frame.says), "frame {index}, damage {from} to {to}");
        }
        lost += RUN - accepted.len();
    }
    println!("{times} times damaged: {lost} frames lost");
}

#[test]
fn no_random_damage_of_telemetry_is_taken_for_a_frame() {
    random_damage(&telemetry(), 1_000_000, 1);
}

#[test]
fn no_random_damage_of_commands_is_taken_for_a_frame() {
    random_damage(&orders(), 1_000_000, 2);
}

#[test]
fn noise_is_no_frame_and_costs_none_behind_its_zero() {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(3);
    let frame = &telemetry()[7];
    let mut decoder = Decoder::new();
    for _ in 0..2_000 {
        let noise: Vec<u8> = (0..rng.next_u32() % 3_000).map(|_| rng.next_u32() as u8).collect();
        assert!(frames::frames(&mut decoder, &noise).is_empty());
        assert!(frames::frames(&mut decoder, &[0]).is_empty());
        assert_eq!(frames::frames(&mut decoder, &frame.bytes), std::slice::from_ref(&frame.says));
    }
    assert!(decoder.counters().bad > 0 && decoder.counters().oversize > 0);
}

#[test]
fn what_is_too_long_for_a_receiver_is_counted_and_passed_over() {
    let frames = telemetry();
    let boot = &frames[0];
    let mut decoder = FrameDecoder::<64>::new();
    let mut accepted = 0;
    for frame in &frames[..20] {
        accepted += frame.bytes.iter().filter(|&&byte| decoder.push(byte).is_some()).count();
    }
    let short = frames[..20].iter().filter(|frame| frame.says.2.len() + 7 <= 64).count();
    assert_eq!(boot.says.0, Kind::Boot.number());
    assert_eq!(accepted, short);
    assert_eq!(decoder.counters().oversize as usize, 20 - short);
}

#[test]
fn missing_numbers_are_counted_and_a_boot_begins_anew() {
    let frames = telemetry();
    let mut decoder = Decoder::new();
    for index in [0, 1, 2, 5, 6, 10] {
        frames::frames(&mut decoder, &frames[index].bytes);
    }
    assert_eq!((decoder.counters().lost, decoder.counters().frames), (2 + 3, 6));
    frames::frames(&mut decoder, &frames[0].bytes);
    frames::frames(&mut decoder, &frames[1].bytes);
    assert_eq!((decoder.counters().lost, decoder.counters().restarts), (5, 0));
    frames::frames(&mut decoder, &frames[8].bytes);
    frames::frames(&mut decoder, &frames[4].bytes);
    assert_eq!((decoder.counters().lost, decoder.counters().restarts), (11, 1));
}

/// A boot is also sent for a recording and after a command: what was lost before it is counted.
#[test]
fn a_boot_that_begins_no_program_hides_no_loss() {
    let (mut buffer, mut decoder) = ([0; MAX_FRAME], Decoder::new());
    for (kind, sequence) in [(Kind::Boot, 0), (Kind::Health, 1), (Kind::Boot, 60), (Kind::Health, 61)] {
        let bytes = encode_frame(kind, sequence, &[7; 9], &mut buffer).unwrap();
        frames::frames(&mut decoder, bytes);
    }
    assert_eq!((decoder.counters().lost, decoder.counters().restarts), (58, 0));
    let bytes = encode_frame(Kind::Boot, 0, &[7; 9], &mut buffer).unwrap();
    frames::frames(&mut decoder, bytes);
    assert_eq!((decoder.counters().lost, decoder.counters().restarts), (58, 0), "the program has started anew");
}
