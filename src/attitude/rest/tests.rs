use super::*;

#[test]
fn rest_begins_after_quiet_and_ends_at_once() {
    let mut rest = RestTracker::new();
    let (bias, gravity) = (Vector3::new(0.01, 0.0, -0.01), Vector3::new(0.0, 0.0, -9.8));
    for _ in 0..299 {
        rest.update(&bias, Some(&gravity), 0.005);
    }
    assert!(!rest.detected());
    (0..3).for_each(|_| rest.update(&bias, Some(&gravity), 0.005));
    assert!(rest.detected());
    rest.update(&(bias + Vector3::new(0.1, 0.0, 0.0)), Some(&gravity), 0.005);
    assert!(!rest.detected());
}

#[test]
fn turning_slowly_but_visibly_is_no_rest_nor_is_silence() {
    let mut rest = RestTracker::new();
    for _ in 0..2_000 {
        rest.update(&Vector3::new(0.0, 0.0, 0.06), Some(&Vector3::new(0.0, 0.0, -9.8)), 0.005);
        assert!(!rest.detected());
    }
    let mut rest = RestTracker::new();
    (0..2_000).for_each(|_| rest.update(&Vector3::zeros(), None, 0.005));
    assert!(!rest.detected());
}
