//! Rows that were dropped for their time: one that repeats, goes back, or was far ahead of the rows behind it.

use std::path::Path;

use super::error::{Fault, Located, TraceError};

/// Share of dropped rows from which it is the clock, or two recordings in one file, and not a few late
/// packets.
const TOO_MANY: f64 = 0.05;

/// Rows of a trace that were dropped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dropped {
    /// Rows with the time of the row before.
    pub repeated: usize,
    /// Rows out of order: with a time before that of a row above, or far ahead of the row below.
    pub late: usize,
    first: Option<Box<Located>>,
}

impl Dropped {
    pub(super) fn count(&mut self, located: Located) {
        *if matches!(located.fault, Fault::TimeRepeated(_)) { &mut self.repeated } else { &mut self.late } += 1;
        self.first.get_or_insert(Box::new(located));
    }

    /// All of them.
    #[must_use]
    pub const fn all(&self) -> usize {
        self.repeated + self.late
    }

    /// The first one, as an error of the file.
    #[must_use]
    pub fn first(&self, path: &Path) -> Option<TraceError> {
        self.first.as_deref().map(|first| first.clone().of(path))
    }

    /// Returns true if so many rows were dropped that the times themselves are wrong.
    #[must_use]
    pub fn are_too_many(&self, kept: usize) -> bool {
        self.all() as f64 > TOO_MANY * (self.all() + kept) as f64
    }

    /// The first one, if they are too many.
    pub(super) fn too_many(&self, kept: usize) -> Option<Located> {
        self.first.as_deref().filter(|_| self.are_too_many(kept)).cloned()
    }

    /// Number of dropped rows in words, with the reasons.
    #[must_use]
    pub fn told(&self) -> String {
        format!("{} rows dropped: {} repeat a time, {} are out of order", self.all(), self.repeated, self.late)
    }

    pub(super) fn note(&self) -> Option<String> {
        let line = self.first.as_deref()?.line?;
        Some(format!("{}; the first in line {line}", self.told()))
    }
}
