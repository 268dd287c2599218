//! Whole recordings flown from cold with a gyro error multiplied in, which nobody has identified before.

use meerkat_mwd::{Config, compensation::GyroModel};

use super::{Cell, Coverage, Table, by_recording, oracles, row_of_means, vqf};
use crate::bench::error_multiplied_in::drawn;
use testbed::study::{Effort, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::{Settings, attitude_rms_deg, attitudes_of},
    simulate::known_error,
    trace::Trace,
};

/// Largest errors of P's diagonal, in percent: half of that off it, and of the bias 0.2 deg/s for each percent.
pub(super) const PERCENT: [f64; 3] = [0.0, 2.0, 10.0];
/// Scale of [`drawn`] for one percent.
const OF_A_PERCENT: f64 = 0.1;
/// Draws of the error for each recording.
const DRAWS: u64 = 2;
/// Whose attitudes are scored: VQF's; this project's; the same flown again, from the start with the gyro model that the
/// first flight ended with; the first flight up to its first update of P, and then the other; and each of its two
/// filters without the other.
const ESTIMATES: [&str; 6] = [
    "VQF (vqf-rs 0.3)",
    "ours",
    "ours, with its last model from the start",
    "ours, from its first update on as with its last model",
    "our attitude filter without an estimator",
    "our estimator without an attitude filter",
];

/// A recording with one error, flown by both.
pub(super) struct Flown {
    /// Index into [`PERCENT`].
    pub size: usize,
    recording: usize,
    /// Total error of each of [`ESTIMATES`], degrees rms.
    total_deg: [Option<f64>; ESTIMATES.len()],
    pub coverage: Coverage,
}

/// Flies every recording as it is and with every error.
///
/// # Errors
/// A recording has no configuration that can be flown.
pub(super) fn flown(recordings: &[(String, Trace)], effort: Effort) -> anyhow::Result<Vec<Flown>> {
    let mut cases = Vec::new();
    for (size, percent) in PERCENT.iter().enumerate() {
        for recording in 0..recordings.len() {
            let draws = if *percent > 0.0 { effort.repetitions(DRAWS).min(DRAWS) } else { 1 };
            cases.extend((0..draws).map(|draw| (size, recording, draw)));
        }
    }
    each_seed(0..cases.len() as u64, |index| {
        let (size, recording, draw) = cases[index as usize];
        let (name, trace) = &recordings[recording];
        let mut trace = trace.clone();
        if PERCENT[size] > 0.0 {
            known_error::apply(&mut trace, &drawn(name, draw, OF_A_PERCENT * PERCENT[size]));
        }
        let total = |attitudes: &[_]| attitude_rms_deg(&trace, attitudes, &Settings::default())[0].total;
        let flight = fly(&of_trace(&trace), &trace.samples, |_| {})?;
        let last = flight.reports.last().map_or(GyroModel::IDENTITY, |report| report.flown);
        let again = fly(&Config { gyro: last, ..of_trace(&trace) }, &trace.samples, |_| {})?;
        let [cold, warm] = [&flight, &again].map(|flight| attitudes_of(flight).collect::<Vec<_>>());
        let total_deg = [
            total(&vqf(&trace)),
            total(&cold),
            total(&warm),
            total(&oracles::warm_from_the_first_update(&trace, &cold, &warm)?),
            total(&oracles::filter_alone(&trace)),
            total(&oracles::estimators_own(&trace)),
        ];
        Ok(Flown { size, recording, total_deg, coverage: Coverage::of(&trace, &flight) })
    })
}

/// Table of the total error, mean over the draws.
pub(super) fn table(names: &[String], flown: &[Flown]) -> Table {
    let mut table = by_recording(
        "Attitude error from cold with a gyro error multiplied in (P's diagonal within so many percent, off it half of that, \
         uniform), total, deg rms, mean over the draws"
            .to_owned(),
        names,
    );
    for (size, percent) in PERCENT.iter().enumerate() {
        for (who, name) in ESTIMATES.iter().enumerate() {
            let mean = |recording: usize| {
                let of: Vec<f64> = flown
                    .iter()
                    .filter(|case| case.size == size && case.recording == recording)
                    .filter_map(|case| case.total_deg[who])
                    .collect();
                (!of.is_empty()).then(|| of.iter().sum::<f64>() / of.len() as f64)
            };
            row_of_means(&mut table, &format!("{percent:.0} %, {name}"), (0..names.len()).map(mean));
        }
    }
    table
}

impl Coverage {
    /// Table of the coverage, all recordings and draws of a size together.
    pub(super) fn table(flown: &[Flown]) -> Table {
        let mut table = Table::new(
            "How often the error is within the stated deviations while the recording moves, % (a normal distribution: 68 and 95), \
             their root mean square in deviations, and the longest stretch in which it is over three of them, s",
            &[
                "gyro error",
                "inclination, 1 sigma",
                "2 sigma",
                "rms, sigmas",
                "over 3, s",
                "azimuth, 1 sigma",
                "2 sigma",
                "rms, sigmas",
                "over 3, s",
            ],
        );
        for (size, percent) in PERCENT.iter().enumerate() {
            let of = flown.iter().filter(|case| case.size == size).map(|case| &case.coverage);
            let all = of.fold(Self::default(), |sum, one| sum.with(one));
            let figures = all.angles.iter().flat_map(|angle| {
                let [one, two] = angle.within.map(|count| Cell::percent(count as f64 / angle.count as f64, 0));
                [
                    one,
                    two,
                    Cell::number((angle.squares / angle.count as f64).sqrt(), 2),
                    Cell::number(angle.longest_s, 1),
                ]
            });
            table.row([Cell::from(format!("{percent:.0} %"))].into_iter().chain(figures));
        }
        table
    }
}
