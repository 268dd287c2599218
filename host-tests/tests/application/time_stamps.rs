//! A sample with a wrong time stamp.

use super::desk_board::{Desk, fly};
use meerkat_mwd::{Config, Probe, telemetry::Message};
use std::{cell::RefCell, rc::Rc};

/// Time of the sample whose stamp is wrong, microseconds.
const WRONG_US: u64 = 5_000_000;

#[test]
fn one_stamp_an_hour_ahead_silences_no_attitude() {
    let stamp = |us| us + if us == WRONG_US { 3_600_000_000 } else { 0 };
    let seen = fly(Desk { stamp, ..Desk::default() }, 10);
    let attitudes: Vec<u64> = seen
        .messages
        .iter()
        .filter_map(|(_, message)| if let Message::Attitude(attitude) = message { Some(attitude.t_us) } else { None })
        .collect();
    let late = attitudes.iter().filter(|us| **us > WRONG_US).count();
    println!("{} attitudes, {late} of them after the wrong stamp", attitudes.len());
    // One in 20 of 1,000 samples goes over the line; the first and the last may still wait.
    assert!(late >= 48 && attitudes.windows(2).all(|pair| pair[1] - pair[0] <= 200_000), "{attitudes:?}");
}

/// The boot names the sample with which the pipeline starts afresh, not the one after it: a replay begins there.
#[test]
fn after_a_step_back_the_first_sample_is_the_one_that_starts_afresh() {
    let stamp = |us| us + if us < WRONG_US { 3_600_000_000 } else { 0 };
    let read = Rc::new(RefCell::new(Vec::new()));
    let samples = Rc::clone(&read);
    let reads = move |sample| {
        samples.borrow_mut().push(sample);
        sample
    };
    let desk = Desk { stamp, reads: Box::new(reads), ..Desk::default() };
    let config = Config { sample_period_us: desk.period_us as u32, ..Config::default() };
    let seen = fly(desk, 10);
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    let afresh = read.borrow().iter().position(|sample| probe.push(sample).is_some() && probe.began_afresh()).unwrap();
    let boots: Vec<u32> = seen
        .messages
        .iter()
        .filter_map(|(_, message)| if let Message::Boot(boot) = message { Some(boot.first_sample) } else { None })
        .collect();
    assert_eq!(boots, [0, afresh as u32]);
}

/// A part that is polled is stamped half a period before: its attitudes are not late for that.
#[test]
fn a_polled_part_makes_no_attitude_late() {
    let seen = fly(Desk { stamp: |us| us - 2_500, ..Desk::default() }, 10);
    let health = seen.messages.iter().rev().find_map(|(_, message)| match message {
        Message::Health(health) => Some(*health),
        _ => None,
    });
    let health = health.unwrap();
    assert!(health.counters.samples > 900, "{health:?}");
    assert_eq!(health.late_attitudes, 0);
    assert!(health.worst_delay_us < 2_000, "{}", health.worst_delay_us);
}
