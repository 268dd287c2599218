//! Benefit of one window of drilling over the six minutes after it.

use meerkat_mwd::{
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};

use testbed::study::{
    Cell, Effort, Table,
    cramer_rao::{Known, Vibration},
    median_and_worst,
    one_window::{CALIBRATED, Run, scenario},
    rms,
    seeds::each_seed,
};

/// Searches, with their names.
const SEARCHES: [(OptimizerKind, &str); 3] =
    [(OptimizerKind::Imoa, "IMOA"), (OptimizerKind::Lm, "Levenberg-Marquardt"), (OptimizerKind::Ls, "least squares")];

/// The figures of one seed, deg/s.
struct Trial {
    raw: f64,
    bias_only: f64,
    flown: f64,
    accepted: bool,
    fitted: [f64; SEARCHES.len()],
    calibrated: f64,
    bound: f64,
    bound_white: f64,
    bound_of_data_sheet: f64,
    bound_of_calibrated: f64,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(200);
    let mut table = Table::new(
        format!(
            "Systematic rate error over 6 minutes after one 50 s window at 100 Hz, deg/s, median [worst] of {seeds} seeds"
        ),
        &["", "vertical", "45 deg"],
    );
    let vertical = trials("drilling_vertical", seeds)?;
    let inclined = trials("drilling_45deg", seeds)?;
    let both = [&vertical, &inclined];
    let mut row = |name: &str, figure: &dyn Fn(&Trial) -> f64| {
        let cells = both.map(|trials| median_and_worst(&trials.iter().map(figure).collect::<Vec<_>>(), 4));
        table.row([Cell::from(name)].into_iter().chain(cells));
    };
    row("raw", &|t| t.raw);
    row("bias only", &|t| t.bias_only);
    for (index, (_, name)) in SEARCHES.iter().enumerate() {
        row(name, &|t| t.fitted[index]);
    }
    row("flown (IMOA)", &|t| t.flown);
    row("flown, accelerometer and magnetometer declared to be calibrated", &|t| t.calibrated);
    row("Cramer-Rao bound", &|t| t.bound);
    row("Cramer-Rao bound, vibration taken as white", &|t| t.bound_white);
    row("Cramer-Rao bound, mean over vector sensors as data sheets allow", &|t| t.bound_of_data_sheet);
    row("the same, as declared to be calibrated", &|t| t.bound_of_calibrated);
    let of = |trials: &Vec<Trial>, figure: &dyn Fn(&Trial) -> f64| rms(&trials.iter().map(figure).collect::<Vec<_>>());
    let mut ratio = |name: &str, figure: &dyn Fn(&Trial) -> f64, bound: &dyn Fn(&Trial) -> f64| {
        let cells = both.map(|trials| Cell::number(of(trials, figure) / of(trials, bound), 3));
        table.row([Cell::from(name)].into_iter().chain(cells));
    };
    ratio("rms of IMOA over rms of the bound (target: at most 1.10)", &|t| t.fitted[0], &|t| t.bound);
    ratio("the same, vibration taken as white", &|t| t.fitted[0], &|t| t.bound_white);
    ratio("declared to be calibrated, over the same", &|t| t.calibrated, &|t| t.bound_white);
    ratio("rms of Levenberg-Marquardt over rms of the bound", &|t| t.fitted[1], &|t| t.bound);
    let accepted =
        both.map(|trials| Cell::percent(trials.iter().filter(|t| t.accepted).count() as f64 / seeds as f64, 1));
    table.row([Cell::from("accepted, %")].into_iter().chain(accepted));
    Ok(vec![table])
}

fn trials(name: &str, seeds: u64) -> anyhow::Result<Vec<Trial>> {
    let scenario = scenario(name)?;
    each_seed(0..seeds, |seed| {
        let mut run = Run::simulate(&scenario, seed)?;
        let mut reports = Vec::<WindowReport>::new();
        for (optimizer, _) in SEARCHES {
            reports.push(run.identify(optimizer)?);
        }
        let mut fitted = [f64::NAN; SEARCHES.len()];
        for (error, report) in fitted.iter_mut().zip(&reports) {
            *error = run.rate_error_deg_s(&report.fitted)?;
        }
        let bound_of_data_sheet = run.bound_deg_s(Known { vibration: Vibration::White, vectors: false });
        run.config.identification.vector_errors = CALIBRATED;
        let calibrated = run.rate_error_deg_s(&run.identify(SEARCHES[0].0)?.flown)?;
        Ok(Trial {
            calibrated,
            raw: run.rate_error_deg_s(&GyroModel::IDENTITY)?,
            bias_only: run.rate_error_deg_s(&reports[0].bias_only)?,
            flown: run.rate_error_deg_s(&reports[0].flown)?,
            accepted: reports[0].decision == Decision::Accepted,
            fitted,
            bound: run.bound_deg_s(Vibration::Coloured),
            bound_white: run.bound_deg_s(Vibration::White),
            bound_of_data_sheet,
            bound_of_calibrated: run.bound_deg_s(Known { vibration: Vibration::White, vectors: false }),
        })
    })
}
