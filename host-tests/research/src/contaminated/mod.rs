//! Contaminated windows: which method saves them, at what cost, and when to refuse.
//!
//! The problem is implemented a second time here, in double precision and apart from the library, so that a
//! result does not rest on one implementation.

mod axes;
mod comparison;
mod consensus;
mod drilled;
mod effort;
mod frames;
mod graduated;
mod gravity_alone;
mod informed;
mod levenberg_marquardt;
mod loss;
mod magnetometer_frame;
mod methods;
mod population;
mod prior;
mod product;
mod rail;
mod readings;
mod refusal;
mod segments;
mod variations;
mod weak_form;
mod window;

use drilled::{Drilled, in_parallel};
use testbed::study::{Effort, Table};

/// The section's tables: 100 seeds of each kind.
///
/// # Errors
/// The library refuses a configuration or a search space.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    // Holes are vertical and at 45 deg by turns, and some tables are of half of the runs.
    let count = effort.repetitions(100).max(2);
    let runs = in_parallel(count as usize, |index| Drilled::new(index as u64));
    let windows = 7 * count;
    let title = format!(
        "Contaminated windows: error over the next 6 minutes under twice that of the clean fit, % of {windows} windows (7 kinds, {count} \
         seeds each; 10 to 50 % of the samples hit, by turns; vertical and 45 deg by turns); cost: evaluations and 5 for each normal \
         matrix"
    );
    let mut tables = vec![comparison::compare(title, &runs, &methods::all())];
    tables.push(informed::table("the same windows", &runs));
    tables.push(variations::test_windows(&runs));
    tables.push(variations::scales(&runs));
    tables.push(variations::schedules(&runs));
    tables.extend(refusal::tables(&runs));
    let half = runs.get(..runs.len() / 2).unwrap_or_default();
    tables.push(gravity_alone::table(half));
    tables.push(axes::table(half)?);
    tables.push(frames::table(half)?);
    tables.push(product::table("the same windows, half of the seeds", half)?);
    // Rest of 15 s, of which 10 s are in the window.
    let rested = in_parallel(half.len(), |index| Drilled::after_rest(index as u64, 15.0));
    tables.push(informed::table("windows that begin with 10 s of rest, half of the seeds", &rested));
    tables.push(product::table("windows that begin with 10 s of rest, half of the seeds", &rested)?);
    Ok(tables)
}
