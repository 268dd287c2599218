use super::*;

#[test]
fn bursts_pass_and_what_contradicts_again_and_again_is_for_good() {
    let mut burst = Disagreement::<f64>::zero();
    for _ in 0..20 {
        assert!((0..10).all(|_| !burst.contradicted(0.5)));
        (0..11).for_each(|_| burst.agreed(0.5));
    }
    // A change: contradicted, aligned anew for a second, two nodes of agreement.
    let mut change = Disagreement::<f64>::zero();
    let found = (0..20).position(|_| {
        let is_for_good = change.contradicted(0.5);
        change.passed(1.0);
        (0..2).for_each(|_| change.agreed(0.5));
        is_for_good
    });
    assert_eq!(found, Some(8), "of 2.5 s each");
}
#[test]
fn readings_that_are_missing_now_and_then_end_no_contradiction() {
    let found = |missing: usize| {
        let mut all = Disagreements::<f64>::zero();
        let of = |k: usize| if k.is_multiple_of(missing + 1) { Readings::Contradicted } else { Readings::Missing };
        let agreement = |field| Agreement { field, force: Readings::Used, is_turned: false, innovation: None };
        (0..60).filter(|k| all.for_good(&agreement(of(*k)), 0.5)[0]).count()
    };
    assert_eq!((found(1), found(11)), (1, 0));
}
