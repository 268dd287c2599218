//! Dead axes, and sensors that are lively or repeat themselves.

use super::*;

const DEAD: u16 = DEAD_READINGS as u16;

/// Returns true if an axis counts as dead after `readings` at `x`, while the other axes change every `hold`
/// readings.
fn is_dead(x: f32, readings: u16, hold: u16, turning: bool) -> bool {
    let mut staleness = Staleness::zero();
    for k in 0..readings {
        let live = f32::from(k / hold) * 0.1 + 1.0;
        staleness.update([live, x, -live], turning);
    }
    staleness.has_dead_axis()
}

#[test]
fn an_axis_that_repeats_itself_is_dead_if_the_probe_turns_or_it_is_zero() {
    assert!(is_dead(0.3, DEAD + 1, 1, true) && !is_dead(0.3, DEAD, 1, true));
    assert!(!is_dead(0.3, 1000, 1, false), "the noise of a good sensor at rest is below its resolution");
    assert!(is_dead(0.0, DEAD, 1, false) && is_dead(-0.0, DEAD, 1, false));
    // A sensor that is read more often than it converts is judged by its new readings only.
    assert!(!is_dead(0.3, DEAD, 5, true) && is_dead(0.3, 5 * DEAD + 5, 5, true));
}

#[test]
fn one_that_changes_is_alive_again() {
    let mut staleness = Staleness::zero();
    let mut is_dead = |reading: [f32; 3], turning| {
        staleness.update(reading, turning);
        staleness.has_dead_axis()
    };
    assert!((0..100_u8).any(|k| is_dead([0.3, f32::from(k), 1.0 + f32::from(k)], true)));
    assert!(is_dead([0.3, 0.1, 0.2], false), "a rest says nothing");
    assert!(!is_dead([0.31, 0.2, 0.3], true));
}

#[test]
fn a_sensor_is_lively_until_its_readings_repeat_themselves_again_and_again() {
    let mut staleness = Staleness::zero();
    let mut next = 0.0;
    let mut fresh = |staleness: &mut Staleness, readings: u16, hold: u16| {
        for k in 0..readings {
            next += if k % hold == 0 { 0.1 } else { 0.0 };
            staleness.update([next, next + 1.0, -next], false);
        }
        staleness.is_lively()
    };
    assert!(!fresh(&mut staleness, 127, 1) && fresh(&mut staleness, 73, 1));
    // One freeze, however long, is not its nature.
    assert!(fresh(&mut staleness, 300, 300) && fresh(&mut staleness, 1, 1));
    // Read three times as often as it converts, it repeats itself by nature.
    assert!(!fresh(&mut staleness, 12, 3));
}

#[test]
fn an_axis_of_zeros_is_dead_where_the_probe_turns_and_not_at_rest() {
    let is_dead = |turning| {
        let mut staleness = Staleness::zero();
        for k in 0..=DEAD {
            staleness.update([f32::from(k), 0.0, -f32::from(k)], turning);
        }
        staleness.has_dead_turning_axis()
    };
    assert!(is_dead(true) && !is_dead(false));
}
