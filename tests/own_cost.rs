//! The example of a cost of one's own is compiled and run, and finds what it generated.
#![allow(clippy::unwrap_used, missing_docs)]

// Its `main` and what it prints belong to the example.
#[allow(dead_code)]
#[path = "../examples/own_cost.rs"]
mod example;

#[test]
fn the_damped_oscillation_is_found_within_its_noise() {
    example::main().unwrap();
    let found = example::fit().unwrap();
    // Deviations by Cramer-Rao are 0.006 to 0.01: four of them.
    for (found, expected) in found.iter().zip(&example::TRUE) {
        assert!((found - expected).abs() < 0.04, "{found} for {expected}");
    }
}
