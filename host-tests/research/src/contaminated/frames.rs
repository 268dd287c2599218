//! Accuracy of an unknown magnetometer frame, clean and contaminated.

use meerkat_mwd::optimizer::OptimizerError;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{
    comparison::success_percent,
    drilled::{Drilled, in_parallel},
    effort::Spent,
    magnetometer_frame::{Frame, turned_readings},
    population::Search,
    prior::Prior,
};
use testbed::{
    simulate::{Contamination, random::Random},
    study::Table,
};

/// Angles of the turn, degrees, about a random axis, and whether 30 % of the samples are hit.
const CASES: [(f64, bool); 6] = [(5.0, false), (5.0, true), (45.0, false), (45.0, true), (180.0, false), (180.0, true)];

/// Success against the fit of the clean window from the true frame, frame free.
pub(super) fn table(runs: &[Drilled]) -> anyhow::Result<Table> {
    let title = "Magnetometer's axes turned by an unknown rotation (random axis): error under twice that of the clean fit which begins at \
                 the true frame and frees it, % (the kinds by turns)"
        .to_owned();
    let heads = CASES.map(|(angle, hit)| format!("{angle} deg{}", if hit { ", 30 % hit" } else { "" }));
    let mut columns = vec!["how the frame is found", "cost"];
    columns.extend(heads.iter().map(String::as_str));
    let mut table = Table::new(title, &columns);
    let finders = [
        ("known, refined", Frame::Known),
        ("taken as aligned", Frame::Aligned),
        ("refined from aligned", Frame::Refined),
        ("one linear problem of the field alone, refined", Frame::Linear),
        ("24 turns of a cube, each refined", Frame::Cube),
        ("IMOA 200 over the rotation, refined", Frame::Search(Search::Imoa, 200)),
        ("PSO 200 over the rotation, refined", Frame::Search(Search::Pso, 200)),
        ("DE 200 over the rotation, refined", Frame::Search(Search::DifferentialEvolution, 200)),
    ];
    let prior = Prior::data_sheet();
    let outcomes: Result<Vec<Vec<(f64, u32)>>, OptimizerError> = in_parallel(runs.len() * CASES.len(), |index| {
        let (run, (angle_deg, hit)) = (&runs[index / CASES.len()], CASES[index % CASES.len()]);
        let axis = Vector3::from(Random::new(run.seed ^ 0xF4A3).direction());
        let truth: Matrix3<f64> = Rotation3::from_scaled_axis(axis * angle_deg.to_radians()).into_inner();
        let kind = Contamination::ALL[run.seed as usize % Contamination::ALL.len()];
        let clean = turned_readings(run.readings(None, 0.0), &truth);
        let readings = if hit { turned_readings(run.readings(Some(kind), 0.3), &truth) } else { clean.clone() };
        let best = Frame::Known.find(&clean, &prior, &truth, run.seed, &mut Spent::default())?;
        let best = run.error_rad_s(&best.theta);
        let one = |(_, finder): &(&str, Frame)| {
            let mut spent = Spent::default();
            let found = finder.find(&readings, &prior, &truth, run.seed, &mut spent)?;
            Ok((run.error_rad_s(&found.theta) / best, spent.total()))
        };
        finders.iter().map(one).collect()
    })
    .into_iter()
    .collect();
    let outcomes = outcomes?;
    for (row, (name, _)) in finders.iter().enumerate() {
        let mut costs: Vec<u32> = outcomes.iter().map(|o| o[row].1).collect();
        costs.sort_unstable();
        let mut cells = vec![(*name).to_owned(), costs[costs.len() / 2].to_string()];
        let of_case = |case: usize| outcomes.iter().skip(case).step_by(CASES.len()).map(move |o| o[row].0);
        cells.extend((0..CASES.len()).map(|case| success_percent(of_case(case))));
        table.row(cells);
    }
    Ok(table)
}
