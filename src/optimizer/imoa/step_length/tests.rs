use super::*;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn the_step_is_the_spread_lengthened_by_disturbance_and_held_to_the_first_populations() {
    // Half widths 1 and 100: units do not matter.
    let space = SearchSpace::about([0.0; 2], 0.1, [-1.0, -100.0], [1.0, 100.0]).unwrap();
    let mut population = Population::<2, 2>::new(&space, 1, &mut Xoshiro128PlusPlus::seed_from_u64(1)).unwrap();
    population.replace(0, [0.0, 0.0], 1.0);
    let step = |population: &Population<2, 2>, disturbance| step_length(&space, population, disturbance);
    // sqrt((0.06^2 + 0.08^2) / 2)
    population.replace(1, [0.06, 8.0], 2.0);
    let spread = 0.070_711;
    for (disturbance, times) in [(0.0, 1.0), (0.25, 1.25), (1.0, 2.0), (1e30, 2.0)] {
        assert!((step(&population, disturbance) - times * spread).abs() < 1e-5, "{disturbance}");
    }
    population.replace(1, [0.9, -90.0], 2.0);
    assert_eq!(step(&population, 0.0), 0.2);
    population.replace(1, [0.001, 0.0], 2.0);
    assert_eq!(step(&population, 1.0), 0.05);
    population.replace(1, [0.0, 0.0], 1.0);
    assert_eq!(step(&population, 1.0), 0.05);
    let wide = SearchSpace::within([-1.0; 2], [1.0; 2]).unwrap();
    population.replace(1, [1.0, -1.0], 2.0);
    assert_eq!(step_length(&wide, &population, 0.0), 0.5);
}
