use crate::rig::files::scenario;

use super::searches::SEEDS;
use meerkat_mwd::config::OptimizerKind;
use testbed::{
    flight::{configuration::of_trace, fly_frozen},
    simulate::{Scenario, simulate},
};

/// Excess over the optimum of the cost at which a window's search ends, by budget: the table of the comparison, printed
/// with `--nocapture`.
#[test]
fn on_a_windows_cost_levenberg_marquardt_is_best_and_imoa_the_best_without_derivatives() {
    const BUDGETS: [u32; 7] = [50, 100, 150, 200, 300, 500, 700];
    let scenario = Scenario { duration_s: 56.0, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, 100);
    let search = |kind: OptimizerKind, budget: u32, seed: u64| {
        let mut config = of_trace(&trace);
        config.identification.optimizer = kind;
        config.identification.max_evaluations = budget;
        config.seed = seed;
        let flight = fly_frozen(&config, trace.first_us() + 51_000_000, &trace.samples).unwrap();
        let report = *flight.reports.first().expect("a window");
        (report.cost_after.unwrap(), report.evaluations)
    };
    let (optimum, evaluations) = search(OptimizerKind::Lm, 700, 0);
    let (start, _) = search(OptimizerKind::Ls, 1, 0);
    println!("cost: least squares (the start) {start:.4}, optimum {optimum:.4}");
    println!("seeds of {SEEDS} within 1 % of the optimum, and median excess over it in % of the start's");
    println!("| evaluations | {} |", BUDGETS.map(|budget| budget.to_string()).join(" | "));
    let kinds = [
        ("imoa", OptimizerKind::Imoa),
        ("imoa-literal", OptimizerKind::ImoaLiteral),
        ("moa", OptimizerKind::Moa),
        ("pso", OptimizerKind::Pso),
        ("de", OptimizerKind::De),
        ("random", OptimizerKind::Random),
    ];
    let mut table = Vec::new();
    for (name, kind) in kinds {
        let cells = BUDGETS.map(|budget| {
            let mut costs: Vec<f32> = (0..SEEDS).map(|seed| search(kind, budget, seed).0).collect();
            costs.sort_by(f32::total_cmp);
            let within = costs.iter().filter(|cost| **cost < 1.01 * optimum).count();
            let median = 100.0 * (costs[costs.len() / 2] - optimum) / (start - optimum);
            (within, median)
        });
        println!("| {name} | {} |", cells.map(|(within, median)| format!("{within} ({median:.1})")).join(" | "));
        table.push(cells);
    }
    println!("| lm | done after {evaluations} evaluations and a normal matrix for each but the first |");
    assert!(evaluations <= 20);
    assert_eq!(table[0][2].0, SEEDS as usize, "IMOA within 150 evaluations from every seed");
    for (column, budget) in BUDGETS.iter().enumerate() {
        let reached = |row: usize| table[row][column].0;
        assert!((1..kinds.len()).all(|row| reached(row) <= reached(0)), "IMOA is not the best at {budget}");
    }
}
