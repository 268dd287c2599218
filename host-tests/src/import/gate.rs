//! The gate of an import: what in a recording cannot be, each with its likely fix. A trace that is wrong is
//! not written unless the user insists.

mod axes;
mod norms;
mod time;

use super::{column_map::ColumnMap, merged::Merged, series::Series};
use crate::trace::Keys;

/// Outcome of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How bad it is.
    pub verdict: Verdict,
    /// What was found, with its figures.
    pub told: String,
    /// What to do about it, if anything.
    pub fix: Option<String>,
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// As it should be.
    Fine,
    /// Nothing that the flight cannot bear, or nothing that could be told.
    Note,
    /// It cannot be so.
    Wrong,
}

impl Finding {
    fn fine(told: String) -> Self {
        Self { verdict: Verdict::Fine, told, fix: None }
    }

    fn note(told: String) -> Self {
        Self { verdict: Verdict::Note, told, fix: None }
    }

    fn wrong(told: String, fix: String) -> Self {
        Self { verdict: Verdict::Wrong, told, fix: Some(fix) }
    }
}

/// What the checks look at.
#[derive(Clone, Copy, Debug)]
pub struct Imported<'a> {
    /// All sensors on one clock.
    pub merged: &'a Merged,
    /// The gyro as it was read.
    pub gyro: &'a Series,
    /// All sensors as they were read.
    pub all: &'a [Series],
    /// The whole map.
    pub map: &'a ColumnMap,
    /// Keys of the trace.
    pub keys: &'a Keys,
}

/// All checks.
#[must_use]
pub fn findings(imported: &Imported) -> Vec<Finding> {
    let mut findings = time::check(imported);
    findings.extend(norms::check(imported));
    findings.extend(axes::check(imported));
    findings
}
