//! Error of a section that has measured all, and has found what must not be.

use std::fmt;
use testbed::study::Table;

/// A section was measured, and something that has to hold does not: its tables are shown all the same.
#[derive(Clone, Debug)]
pub(crate) struct DoesNotHold {
    /// Tables of the section.
    pub tables: Vec<Table>,
    /// Everything that does not hold.
    pub words: String,
}

impl fmt::Display for DoesNotHold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl std::error::Error for DoesNotHold {}
