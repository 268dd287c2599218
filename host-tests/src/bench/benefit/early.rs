//! Identification that ends early: whether the mean that flies after a few seconds of motion does harm.

use anyhow::Context;

use super::{
    case::{Case, Recording},
    draws, largest, mean, number,
};
use testbed::study::{Effort, Table, seeds::each_seed};

/// Seconds of motion after which identification ends.
const MOTION_S: [f64; 6] = [3.0, 5.0, 8.0, 12.0, 20.0, 30.0];
/// Sizes of the error; 0 leaves the recording as it is.
const SCALES: [f64; 3] = [1.0, 0.2, 0.0];

pub(super) fn table(recordings: &[Recording], effort: Effort) -> anyhow::Result<Table> {
    let mut table = Table::new(
        "Identification that ends after so many seconds of motion; all else as above. A recording counts where its first \
         half has that much motion",
        &[
            "motion, s",
            "P flies",
            "of cases",
            "share at 1, mean",
            "at 0.2",
            "harmed",
            "of cases",
            "flown / bias only, worst",
            "as recorded: harmed",
            "of cases",
            "flown / bias only, worst",
        ],
    );
    let of_one = |recording| {
        SCALES.into_iter().flat_map(move |scale| (0..draws(effort, scale)).map(move |draw| (recording, scale, draw)))
    };
    for motion_s in MOTION_S {
        let all: Vec<_> = recordings.iter().flat_map(of_one).collect();
        let cases: Vec<Case> = each_seed(0..all.len() as u64, |index| {
            let (recording, scale, draw): &(&Recording, f64, u64) = all.get(index as usize).context("a case")?;
            recording.fly_until(motion_s, *scale, *draw)
        })?
        .into_iter()
        .flatten()
        .collect();
        let (spoilt, recorded): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| case.scale > 0.0);
        let share = |scale: f64| {
            let of_scale = spoilt.iter().filter(|case| case.scale == scale);
            mean(&of_scale.filter_map(|case| case.errors.share()).collect::<Vec<f64>>())
        };
        let harmed = |cases: &[&Case]| number(cases.iter().filter(|case| case.errors.harmed()).count() as f64, 0);
        let worst = |cases: &[&Case]| largest(&cases.iter().map(|case| case.errors.ratio()).collect::<Vec<f64>>());
        table.row([
            number(motion_s, 0),
            number(cases.iter().filter(|case| case.p_flies).count() as f64, 0),
            number(cases.len() as f64, 0),
            number(share(1.0), 2),
            number(share(0.2), 2),
            harmed(&spoilt),
            number(spoilt.len() as f64, 0),
            number(worst(&spoilt), 2),
            harmed(&recorded),
            number(recorded.len() as f64, 0),
            number(worst(&recorded), 2),
        ]);
    }
    Ok(table)
}
