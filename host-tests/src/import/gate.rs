//! The gate of an import: what in a recording cannot be, each with its likely fix. A trace that is wrong is
//! not written unless the user insists.

mod axes;
mod norms;
mod saturation;
mod sizes;
mod time;

use super::{column_map::ColumnMap, merged::Merged, resolve::Resolved, series::Series};
use testbed::trace::Keys;

/// Outcome of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Severity of the finding.
    pub verdict: Verdict,
    /// Finding in words, with its figures.
    pub told: String,
    /// Remedy of the finding, if there is one.
    pub fix: Option<String>,
    /// True if something that flies all the same, such as a magnet or a fault, may look so too.
    may_be_else: bool,
}

/// Severity of a finding.
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
        Self { verdict: Verdict::Fine, told, fix: None, may_be_else: false }
    }

    fn note(told: String) -> Self {
        Self { verdict: Verdict::Note, told, fix: None, may_be_else: false }
    }

    fn wrong(told: String, fix: String) -> Self {
        Self { verdict: Verdict::Wrong, told, fix: Some(fix), may_be_else: false }
    }

    /// The same, if `is_certain` does not hold, as what may be something else.
    fn unless(self, is_certain: bool) -> Self {
        Self { may_be_else: !is_certain, ..self }
    }

    /// Returns true if it is wrong and nothing but a unit, a sign or an axis can be the cause.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.verdict == Verdict::Wrong && !self.may_be_else
    }
}

/// Input of the checks.
#[derive(Clone, Copy, Debug)]
pub struct Imported<'a> {
    /// All sensors on one clock.
    pub merged: &'a Merged,
    /// The gyro as it was read.
    pub gyro: &'a Series,
    /// All sensors as they were read.
    pub all: &'a [Series],
    /// Their parts of the map.
    pub parts: &'a [Resolved],
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

/// Those of the checks that ask for units, signs and axes.
#[must_use]
pub fn units_and_axes(imported: &Imported) -> Vec<Finding> {
    let mut findings = norms::units(imported);
    findings.extend(axes::check(imported));
    findings
}
