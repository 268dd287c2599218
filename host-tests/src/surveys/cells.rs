//! Cells of a table that another program wrote: what cannot be read is told by line and column, with what mends it.

use csv::{Error, ErrorKind, Position, StringRecord};

/// Values that logs write where there is none (Log ASCII Standard).
const NULLS: [f64; 2] = [-999.25, -9_999.25];

/// Line of a row, from 1 on.
pub(super) fn line(record: &StringRecord) -> u64 {
    record.position().map_or(0, Position::line)
}

/// Number in a row's column.
pub(super) fn number(header: &StringRecord, record: &StringRecord, column: usize) -> Result<f64, String> {
    let cell = record.get(column).unwrap_or_default();
    let told = |why: &str| {
        let name = header.get(column).unwrap_or_default().trim_start_matches('\u{feff}');
        format!("line {}: column {name}: {cell:?} {why}", line(record))
    };
    match cell.parse::<f64>() {
        Ok(x) if NULLS.contains(&x) => Err(told("stands for no value: leave out the row, or give the value")),
        Ok(x) if x.is_finite() => Ok(x),
        _ if cell.contains(',') && cell.replacen(',', ".", 1).parse::<f64>().is_ok() => {
            Err(told("is no number: write decimal points, not commas"))
        }
        _ => Err(told("is no number: leave out the row, or give the value")),
    }
}

/// Why a row could not be cut into cells.
pub(super) fn unread(error: &Error) -> String {
    match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => format!(
            "line {}: has {len} cells, the header {expected_len}: a cell is missing or too many; decimal commas need semicolons or \
             tabs between the columns",
            pos.as_ref().map_or(0, Position::line)
        ),
        _ => error.to_string(),
    }
}
