//! Coverage of the reported deviations: how often the truth lies within 1.96 of them.

use meerkat_mwd::{compensation::GyroModel, config::OptimizerKind};

use testbed::study::{
    Cell, Effort, Table,
    one_window::{Run, WINDOW_S, scenario},
    rms,
    seeds::each_seed,
};

/// Number of deviations within which 95 % of a normal distribution lie.
const DEVIATIONS: f64 = 1.96;

const NAMES: [&str; 12] = ["p11", "p12", "p13", "p21", "p22", "p23", "p31", "p32", "p33", "bx", "by", "bz"];

/// Error over reported deviation of each parameter that the report calls observable.
type Trial = [Option<f64>; 12];

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(500);
    let scenarios = ["drilling_vertical", "drilling_45deg"].map(scenario);
    let [vertical, inclined] = scenarios;
    // Only the fit is scored: nothing has to follow the window.
    let scenarios = [vertical?, inclined?].map(|mut scenario| {
        scenario.duration_s = WINDOW_S + 6.0;
        scenario
    });
    let trials = each_seed(0..seeds, |seed| trial(&Run::simulate(&scenarios[usize::from(seed % 2 == 1)], seed)?))?;
    let mut table = Table::new(
        format!(
            "Share of {seeds} windows (half vertical, half at 45 deg) in which |fitted - true| is at most {DEVIATIONS} reported \
             deviations, % (target: 93 to 97); b is the true one at the end of the window"
        ),
        &["parameter", "all", "vertical", "45 deg", "observable, %", "rms of error over deviation"],
    );
    for (index, name) in NAMES.iter().enumerate() {
        table.row([Cell::from(*name)].into_iter().chain(cells(&trials, index..index + 1)));
    }
    table.row([Cell::from("P")].into_iter().chain(cells(&trials, 0..9)));
    table.row([Cell::from("b")].into_iter().chain(cells(&trials, 9..12)));
    table.row([Cell::from("all")].into_iter().chain(cells(&trials, 0..12)));
    Ok(vec![table])
}

fn trial(run: &Run) -> anyhow::Result<Trial> {
    let report = run.identify(OptimizerKind::Imoa)?;
    let truth = parameters(&run.truth.gyro_at(run.close));
    let fitted = parameters(&report.fitted);
    // Without a fit no deviation is reported.
    let exists = report.cost_after.is_some();
    Ok(std::array::from_fn(|i| {
        (exists && report.observable[i]).then(|| (fitted[i] - truth[i]) / f64::from(report.sigma[i]))
    }))
}

/// P row-major, then b.
fn parameters(model: &GyroModel) -> [f64; 12] {
    let mut values = model.p.iter().flatten().chain(&model.b_rad_s).copied();
    std::array::from_fn(|_| values.next().map_or(f64::NAN, f64::from))
}

/// Coverage over all, vertical and inclined windows, share of observable parameters, and rms of the scaled
/// errors.
fn cells(trials: &[Trial], parameters: std::ops::Range<usize>) -> [Cell; 5] {
    let errors = |first: usize, step: usize| -> Vec<f64> {
        let windows = trials.iter().skip(first).step_by(step);
        windows.flat_map(|trial| trial.get(parameters.clone()).unwrap_or_default()).copied().flatten().collect()
    };
    let covered = |errors: &[f64]| {
        Cell::percent(errors.iter().filter(|e| e.abs() <= DEVIATIONS).count() as f64 / errors.len() as f64, 1)
    };
    let all = errors(0, 1);
    let scaled = rms(&all);
    let observable = all.len() as f64 / (trials.len() * parameters.len()) as f64;
    [
        covered(&all),
        covered(&errors(0, 2)),
        covered(&errors(1, 2)),
        Cell::percent(observable, 1),
        Cell::number(scaled, 2),
    ]
}
