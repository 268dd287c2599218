use super::searches::{D, Hole, Nowhere, SEEDS, all};
use meerkat_mwd::optimizer::{Cost, Found, LevenbergMarquardt, Optimizer, Progress, SearchSpace};

#[test]
fn a_region_that_is_not_finite_is_never_entered_and_the_best_never_rises() {
    for seed in 0..SEEDS {
        for (name, mut search) in all(&SearchSpace::UNIT, 1_000, seed) {
            let mut last = f32::INFINITY;
            while search.step(&Hole) == Progress::Running {
                let (x, cost) = search.best();
                assert!(cost <= last, "{name}: {last} rose to {cost}");
                assert!(cost.is_finite() && Hole.evaluate(x) == cost, "{name}: {x:?} {cost}");
                last = cost;
            }
            // A uniform draw falls within the radius once in 400.
            assert!(name == "random" || last < 2.0, "{name}, seed {seed}: nothing better than the start");
        }
    }
}

#[test]
fn a_cost_that_is_nowhere_finite_leaves_the_start() {
    let space = SearchSpace::about([0.25; D], 0.1, [-1.0; D], [1.0; D]).unwrap();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for (name, mut search) in all(&space, 500, 1) {
            assert_eq!(search.run(&Nowhere(value), 600), Progress::Done, "{name}");
            assert_eq!(search.best(), (&[0.25; D], f32::INFINITY), "{name}");
        }
        let mut lm = LevenbergMarquardt::<D, 10>::new([0.25; D], 500);
        assert_eq!(lm.run(&Nowhere(value), 600), Progress::Done);
        assert_eq!(lm.best(), (&[0.25; D], f32::INFINITY));
    }
    // A finite cost with a singular matrix: no damping helps.
    let mut lm = LevenbergMarquardt::<D, 10>::new([0.25; D], 500);
    assert_eq!(lm.run(&Nowhere(1.0), 600), Progress::Done);
    assert_eq!((lm.best(), lm.evaluations()), ((&[0.25; D], 1.0), 1));
}
