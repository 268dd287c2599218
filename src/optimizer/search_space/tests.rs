use super::*;

#[test]
fn bounds_that_are_no_box_are_named() {
    use OptimizerError::{BoundsReversed, Deviation, NoDimensions, NotFinite, StartOutside};
    assert_eq!(SearchSpace::within([0.0, 1.0], [1.0, 0.0]), Err(BoundsReversed { dimension: 1 }));
    assert_eq!(SearchSpace::within([2.0], [2.0]), Err(BoundsReversed { dimension: 0 }));
    assert_eq!(SearchSpace::within([f32::NAN], [2.0]), Err(NotFinite { dimension: 0 }));
    assert_eq!(SearchSpace::within([f32::MIN], [f32::MAX]), Err(NotFinite { dimension: 0 }));
    assert_eq!(SearchSpace::within([], []), Err(NoDimensions));
    assert_eq!(SearchSpace::about([3.0], 0.1, [0.0], [1.0]), Err(StartOutside { dimension: 0 }));
    assert_eq!(SearchSpace::about([f32::NAN], 0.1, [0.0], [1.0]), Err(NotFinite { dimension: 0 }));
    for deviation in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(SearchSpace::about([0.5], deviation, [0.0], [1.0]), Err(Deviation));
    }
}

#[test]
fn whatever_leaves_the_box_comes_back() {
    use rand_core::SeedableRng;
    let space = SearchSpace::within([-1.0; 4], [2.0; 4]).unwrap();
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5];
    let mut confined = wild;
    space.confine(&mut confined);
    assert_eq!(confined, [-1.0, 2.0, -1.0, 0.5]);
    let mut redrawn = wild;
    space.redraw(&mut redrawn, &mut Xoshiro128PlusPlus::seed_from_u64(1));
    assert!(redrawn.iter().all(|x| (-1.0..=2.0).contains(x)) && redrawn[3] == 0.5);
}
