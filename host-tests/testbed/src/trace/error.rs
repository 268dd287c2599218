use std::path::{Path, PathBuf};

use super::seconds::seconds;

/// A fault of a trace, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceError {
    /// The file.
    pub path: PathBuf,
    /// Line in the decompressed file, from 1; `None` if the fault is the whole file's.
    pub line: Option<u64>,
    /// Name of the column, if there is one.
    pub column: Option<&'static str>,
    /// The fault.
    pub fault: Fault,
}

/// Kinds of faults of a trace.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The file does not exist or may not be read.
    #[error("cannot be opened: {0}")]
    NotOpened(String),
    /// Reading failed midway.
    #[error("cannot be read: {0}")]
    NotRead(String),
    /// Writing failed.
    #[error("cannot be written: {0}")]
    NotWritten(String),
    /// The file holds nothing.
    #[error("the file is empty")]
    Empty,
    /// No row follows the header row.
    #[error("the trace is empty: no sample follows the header row")]
    NoSamples,
    /// The first row names no column of a trace.
    #[error("no header row: expected column names such as t_s,gx,gy,gz,ax,ay,az")]
    NoHeader,
    /// A required column is missing, or the rest of a group of which one is there.
    #[error("the column is missing")]
    MissingColumn,
    /// A column's name is there twice.
    #[error("the column is there twice")]
    DuplicateColumn,
    /// A cell that is not a number.
    #[error("{0:?} is not a number")]
    NotANumber(String),
    /// NaN, infinity, or too large for the number format.
    #[error("{0:?} is not a finite number")]
    NotFinite(String),
    /// A row has no time.
    #[error("the time is missing")]
    TimeMissing,
    /// A time that whole microseconds in 64 bits cannot hold.
    #[error("time {0:?} is negative or too large")]
    TimeOutOfRange(String),
    /// Time goes back.
    #[error("time goes back: {} s after {} s", seconds(*now_us), seconds(*before_us))]
    TimeBack {
        /// This row's time, microseconds.
        now_us: u64,
        /// The time of the row before, microseconds.
        before_us: u64,
    },
    /// The time of one row is far ahead of the rows around it.
    #[error("time jumps ahead: {} s, and the next row is at {} s", seconds(*ahead_us), seconds(*next_us))]
    TimeAhead {
        /// This row's time, microseconds.
        ahead_us: u64,
        /// The time of the row behind, microseconds.
        next_us: u64,
    },
    /// Two rows have the same time, to the microsecond.
    #[error("time repeats: {} s is the time of the row before", seconds(*.0))]
    TimeRepeated(u64),
    /// The gzip stream ends before its end mark.
    #[error("the gzip file is truncated")]
    TruncatedGzip,
    /// The gzip stream is inconsistent.
    #[error("the gzip file is damaged: {0}")]
    DamagedGzip(String),
    /// A byte sequence that is not UTF-8.
    #[error("byte {0} of the line is not UTF-8 text")]
    NotUtf8(usize),
    /// A line longer than any row of a trace.
    #[error("the line is longer than {0} bytes")]
    LineTooLong(u64),
    /// More or fewer cells than the header row has.
    #[error("{cells} cells where the header row has {columns}")]
    Ragged {
        /// Cells in this row.
        cells: usize,
        /// Columns of the header row.
        columns: usize,
    },
    /// A header key whose value cannot be used.
    #[error("{assignment:?}: the value must be {must_be}")]
    BadKey {
        /// Key and value.
        assignment: String,
        /// Requirement that the value must meet.
        must_be: &'static str,
    },
}

/// A fault with line and column, before the file's name is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Located {
    pub line: Option<u64>,
    pub column: Option<&'static str>,
    pub fault: Fault,
}

impl Fault {
    pub(super) const fn of_file(self) -> Located {
        Located { line: None, column: None, fault: self }
    }

    pub(super) const fn at(self, line: u64) -> Located {
        Located { line: Some(line), column: None, fault: self }
    }

    pub(super) fn in_column(self, line: u64, column: &'static str) -> Located {
        Located { line: Some(line), column: Some(column), fault: self }
    }
}

impl Located {
    pub(super) fn of(self, path: &Path) -> TraceError {
        TraceError { path: path.to_owned(), line: self.line, column: self.column, fault: self.fault }
    }
}

impl std::fmt::Display for TraceError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ", column {column}")?;
        }
        write!(f, ": {}", self.fault)
    }
}

impl std::error::Error for TraceError {}

/// A cell, cut for a message: a damaged file may hold a cell of any length.
pub(super) fn quoted(cell: &str) -> String {
    const LONGEST: usize = 40;
    if cell.chars().count() <= LONGEST {
        return cell.to_owned();
    }
    cell.chars().take(LONGEST).chain("...".chars()).collect()
}
