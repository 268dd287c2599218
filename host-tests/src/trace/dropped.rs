//! Rows that were dropped since their time is not after that of the row before.

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
    /// Rows with a time before that of a row above.
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

    /// The first one, if so many rows were dropped that the times themselves are wrong.
    pub(super) fn too_many(&self, kept: usize) -> Option<Located> {
        let is_most = self.all() as f64 > TOO_MANY * (self.all() + kept) as f64;
        self.first.as_deref().filter(|_| is_most).cloned()
    }

    pub(super) fn note(&self) -> Option<String> {
        let line = self.first.as_deref()?.line?;
        let (all, repeated, late) = (self.all(), self.repeated, self.late);
        Some(format!("{all} rows dropped: {repeated} repeat a time, {late} are late; the first in line {line}"))
    }
}
