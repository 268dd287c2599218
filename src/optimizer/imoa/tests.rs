//! The search on bowls of known lowest points.

use super::*;
use crate::optimizer::random::normal;

/// Bowl whose lowest point is off the start; in whitened coordinates every window looks like this near
/// its optimum.
struct Bowl {
    lowest: [f32; 12],
    nan: bool,
}

impl Cost<12> for Bowl {
    fn evaluate(&self, x: &[f32; 12]) -> f32 {
        let square: f32 = x.iter().zip(&self.lowest).map(|(a, b)| (a - b) * (a - b)).sum();
        if self.nan && square > 0.5 { f32::NAN } else { 100.0 + 50.0 * square }
    }
}

fn search(settings: &ImoaSettings, seed: u64, nan: bool) -> f32 {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed + 77);
    let cost = Bowl { lowest: [0.0; 12].map(|_: f32| 0.1 * normal(&mut generator)), nan };
    let mut imoa = Imoa::<12, 12>::new(&SearchSpace::UNIT, *settings, seed).unwrap();
    while imoa.step(&cost) == Progress::Running {}
    assert_eq!(imoa.evaluations(), settings.max_evaluations);
    imoa.best().1
}

/// All parabolas of a round bowl have their bottom in one point: the first population and one exchange
/// find it.
#[test]
fn one_exchange_finds_the_bottom_of_a_round_bowl() {
    for seed in 0..60 {
        let found = search(&ImoaSettings::new(12 + 25), seed, false);
        assert!(found < 100.0 + 1e-4, "seed {seed}: {found}");
    }
}

/// Bowl five times as steep along the diagonal: the bottoms of its parabolas together lie 3.75 times too
/// far.
struct Coupled([f32; 12]);

impl Cost<12> for Coupled {
    fn evaluate(&self, x: &[f32; 12]) -> f32 {
        let (mut square, mut sum) = (0.0, 0.0);
        for (a, b) in x.iter().zip(&self.0) {
            square += (a - b) * (a - b);
            sum += a - b;
        }
        100.0 + 50.0 * (square + 4.0 / 12.0 * sum * sum)
    }
}

/// One exchange overshoots here; the step along it and further exchanges still find the bottom.
#[test]
fn variables_that_are_coupled_are_found_too() {
    for seed in 0..60 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed + 77);
        let cost = Coupled([0.0; 12].map(|_: f32| 0.1 * normal(&mut generator)));
        let mut imoa = Imoa::<12, 12>::new(&SearchSpace::UNIT, ImoaSettings::new(300), seed).unwrap();
        while imoa.step(&cost) == Progress::Running {}
        let left = (imoa.best().1 - 100.0) / (cost.evaluate(&[0.0; 12]) - 100.0);
        assert!(left < 0.01, "seed {seed}: {left}");
    }
}

#[test]
fn without_an_exchange_a_bowl_is_searched_to_a_hundredth_in_300_evaluations_from_every_seed() {
    for seed in 0..60 {
        let settings = ImoaSettings { reward: Reward::Off, ..ImoaSettings::new(300) };
        assert!(search(&settings, seed, false) < 101.0, "seed {seed}");
    }
}

#[test]
fn the_papers_other_operators_search_too_and_nan_is_never_taken() {
    for seed in 0..20 {
        for reward in [Reward::Free, Reward::Points, Reward::Values] {
            let all = ImoaSettings { reward, refraction: true, ..ImoaSettings::new(1_000) };
            assert!(search(&all, seed, false) < 102.0, "seed {seed}, {reward:?}");
        }
        assert!(search(&ImoaSettings::new(300), seed, true).is_finite());
    }
}
