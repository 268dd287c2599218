use super::*;

#[test]
fn without_the_key_nobody_ends_the_recording_of_one_who_has_it() {
    let mut recording = Recording::new();
    assert!(!recording.is_on(0));
    recording.start(1_000_000, Some(10), true);
    recording.start(2_000_000, Some(1), false);
    recording.stop(false);
    assert!(recording.is_on(10_999_999) && !recording.is_on(11_000_000));
    recording.start(3_000_000, None, false);
    assert!(recording.is_on(u64::MAX - 1));
    recording.stop(true);
    assert!(!recording.is_on(3_000_001));
}
