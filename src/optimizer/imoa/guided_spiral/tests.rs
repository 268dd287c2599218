use super::*;
use crate::optimizer::SearchSpace;
use rand_core::SeedableRng;

/// The member stands at 0, the best one at 0.5. Returns the least and the largest move towards the best in many
/// draws, as shares of their distance.
fn way(own: f32, lowest: f32) -> (f32, f32) {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(4);
    let mut population = Population::<3, 2>::new(&SearchSpace::UNIT, 1, &mut generator).unwrap();
    population.replace(0, [0.0; 3], own);
    population.replace(1, [0.5; 3], lowest);
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for _ in 0..5_000 {
        for x in guided_spiral(&population, 0, &mut generator) {
            (least, most) = (if x < least { x } else { least }, if x > most { x } else { most });
        }
    }
    (least / 0.5, most / 0.5)
}

#[test]
fn a_good_member_goes_to_the_best_and_a_bad_one_around() {
    let near = |(least, most): (f32, f32), expected: (f32, f32)| {
        assert!((least - expected.0).abs() < 0.02 && (most - expected.1).abs() < 0.02, "{least} {most}");
    };
    // b = 1: up to twice the distance, no spiral. b = 0: the spiral alone, as wide as the distance.
    near(way(10.0, 9.999_999), (0.0, 2.0));
    near(way(f32::INFINITY, 9.0), (-1.0, 1.0));
    near(way(f32::MAX, 9.0), (-1.0, 1.0));
    // b = 1/2: up to once the distance, and a spiral of e^(1/2) / 4 of it.
    near(way(18.0, 9.0), (-0.412, 1.412));
    // Costs that are not positive have no meaningful ratio: b = 0.
    near(way(-1.0, -2.0), (-1.0, 1.0));
}
