//! Cases in which the attitude, or what was said of it, was once wrong in silence: each again over random seeds.

mod cases;
pub mod schedules;
pub(in crate::bench) mod seen;

use self::{
    cases::{CASES, Case},
    seen::counted,
};
use testbed::study::{Cell, Effort, Table, median, seeds::each_seed};

/// Plays every case, and the schedules.
///
/// # Errors
/// A configuration cannot be flown.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    Ok(vec![cases(effort)?, schedules::table(effort)?])
}

/// Cell of a figure. One that is infinite is told: a dash would say that there is none.
fn cell(figure: f64, decimals: usize) -> Cell {
    if figure.is_infinite() { Cell::from("infinite") } else { Cell::number(figure, decimals) }
}

/// Table of the cases.
pub(crate) fn cases(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.repetitions(20);
    let mut table = Table::new(
        format!(
            "Cases that were once wrong in silence, {seeds} runs each, simulated drilling at 100 Hz. Sigmas: the largest error of \
             inclination, azimuth or toolface in its own stated deviations, over samples that no flag marks"
        ),
        &["case", "figure", "unit", "median", "worst", "at most"],
    );
    for Case { name, figures, run } in &CASES {
        let runs = each_seed(0..seeds, run)?;
        for (k, figure) in figures.iter().enumerate() {
            let values: Vec<f64> = runs.iter().filter_map(|values| values.get(k).copied()).map(counted).collect();
            let worst = values.iter().copied().fold(f64::NAN, f64::max);
            let middle = median(&values);
            let limit = figure.at_most.map_or_else(|| Cell::from("-"), |limit| Cell::number(limit, 2));
            let [middle, worst] = [middle, worst].map(|x| cell(x, 2));
            table.row([Cell::from(*name), figure.name.into(), figure.unit.into(), middle, worst, limit]);
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_is_no_number_is_the_worst_and_is_shown() {
        let worst = [1.0, f64::NAN, 2.0].map(counted).into_iter().fold(f64::NAN, f64::max);
        assert_eq!((cell(worst, 2).text.as_str(), cell(2.0, 2).text.as_str()), ("infinite", "2.00"));
    }
}
