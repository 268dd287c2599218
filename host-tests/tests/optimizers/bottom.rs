use super::searches::{Bowl, D, N, SEEDS, all, lowest};
use meerkat_mwd::optimizer::{Cost, Found, Imoa, ImoaSettings, LevenbergMarquardt, Optimizer, Reward, SearchSpace};

#[test]
fn every_population_search_finds_the_bottom_of_a_bowl() {
    for seed in 0..SEEDS {
        let bowl = Bowl(lowest(seed));
        for (name, mut search) in all(&SearchSpace::UNIT, 20_000, seed) {
            search.run(&bowl, u32::MAX);
            assert_eq!(search.evaluations(), 20_000);
            // Squared distance; 0.02 to 0.6 at the start. With the published methods the members never stop
            // jumping, and IMOA as printed is drawn to the origin; random search is as dense as its draws.
            let tolerance = match name {
                "imoa" | "imoa, all operators" | "pso" => 1e-5,
                // Differences that die out early stop it short with some seeds.
                "imoa, free reward" | "imoa, points" | "de" => 1e-3,
                "imoa-literal" => 0.25,
                _ => 0.05,
            };
            let excess = search.best().1 - 1.0;
            assert!(excess < tolerance, "{name}, seed {seed}: {excess}");
        }
        let mut lm = LevenbergMarquardt::<D, 10>::new([0.0; D], 20);
        lm.run(&bowl, u32::MAX);
        assert!(lm.best().1 - 1.0 < 1e-5, "seed {seed}");
    }
}

/// A bowl with ripples: 81 minima; the lowest, of cost 1, at the given point, the next of 1.9.
struct Ripples([f32; D]);

impl Cost<D> for Ripples {
    fn evaluate(&self, x: &[f32; D]) -> f32 {
        let ripple = |d: f32| d * d + 0.5 * (1.0 - libm::cosf(core::f32::consts::TAU * d));
        1.0 + x.iter().zip(&self.0).map(|(x, lowest)| ripple(x - lowest)).sum::<f32>()
    }
}

/// The population's purpose: exchanges alone stay in the nearest minimum, and without them moves often miss
/// the lowest.
#[test]
fn imoa_finds_the_lowest_of_many_minima_and_needs_its_population_for_it() {
    let space = SearchSpace::within([-3.0; D], [3.0; D]).unwrap();
    let [mut whole, mut alone, mut moves] = [0; 3];
    for seed in 0..SEEDS {
        let cost = Ripples(lowest(seed).map(|x| 1.5 * x));
        let settings = ImoaSettings::new(2_000);
        let found = |mut search: Box<dyn Optimizer<Ripples, D>>| {
            search.run(&cost, u32::MAX);
            u64::from(search.best().1 < 1.05)
        };
        whole += found(Box::new(Imoa::<D, N>::new(&space, settings, seed).unwrap()));
        alone += found(Box::new(Imoa::<D, 1>::new(&space, settings, seed).unwrap()));
        let without = ImoaSettings { reward: Reward::Off, ..settings };
        moves += found(Box::new(Imoa::<D, N>::new(&space, without, seed).unwrap()));
    }
    println!("of {SEEDS}: {whole}, with one member {alone}, without the exchange {moves}");
    assert!(whole == SEEDS && alone < SEEDS / 2 && moves < SEEDS);
}
