//! A sample with a wrong time stamp.

use super::desk_board::{Desk, fly};
use meerkat_mwd::telemetry::Message;

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
