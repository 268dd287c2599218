//! Contaminated windows without a magnetometer.

use super::{
    drilled::{Drilled, in_parallel},
    effort::Spent,
    graduated::{Schedule, graduated, reweighted},
    levenberg_marquardt::levenberg_marquardt,
    loss::{HUBER, Loss, TUKEY},
    population::{Search, search_about},
    prior::Prior,
    readings::{Theta, identity},
    window::{Answer, Window, segment_cost},
};
use testbed::{
    simulate::Contamination,
    study::{Table, median_and_worst},
};

/// The kinds that gravity and the gyro can be hit by.
const KINDS: [(Contamination, &str); 4] = [
    (Contamination::ShockTrains, "shock trains"),
    (Contamination::GyroClipping, "gyro clipped"),
    (Contamination::VectorClipping, "accel clipped (half of the seeds)"),
    (Contamination::GyroBursts, "gyro bursts"),
];

fn huber(window: &Window<'_>) -> Answer {
    let mut spent = Spent::default();
    let problem = window.weak_form(false);
    let start = problem.unweighted(&mut spent);
    Answer { theta: reweighted(&problem, Loss::Huber(HUBER), start, 8, &mut spent), spent }
}

fn recipe(window: &Window<'_>) -> Answer {
    let mut spent = Spent::default();
    Answer { theta: graduated(&window.weak_form(false), Schedule::POLISHED, &mut spent), spent }
}

fn searched(window: &Window<'_>, search: Search) -> Answer {
    let Answer { theta, mut spent } = huber(window);
    let problem = window.weak_form(false);
    let (normal, _) = problem.normal(&vec![1.0; problem.equations.len()]);
    let cost = |delta: &Theta| problem.cost(Loss::Tukey(TUKEY), &(theta + delta));
    let found = search_about(search, &cost, normal, 10.0, (2_000, window.seed), &mut spent);
    Answer { theta: reweighted(&problem, Loss::Tukey(TUKEY), theta + found, 6, &mut spent), spent }
}

/// Segments at the factory's rates.
fn lm(window: &Window<'_>, loss: Loss) -> Answer {
    let mut segments = window.segments(&identity());
    segments.sightings.retain(|s| s.sensor == 0);
    let mut spent = Spent::default();
    let cost = segment_cost(&segments, window.prior, loss);
    let delta = levenberg_marquardt(&cost, Theta::zeros(), 30, &mut spent);
    Answer { theta: identity() + delta, spent }
}

type Run = fn(&Window<'_>) -> Answer;

/// Share of the fits that are better than the raw gyro.
pub(super) fn table(runs: &[Drilled]) -> Table {
    let title = "No magnetometer: error under that of the raw gyro, % (10 to 50 % hit); error over the raw gyro's, median [worst]".to_owned();
    let mut columns = vec!["method", "cost"];
    columns.extend(KINDS.map(|(_, head)| head));
    columns.extend(["not hit", "not hit, vertical: over raw", "not hit, 45 deg: over raw", "hit: over raw"]);
    let methods: [(&str, Run); 7] = [
        ("LS Huber", huber),
        ("LM Huber on segments", |w| lm(w, Loss::Huber(HUBER))),
        ("LM Tukey on segments", |w| lm(w, Loss::Tukey(TUKEY))),
        ("LS-GNC (c 2), Tukey", recipe),
        ("IMOA 2000 about LS Huber, Tukey", |w| searched(w, Search::Imoa)),
        ("PSO 2000 about LS Huber, Tukey", |w| searched(w, Search::Pso)),
        ("DE 2000 about LS Huber, Tukey", |w| searched(w, Search::DifferentialEvolution)),
    ];
    let prior = Prior::data_sheet();
    // The last column is the clean window.
    let outcomes = in_parallel(runs.len(), |index| {
        let run = &runs[index];
        let raw = run.error_rad_s(&prior.mean);
        let kinds = KINDS.iter().map(|(kind, _)| Some(*kind)).chain([None]);
        let windows: Vec<Window<'_>> = kinds
            .map(|kind| {
                let mut window = Window::new(run.readings(kind, run.share()), &prior, run.seed);
                window.equations.retain(|e| e.sensor == 0);
                window
            })
            .collect();
        methods.map(|(_, method)| {
            let found = windows.iter().map(|window| {
                let answer = method(window);
                (run.error_rad_s(&answer.theta) / raw, answer.spent.total())
            });
            found.collect::<Vec<_>>()
        })
    });
    let mut table = Table::new(title, &columns);
    for (row, (name, _)) in methods.iter().enumerate() {
        let of = |column: usize| outcomes.iter().map(move |o| o[row][column].0);
        let better = |column: usize| {
            let count = of(column).filter(|ratio| *ratio < 1.0).count();
            format!("{:.1}", 100.0 * count as f64 / outcomes.len() as f64)
        };
        let mut costs: Vec<u32> = outcomes.iter().flat_map(|o| o[row].iter().map(|f| f.1)).collect();
        costs.sort_unstable();
        let mut cells = vec![(*name).to_owned(), costs[costs.len() / 2].to_string()];
        cells.extend((0..=KINDS.len()).map(better));
        let clean: Vec<f64> = of(KINDS.len()).collect();
        let every_other = |first: usize| clean.iter().copied().skip(first).step_by(2).collect::<Vec<_>>();
        cells.extend([0, 1].map(|k| median_and_worst(&every_other(k), 2).text));
        cells.push(median_and_worst(&(0..KINDS.len()).flat_map(of).collect::<Vec<_>>(), 2).text);
        table.row(cells);
    }
    table
}
