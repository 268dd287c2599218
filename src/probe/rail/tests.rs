use super::*;

#[test]
fn ten_repeats_of_the_largest_reading_are_a_rail_and_no_others() {
    let mut rail = Rail::zero();
    let seen = (0..15).filter(|_| rail.update(-4.0)).count();
    assert_eq!(seen, 5, "the first and nine repeats are not yet one");
    assert!(!rail.update(3.9), "below it");
    assert!(!rail.update(4.1), "beyond it: it was none");
    assert!(!rail.update(4.0));
    let mut slow = Rail::zero();
    assert!((0..100).all(|_| !slow.update(1.9)), "no gyro's rail is so low");
}
