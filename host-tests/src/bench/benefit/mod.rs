//! Share of the attainable benefit that is flown, on recordings with a reference and a known gyro error
//! multiplied in.
//!
//! Recordings come from the folder named by `MWD_RECORDINGS`, else from the repository. The reference only
//! scores; the probe never sees it.

mod case;
mod drilled;
mod early;
mod inflations;
mod least_over_shifts;
mod troubled;

use anyhow::Context;

use case::{Case, Errors, Recording};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};
use testbed::trace::recordings::{FOLDER, bundled, given};
use troubled::Trouble;

/// Share of a recording held out for the scores.
const HOLD_OUT: f64 = 0.5;

/// Sizes of the error, in the order of the rows; 0 leaves the recording as it is.
const SCALES: [f64; 5] = [1.0, 0.3, 0.2, 0.1, 0.0];

/// Scales shown for each recording.
const SHOWN: [f64; 3] = [1.0, 0.2, 0.0];

/// Troubles of the first half, each with the scale of the error beside it.
const TROUBLES: [(&str, Trouble, f64); 9] = [
    ("a gap of 0.1 s every 10 s", Trouble::Gaps(100_000), 1.0),
    ("a gap of 1 s every 10 s", Trouble::Gaps(1_000_000), 1.0),
    ("a gap of 5 s every 10 s", Trouble::Gaps(5_000_000), 1.0),
    ("a gap of 1 s every 10 s, as recorded", Trouble::Gaps(1_000_000), 0.0),
    ("start in motion", Trouble::StartInMotion, 1.0),
    ("start in motion, as recorded", Trouble::StartInMotion, 0.0),
    ("no magnetometer for 20 s", Trouble::NoField, 1.0),
    ("no magnetometer for 20 s, as recorded", Trouble::NoField, 0.0),
    ("P's diagonal within 30 %, off-diagonal 15 %, b 6 deg/s", Trouble::None, 3.0),
];

/// The cases of one recording.
struct Flown {
    name: String,
    cases: Vec<Case>,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let recordings = recordings()?;
    let flown = flown(&recordings, effort)?;
    let [trouble, harmed_by_it] = troubled(&recordings, effort)?;
    let inflated = inflations::table(&recordings, effort)?;
    let early = early::table(&recordings, effort)?;
    Ok(vec![
        by_scale(&flown),
        by_recording(&flown),
        harmed(&flown),
        inflated,
        early,
        trouble,
        harmed_by_it,
        drilled::table(effort)?,
    ])
}

/// Number of errors drawn for a recording.
fn draws(effort: Effort, scale: f64) -> u64 {
    match effort {
        // There is only one way to leave a recording as it is.
        _ if scale == 0.0 => 1,
        Effort::Quick => 1,
        Effort::Full => 4,
        Effort::Seeds(seeds) | Effort::These { seeds, .. } => seeds,
    }
}

fn recordings() -> anyhow::Result<Vec<Recording>> {
    let mut paths = given().context(FOLDER)?;
    if paths.is_empty() {
        paths = bundled()?;
    }
    let read = each_seed(0..paths.len() as u64, |index| Recording::read(paths.get(index as usize).context("a path")?))?;
    Ok(read.into_iter().flatten().collect())
}

fn flown(recordings: &[Recording], effort: Effort) -> anyhow::Result<Vec<Flown>> {
    let of_one = || SCALES.into_iter().flat_map(|scale| (0..draws(effort, scale)).map(move |draw| (scale, draw)));
    let cases: Vec<_> = recordings.iter().flat_map(|recording| of_one().map(move |case| (recording, case))).collect();
    let mut done = each_seed(0..cases.len() as u64, |index| {
        let (recording, (scale, draw)) = cases.get(index as usize).context("a case")?;
        recording.fly_with(Trouble::None, *scale, *draw)
    })?
    .into_iter();
    let of_recording = |recording: &Recording| Flown {
        name: recording.name.clone(),
        cases: done.by_ref().take(of_one().count()).collect(),
    };
    Ok(recordings.iter().map(of_recording).collect())
}

fn by_scale(flown: &[Flown]) -> Table {
    let mut table = Table::new(
        "Benefit, recordings with a gyro error multiplied in: at 1 P's diagonal within 10 %, its off-diagonal within 5 %, b \
         within 2 deg/s of each axis. Parameters from the first half; error of the rotation over 2 s in the second half \
         against the reference, least over a lag of 0 to 8 ms. Share: how much of the way from bias only to attainable (the \
         recording before the error) is gone, where at least 0.2 deg is to be had. Harmed: flown is more than 1.05 times bias \
         only and 0.02 deg. NEES / 9 of P: 1 on the mean where its covariance is right; the truth is the error with the recording's \
         own P behind it, as the reference tells that from the whole recording",
        &[
            "error",
            "share, mean",
            "median",
            "of cases",
            "harmed",
            "of cases",
            "P flies",
            "flown / bias only, worst",
            "mean",
            "NEES / 9, median",
            "largest",
        ],
    );
    for scale in SCALES {
        let cases: Vec<&Case> = flown.iter().flat_map(|one| &one.cases).filter(|case| case.scale == scale).collect();
        let shares: Vec<f64> = cases.iter().filter_map(|case| case.errors.share()).collect();
        let ratios: Vec<f64> = cases.iter().map(|case| case.errors.ratio()).collect();
        let nees: Vec<f64> = cases.iter().filter_map(|case| case.nees).collect();
        let count = |is: fn(&Case) -> bool| number(cases.iter().filter(|case| is(case)).count() as f64, 0);
        table.row([
            number(scale, 1),
            number(mean(&shares), 2),
            number(middle(&shares), 2),
            number(shares.len() as f64, 0),
            count(|case| case.errors.harmed()),
            number(cases.len() as f64, 0),
            count(|case| case.p_flies),
            number(largest(&ratios), 2),
            number(mean(&ratios), 2),
            number(middle(&nees), 2),
            number(largest(&nees), 2),
        ]);
    }
    table
}

