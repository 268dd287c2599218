//! The loop case by case: blind traces, runs without effects, what each effect of the gyro leaves of the rate, and
//! effects that are hard to tell apart.

mod clean;
mod rates;
mod steps;
mod vertical;

use super::second_simulator::blind;
use testbed::study::{Effort, Table};

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    Ok(vec![
        blind::table(effort)?,
        clean::drilling(effort)?,
        clean::recordings()?,
        rates::table(effort)?,
        vertical::table(effort)?,
        steps::table(effort)?,
    ])
}
