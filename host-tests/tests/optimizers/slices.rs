use super::searches::{Bowl, D, all, lowest};
use meerkat_mwd::optimizer::{
    Cost, Imoa, ImoaLiteral, ImoaLiteralSettings, ImoaSettings, Moa, MoaSettings, Optimizer, Progress, Pso,
    PsoSettings, Reward, SearchSpace,
};
use proptest::prelude::*;

#[test]
fn populations_of_one_and_no_evaluations_are_searches_too() {
    let bowl = Bowl(lowest(3));
    let space = SearchSpace::UNIT;
    let mut alone: Vec<Box<dyn Optimizer<Bowl, D>>> = vec![
        Box::new(Imoa::<D, 1>::new(&space, ImoaSettings::new(50), 1).unwrap()),
        Box::new(
            Imoa::<D, 1>::new(&space, ImoaSettings { reward: Reward::Points, ..ImoaSettings::new(50) }, 1).unwrap(),
        ),
        Box::new(ImoaLiteral::<D, 1>::new(&space, ImoaLiteralSettings::new(50), 1).unwrap()),
        Box::new(Moa::<D, 1>::new(&space, MoaSettings::new(50), 1).unwrap()),
        Box::new(Pso::<D, 1>::new(&space, PsoSettings::new(50), 1).unwrap()),
    ];
    for search in &mut alone {
        assert_eq!(search.run(&bowl, 51), Progress::Done);
        assert!(search.best().1 <= bowl.evaluate(&[0.0; D]));
    }
    for (name, mut search) in all(&space, 0, 1) {
        assert_eq!(search.run(&bowl, 1), Progress::Done, "{name}");
        assert_eq!(search.best(), (&[0.0; D], f32::INFINITY), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_same_seed_gives_the_same_result_however_it_is_sliced(
        seed: u64,
        slices in proptest::collection::vec(1_u32..70, 1..20),
        low in -50.0_f32..0.0,
        width in 1.0_f32..200.0,
    ) {
        let bowl = Bowl(lowest(seed % 20).map(|x| low + width * (0.5 + 0.5 * x)));
        let space = SearchSpace::within([low; D], [low + width; D]).unwrap();
        for ((name, mut whole), (_, mut sliced)) in all(&space, 400, seed).into_iter().zip(all(&space, 400, seed)) {
            whole.run(&bowl, u32::MAX);
            for slice in slices.iter().cycle() {
                if sliced.run(&bowl, *slice) == Progress::Done {
                    break;
                }
            }
            prop_assert_eq!(whole.best(), sliced.best(), "{}", name);
            prop_assert_eq!(whole.evaluations(), sliced.evaluations());
            prop_assert!(whole.best().0.iter().all(|x| (low..=low + width).contains(x)));
        }
    }
}
