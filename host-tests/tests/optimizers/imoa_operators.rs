use super::searches::{Bowl, D, Hole, Nowhere, lowest};
use meerkat_mwd::optimizer::{Cost, Found, Imoa, ImoaSettings, Optimizer, Progress, Reward, SearchSpace};

/// Every way to switch IMOA's operators, on costs that are finite, nowhere finite, and finite in part: the
/// box is kept, NaN is never taken, and every step costs at most one evaluation.
#[test]
fn every_combination_of_imoas_operators_keeps_the_promises() {
    let space = SearchSpace::about([0.9; D], 0.6, [-1.0; D], [1.0; D]).unwrap();
    let bowl = Bowl(lowest(5));
    let switches = [false, true];
    for reward in [Reward::Off, Reward::Free, Reward::Points, Reward::Values] {
        for (adaptive_step, refraction) in switches.into_iter().flat_map(|a| switches.map(|r| (a, r))) {
            for (spiral, migration) in [(true, false), (false, true), (true, true)] {
                let settings = ImoaSettings {
                    disturbance: 1e30,
                    adaptive_step,
                    spiral,
                    reward,
                    migration,
                    refraction,
                    ..ImoaSettings::new(400)
                };
                let mut search = Imoa::<D, 5>::new(&space, settings, 1).unwrap();
                let mut steps = 0;
                while search.step(&bowl) == Progress::Running {
                    steps += 1;
                    assert_eq!(search.evaluations(), steps);
                }
                assert_eq!(steps, 400);
                let excess = search.best().1 - 1.0;
                assert!(excess < 0.5 * (bowl.evaluate(&[0.9; D]) - 1.0), "{settings:?}: {excess}");
                let mut search = Imoa::<D, 5>::new(&space, settings, 1).unwrap();
                // Not one point of this start's surroundings is finite.
                assert_eq!(search.run(&Nowhere(f32::NAN), 500), Progress::Done);
                assert_eq!(search.best(), (&[0.9; D], f32::INFINITY));
                let mut search = Imoa::<D, 5>::new(&SearchSpace::UNIT, settings, 1).unwrap();
                search.run(&Hole, 500);
                assert!(search.best().1.is_finite());
            }
        }
    }
}
