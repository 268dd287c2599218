//! Share, harm and NEES of the estimates, over how much their covariance is inflated.

use anyhow::Context;

use super::{
    case::{Case, Recording},
    draws, largest, mean, middle, number,
};
use testbed::study::{Effort, Table, seeds::each_seed};

/// Factors on the inflations that are built in.
const FACTORS: [f32; 7] = [4.0, 2.0, 1.4, 1.0, 0.7, 0.5, 0.36];

/// Sizes of the error, in the order of the columns; 0 leaves the recording as it is.
const SCALES: [f64; 4] = [1.0, 0.2, 0.1, 0.0];

pub(super) fn table(recordings: &[Recording], effort: Effort) -> anyhow::Result<Table> {
    let mut table = Table::new(
        "The estimator alone over the first half, its covariance inflated by so many times the inflations that are built in \
         (by hand, 0.7, 1.4 and 2.8): share, harm and NEES as above",
        &[
            "inflations, times",
            "share at 1, mean",
            "at 0.2",
            "at 0.1",
            "harmed",
            "of cases",
            "as recorded: harmed",
            "of cases",
            "flown / bias only, worst",
            "mean",
            "NEES / 9, median",
            "largest",
        ],
    );
    for factor in FACTORS {
        let of_one = || SCALES.into_iter().flat_map(|scale| (0..draws(effort, scale)).map(move |draw| (scale, draw)));
        let all: Vec<_> = recordings.iter().flat_map(|recording| of_one().map(move |case| (recording, case))).collect();
        let cases = each_seed(0..all.len() as u64, |index| {
            let (recording, (scale, draw)) = all.get(index as usize).context("a case")?;
            recording.estimate_with(factor, *scale, *draw)
        })?;
        let (as_recorded, spoilt): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| case.scale == 0.0);
        let share = |scale: f64| {
            let of_scale = spoilt.iter().filter(|case| case.scale == scale);
            number(mean(&of_scale.filter_map(|case| case.errors.share()).collect::<Vec<f64>>()), 2)
        };
        let count =
            |cases: &[&Case], is: fn(&Case) -> bool| number(cases.iter().filter(|case| is(case)).count() as f64, 0);
        let ratios: Vec<f64> = as_recorded.iter().map(|case| case.errors.ratio()).collect();
        let nees: Vec<f64> = spoilt.iter().filter_map(|case| case.nees).collect();
        table.row([
            number(f64::from(factor), 2),
            share(1.0),
            share(0.2),
            share(0.1),
            count(&spoilt, |case| case.errors.harmed()),
            count(&spoilt, |_| true),
            count(&as_recorded, |case| case.errors.harmed()),
            count(&as_recorded, |_| true),
            number(largest(&ratios), 2),
            number(mean(&ratios), 2),
            number(middle(&nees), 2),
            number(largest(&nees), 2),
        ]);
    }
    Ok(table)
}
