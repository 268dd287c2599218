//! Six minutes of the gyro alone with the model of one window.

use anyhow::Context;

use super::{
    contenders::{AT_BOUND, Contenders, IMOA, NAMES, TRUE},
    pure_integration::Drift,
};
use testbed::study::{
    Effort,
    gyro_grade::GyroGrade,
    one_window::{Run, scenario},
    seeds::each_seed,
    {Cell, Table, median, median_and_worst, rms},
};

/// Latitude that the scenarios do not state, degrees; a dip of 65 deg belongs to about this one.
const LATITUDE_DEG: f64 = 50.0;

/// Drifts of one seed, in the order of [`NAMES`].
type Trial = Vec<Drift>;

/// Picks one angle of a drift.
type Angle = fn(&Drift) -> &Vec<f64>;

/// Drifts of both grades of the gyro, in a vertical hole and at 45 deg.
///
/// # Errors
/// A scenario cannot be read or flown.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(20);
    let mut tables = Vec::new();
    for grade in GyroGrade::BOTH {
        let both = [trials("drilling_vertical", grade, seeds)?, trials("drilling_45deg", grade, seeds)?];
        let inclination = "targets: IMOA at most 1.15 of the true parameters, worst point under 1.5";
        tables.push(table("inclination", inclination, grade, &both, |d| &d.inclination_deg));
        let toolface = "toolface (magnetic in the vertical hole)";
        tables.push(table(toolface, "target: median under 1.0", grade, &both, |d| &d.toolface_deg));
    }
    Ok(tables)
}

fn table(what: &str, targets: &str, grade: GyroGrade, both: &[Vec<Trial>; 2], angle: Angle) -> Table {
    let mut table = Table::new(
        format!(
            "Six minutes of the gyro alone from the true attitude, identified on the 50 s window before, 100 Hz, earth rate removed: \
             error of {what} at 12 points, deg; {}; rms over the points as median [worst] of {} seeds ({targets})",
            grade.told(),
            both[0].len()
        ),
        &["", "vertical: rms", "median point", "worst point", "45 deg: rms", "median point", "worst point"],
    );
    let drift_rms = |trial: &Trial, index: usize| trial.get(index).map_or(f64::NAN, |drift| rms(angle(drift)));
    for (index, name) in NAMES.iter().enumerate() {
        let cells = both.iter().flat_map(|trials| {
            let of_seeds: Vec<f64> = trials.iter().map(|trial| drift_rms(trial, index)).collect();
            let drifts = trials.iter().filter_map(|trial| trial.get(index));
            let points: Vec<f64> = drifts.flat_map(|drift| angle(drift).iter().map(|x| x.abs())).collect();
            let worst = points.iter().copied().fold(0.0, f64::max);
            [median_and_worst(&of_seeds, 2), Cell::number(median(&points), 2), Cell::number(worst, 2)]
        });
        table.row([Cell::from(*name)].into_iter().chain(cells));
    }
    for (index, name) in [(IMOA, "rms of IMOA"), (AT_BOUND, "rms of an estimate at the bound")] {
        let ratios = both.iter().flat_map(|trials| {
            let all = |index: usize| rms(&trials.iter().map(|trial| drift_rms(trial, index)).collect::<Vec<_>>());
            [Cell::number(all(index) / all(TRUE), 2), Cell::from(""), Cell::from("")]
        });
        table.row([Cell::from(format!("{name} over rms of the true parameters"))].into_iter().chain(ratios));
    }
    table
}

fn trials(name: &str, grade: GyroGrade, seeds: u64) -> anyhow::Result<Vec<Trial>> {
    let mut scenario = scenario(name)?;
    scenario.earth.latitude_deg = Some(LATITUDE_DEG);
    grade.build_in(&mut scenario);
    each_seed(0..seeds, |seed| {
        let mut run = Run::simulate(&scenario, seed)?;
        grade.declare(&mut run.config);
        let drift = |model| Drift::of(&run, model).context("the run is shorter than six minutes");
        Contenders::of(&run, seed)?.models.iter().map(drift).collect()
    })
}
