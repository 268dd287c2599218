//! Benefit of the multi-station analysis: azimuths of simulated runs before and after it.

use std::f64::consts::TAU;

use meerkat_mwd::{
    config::SurveyErrors,
    survey::{
        Uncertain,
        multi_station::{Decision, MultiStation, MultiStationSettings},
    },
};

use crate::surveys::simulated_run::Run;
use testbed::study::{Cell, Effort, Table, median_and_worst, rms, seeds::each_seed};

/// Inclination above which an azimuth is scored, radians: below, it is not what steers.
const LEAST_INCLINATION_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Scores of one run.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Azimuth error, rms over the stations, before and after, degrees.
    pub azimuth_deg: [f64; 2],
    /// Inclination error, the same.
    pub inclination_deg: [f64; 2],
    /// True if azimuths were corrected.
    pub corrected: bool,
    /// Stations whose error is within one and within two of the stated sigmas, and all scored.
    pub within: [f64; 3],
    /// Sum of stated variances of the azimuth, before and after, degrees squared.
    pub stated: [f64; 2],
}

/// Analyses a simulated run with the error model's default priors and scores it.
#[must_use]
pub fn scored(run: &Run, seed: u64) -> Option<Score> {
    let drawn = run.drawn(seed);
    let mut stations = MultiStation::new();
    for truth in &drawn.stations {
        stations.push(truth.station).ok()?;
    }
    let report = stations.analyse(&SurveyErrors::default(), &MultiStationSettings::default())?;
    let mut errors = [const { Vec::new() }; 4];
    let (mut within, mut stated) = ([0.0; 3], [0.0; 2]);
    for (k, truth) in drawn.stations.iter().enumerate() {
        let station = report.corrected(&truth.station)?;
        if truth.inclination_rad < LEAST_INCLINATION_RAD || report.left_out >> k & 1 == 1 {
            continue;
        }
        let off = |x: Uncertain, truth: f64| libm::remainder(f64::from(x.value) - truth, TAU).to_degrees();
        let all = [
            (station.measured_azimuth_rad, truth.azimuth_rad),
            (station.magnetic_azimuth_rad, truth.azimuth_rad),
            (station.measured_inclination_rad, truth.inclination_rad),
            (station.inclination_rad, truth.inclination_rad),
        ];
        for (errors, (x, truth)) in errors.iter_mut().zip(all) {
            errors.push(off(x, truth));
        }
        let sigma = f64::from(station.magnetic_azimuth_rad.sigma).to_degrees();
        let error = off(station.magnetic_azimuth_rad, truth.azimuth_rad).abs();
        within[0] += f64::from(u8::from(error < sigma));
        within[1] += f64::from(u8::from(error < 2.0 * sigma));
        within[2] += 1.0;
        stated[1] += sigma * sigma;
        stated[0] += f64::from(station.measured_azimuth_rad.sigma).to_degrees().powi(2);
    }
    let [before, after, inclination_before, inclination_after] = errors.map(|errors| rms(&errors));
    Some(Score {
        azimuth_deg: [before, after],
        inclination_deg: [inclination_before, inclination_after],
        corrected: report.azimuth == Decision::Corrected,
        within,
        stated,
    })
}

/// Kinds of run that the tables have: name, and what differs from the error model's.
#[must_use]
pub fn kinds() -> [(&'static str, Run); 10] {
    let run = Run::default();
    let errors = run.errors;
    let magnetised = SurveyErrors { axial_interference_ut: 5.0 * errors.axial_interference_ut, ..errors };
    let worse_sensors = SurveyErrors { mag_bias_ut: 4.0 * errors.mag_bias_ut, ..errors };
    [
        ("in specification", run),
        ("10 stations", Run { stations: 10, ..run }),
        ("drill string five times as magnetic", Run { errors: magnetised, ..run }),
        ("magnetometer's bias four times as large", Run { errors: worse_sensors, ..run }),
        ("noise of stations up to three times", Run { noise_factor: 3.0, ..run }),
        ("a tenth of the stations disturbed by 2 uT", Run { disturbed: 0.1, ..run }),
        ("level to the east or west", Run { level_to_the_east: true, ..run }),
        (
            "level to the east or west, drill string five times as magnetic",
            Run { errors: magnetised, level_to_the_east: true, ..run },
        ),
        ("magnetometer turned by 0.02 deg on each axis", Run { misaligned_rad: f64::to_radians(0.02), ..run }),
        ("magnetometer turned by 0.1 deg on each axis", Run { misaligned_rad: f64::to_radians(0.1), ..run }),
    ]
}

/// The table.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let count = effort.repetitions(500);
    let mut table = Table::new(
        format!(
            "Multi-station analysis of {count} simulated runs each: azimuth error above 5 deg of inclination, deg rms over a run's stations that are not doubted, median [worst]"
        ),
        &[
            "runs",
            "before",
            "after",
            "rms before",
            "rms after",
            "stated after",
            "corrected, %",
            "worse, %",
            "worse by over 0.1 deg, %",
            "within 1 sigma, %",
            "within 2 sigma, %",
            "inclination rms before",
            "after",
        ],
    );
    for (name, kind) in kinds() {
        let scores: Vec<Score> = each_seed(0..count, |seed| Ok(scored(&kind, seed)))?.into_iter().flatten().collect();
        table.row(row(name, &scores));
    }
    Ok(vec![table])
}

fn row(name: &str, scores: &[Score]) -> Vec<Cell> {
    let all = |of: fn(&Score) -> f64| scores.iter().map(of).collect::<Vec<f64>>();
    let share = |of: &dyn Fn(&Score) -> bool| {
        scores.iter().filter(|score| of(score)).count() as f64 / scores.len().max(1) as f64
    };
    let sum = |of: &dyn Fn(&Score) -> f64| scores.iter().map(of).sum::<f64>();
    let stations = sum(&|score| score.within[2]);
    let (before, after) = (all(|score| score.azimuth_deg[0]), all(|score| score.azimuth_deg[1]));
    vec![
        name.into(),
        median_and_worst(&before, 2),
        median_and_worst(&after, 2),
        Cell::number(rms(&before), 3),
        Cell::number(rms(&after), 3),
        Cell::number(libm::sqrt(sum(&|score| score.stated[1]) / stations), 3),
        Cell::percent(share(&|score| score.corrected), 1),
        Cell::percent(share(&|score| score.azimuth_deg[1] > score.azimuth_deg[0]), 2),
        Cell::percent(share(&|score| score.azimuth_deg[1] > score.azimuth_deg[0] + 0.1), 2),
        Cell::percent(sum(&|score| score.within[0]) / stations, 1),
        Cell::percent(sum(&|score| score.within[1]) / stations, 1),
        Cell::number(rms(&all(|score| score.inclination_deg[0])), 4),
        Cell::number(rms(&all(|score| score.inclination_deg[1])), 4),
    ]
}