fn by_recording(flown: &[Flown]) -> Table {
    let mut table = Table::new(
        "The same of each recording, deg rms, mean of its cases; at 0 bias only is what is attainable. NEES / 9: mean of all its cases",
        &[
            "recording",
            "1: bias only",
            "flown",
            "attainable",
            "0.2: bias only",
            "flown",
            "attainable",
            "0: bias only",
            "flown",
            "attainable",
            "NEES / 9",
        ],
    );
    for one in flown {
        let nees: Vec<f64> = one.cases.iter().filter_map(|case| case.nees).collect();
        let of_scale = |scale: f64| {
            let cases = || one.cases.iter().filter(move |case| case.scale == scale).map(|case| case.errors);
            let of = |part: fn(Errors) -> f64| number(mean(&cases().map(part).collect::<Vec<f64>>()), 3);
            [of(|errors| errors.bias_only_deg), of(|errors| errors.flown_deg), of(|errors| errors.attainable_deg)]
        };
        let errors = SHOWN.into_iter().flat_map(of_scale);
        table.row([one.name.as_str().into()].into_iter().chain(errors).chain([number(mean(&nees), 2)]));
    }
    table
}

fn harmed(flown: &[Flown]) -> Table {
    let mut table = Table::new(
        "Those of them that are harmed, deg rms",
        &["recording", "error", "draw", "bias only", "flown", "attainable"],
    );
    for one in flown {
        for case in one.cases.iter().filter(|case| case.errors.harmed()) {
            let Errors { bias_only_deg, flown_deg, attainable_deg } = case.errors;
            let errors = [bias_only_deg, flown_deg, attainable_deg].map(|error_deg| number(error_deg, 3));
            let of = [one.name.as_str().into(), number(case.scale, 1), number(case.draw as f64, 0)];
            table.row(of.into_iter().chain(errors));
        }
    }
    table
}

fn troubled(recordings: &[Recording], effort: Effort) -> anyhow::Result<[Table; 2]> {
    let mut harmed = Table::new(
        "Those of them that are harmed, deg rms",
        &["trouble", "recording", "draw", "bias only", "flown", "attainable"],
    );
    let mut table = Table::new(
        "With something amiss in the first half; without a rest bias only is the raw rate",
        &["trouble", "share, mean", "median", "harmed", "of cases", "flown / bias only, worst", "mean"],
    );
    for (name, trouble, scale) in TROUBLES {
        let draws = draws(effort, scale);
        let cases = each_seed(0..recordings.len() as u64 * draws, |index| {
            let recording = recordings.get((index / draws) as usize).context("a recording")?;
            recording.fly_with(trouble, scale, index % draws)
        })?;
        for (index, case) in cases.iter().enumerate().filter(|(_, case)| case.errors.harmed()) {
            let recording = recordings.get(index / draws as usize).context("a recording")?;
            let Errors { bias_only_deg, flown_deg, attainable_deg } = case.errors;
            let errors = [bias_only_deg, flown_deg, attainable_deg].map(|error_deg| number(error_deg, 3));
            let of = [name.into(), recording.name.as_str().into(), number(case.draw as f64, 0)];
            harmed.row(of.into_iter().chain(errors));
        }
        let shares: Vec<f64> = cases.iter().filter_map(|case| case.errors.share()).collect();
        let ratios: Vec<f64> = cases.iter().map(|case| case.errors.ratio()).collect();
        table.row([
            name.into(),
            number(mean(&shares), 2),
            number(middle(&shares), 2),
            number(cases.iter().filter(|case| case.errors.harmed()).count() as f64, 0),
            number(cases.len() as f64, 0),
            number(largest(&ratios), 2),
            number(mean(&ratios), 2),
        ]);
    }
    Ok([table, harmed])
}

fn number(value: f64, decimals: usize) -> Cell {
    Cell::number(value, decimals)
}

/// Mean; NaN without values.
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Largest value; NaN without values.
fn largest(values: &[f64]) -> f64 {
    values.iter().copied().reduce(f64::max).unwrap_or(f64::NAN)
}

/// Median; of an even number the mean of the middle two, because the upper one of a dozen shares would
/// flatter. NaN without values.
fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (lower, upper) = (values.len().saturating_sub(1) / 2, values.len() / 2);
    let of = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    0.5 * (of(lower) + of(upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_lies_between_the_two_in_the_middle() {
        assert_eq!(middle(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(middle(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(middle(&[]).is_nan() && mean(&[]).is_nan() && largest(&[]).is_nan());
    }

    #[test]
    fn the_recording_as_it_is_flies_once() {
        assert_eq!(SCALES.map(|scale| draws(Effort::Full, scale)), [4, 4, 4, 4, 1]);
        assert_eq!(SCALES.map(|scale| draws(Effort::Seeds(3), scale)), [3, 3, 3, 3, 1]);
    }
}
