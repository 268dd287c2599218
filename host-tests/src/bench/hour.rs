//! An hour of drilling: does the flown model get better with every window?

use anyhow::Context;
use meerkat_mwd::{compensation::GyroModel, config::Config};

use testbed::study::{
    Cell, Effort, Table,
    cramer_rao::{Bound, Vibration},
    gyro_grade::GyroGrade,
    median_and_worst,
    one_window::{WINDOW_S, scenario},
    rms,
    seeds::each_seed,
};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::systematic_rate_error_rad_s,
    simulate::{Truth, simulate},
    trace::Trace,
};

/// Times at which the model is scored, minutes of the run; the first window's result comes before.
const MINUTES: [u32; 7] = [1, 2, 5, 10, 20, 40, 60];

/// Length of motion after each time on which the model is scored, seconds.
const AHEAD_S: f64 = 60.0;

/// Seeds for which the bound of the whole hour is computed too: it takes minutes and hardly depends on the
/// seed.
const BOUND_SEEDS: u64 = 4;

/// Errors of one seed, deg/s: after the first window, then at each of [`MINUTES`].
struct Trial {
    errors_deg_s: Vec<f64>,
    /// Bound of the last error, from everything read until the window closed whose result flew then.
    bound_deg_s: Option<f64>,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(20);
    GyroGrade::BOTH.into_iter().map(|grade| table(grade, seeds)).collect()
}

fn table(grade: GyroGrade, seeds: u64) -> anyhow::Result<Table> {
    let mut table = Table::new(
        format!(
            "Systematic rate error of what flies during an hour of drilling at 100 Hz, against the true model of the instant, deg/s, \
             median [worst] of {seeds} seeds, the Cramer-Rao bound of {} of them; {}",
            seeds.min(BOUND_SEEDS),
            grade.told()
        ),
        &["minutes", "vertical", "45 deg"],
    );
    let vertical = trials("drilling_vertical", grade, seeds)?;
    let inclined = trials("drilling_45deg", grade, seeds)?;
    let both = [&vertical, &inclined];
    let column = |trials: &Vec<Trial>, index: usize| -> Vec<f64> {
        trials.iter().filter_map(|trial| trial.errors_deg_s.get(index).copied()).collect()
    };
    let names = std::iter::once("first window".to_owned()).chain(MINUTES.iter().map(ToString::to_string));
    for (index, name) in names.enumerate() {
        let cells = both.map(|trials| median_and_worst(&column(trials, index), 4));
        table.row([Cell::from(name)].into_iter().chain(cells));
    }
    let ratios = both.map(|trials| Cell::number(rms(&column(trials, MINUTES.len())) / rms(&column(trials, 0)), 3));
    table.row(
        [Cell::from("rms after the hour over rms after the first window (target: at most 0.3)")]
            .into_iter()
            .chain(ratios),
    );
    let bounds = both.map(|trials| {
        let bounds: Vec<f64> = trials.iter().filter_map(|trial| trial.bound_deg_s).collect();
        Cell::number(rms(&bounds) / rms(&column(trials, 0)), 3)
    });
    table.row(
        [Cell::from("Cramer-Rao bound of the last, of all that was read by then, over rms after the first window")]
            .into_iter()
            .chain(bounds),
    );
    Ok(table)
}

fn trials(name: &str, grade: GyroGrade, seeds: u64) -> anyhow::Result<Vec<Trial>> {
    let mut scenario = scenario(name)?;
    scenario.duration_s = 60.0 * f64::from(MINUTES[MINUTES.len() - 1]) + AHEAD_S + 1.0;
    grade.build_in(&mut scenario);
    each_seed(0..seeds, |seed| {
        let (trace, truth) = simulate(&scenario, seed);
        // Only the identification is measured.
        let mut config = Config { effects: false, ..of_trace(&trace) };
        grade.declare(&mut config);
        let reports = fly(&config, &trace.samples, |_| {})?.reports;
        let first_s = WINDOW_S + f64::from(config.identification.latency_s);
        let instants = std::iter::once(first_s).chain(MINUTES.iter().map(|&minutes| 60.0 * f64::from(minutes)));
        let mut trial = Trial { errors_deg_s: Vec::new(), bound_deg_s: None };
        for t_s in instants {
            let t_us = trace.first_us() + (t_s * 1e6) as u64;
            let landed = reports.iter().rfind(|report| report.t_effect_us.is_some_and(|effect| effect <= t_us));
            let stretch = Stretch::ahead(&config, &trace, &truth, t_us)?;
            trial.errors_deg_s.push(stretch.error_deg_s(&landed.map_or(config.gyro, |report| report.flown))?);
            if seed < BOUND_SEEDS
                && t_s >= 60.0 * f64::from(MINUTES[MINUTES.len() - 1])
                && let Some(report) = landed
            {
                let close = trace.samples.partition_point(|sample| sample.t_us < report.t_end_us);
                let prior = &config.identification;
                let bound = Bound::of_window(&scenario, &trace, &truth, close, prior, Vibration::Coloured.into())
                    .later(&scenario, &stretch.truth, stretch.from - close)
                    .rate_error_rad_s(&stretch.truth, stretch.rates);
                trial.bound_deg_s = Some(bound.to_degrees());
            }
        }
        Ok(trial)
    })
}

/// The stretch of motion on which a model is scored.
struct Stretch<'a> {
    from: usize,
    rates: &'a [[f64; 3]],
    /// The true model at its start.
    truth: GyroModel,
}

impl<'a> Stretch<'a> {
    /// The minute after a time.
    fn ahead(config: &Config, trace: &'a Trace, truth: &Truth, t_us: u64) -> anyhow::Result<Self> {
        let from = trace.samples.partition_point(|sample| sample.t_us < t_us);
        let to = from + (AHEAD_S * 1e6) as usize / config.sample_period_us as usize;
        let rates = trace.true_rate.as_deref().and_then(|rates| rates.get(from..to)).context("the run is too short")?;
        Ok(Self { from, rates, truth: truth.gyro_at(from) })
    }

    fn error_deg_s(&self, model: &GyroModel) -> anyhow::Result<f64> {
        systematic_rate_error_rad_s(&self.truth, model, self.rates)
            .map(f64::to_degrees)
            .context("no rate to score over")
    }
}
