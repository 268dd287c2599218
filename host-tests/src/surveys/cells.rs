//! Cells of a table that another program wrote: what cannot be read is told by line and column, with what mends it.

use csv::{Error, ErrorKind, Position, StringRecord};

/// Values that logs write where there is none (Log ASCII Standard).
const NULLS: [f64; 2] = [-999.25, -9_999.25];

/// Text without the byte order mark that some programs begin a file with.
pub fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Line of a row, from 1 on.
pub(super) fn line(record: &StringRecord) -> u64 {
    record.position().map_or(0, Position::line)
}

/// Number in a row's column.
pub(super) fn number(header: &StringRecord, record: &StringRecord, column: usize) -> Result<f64, String> {
    let cell = record.get(column).unwrap_or_default();
    let told = |why: &str| told(header, record, column, why);
    match cell.parse::<f64>() {
        Ok(x) if NULLS.contains(&x) => Err(told("stands for no value: leave out the row, or give the value")),
        Ok(x) if x.is_finite() => Ok(x),
        _ if cell.contains(',') && cell.replacen(',', ".", 1).parse::<f64>().is_ok() => {
            Err(told("is no number: write decimal points, not commas"))
        }
        _ => Err(told("is no number: leave out the row, or give the value")),
    }
}

/// Angle in a row's column, degrees, which must be in a range.
pub(super) fn degrees_within(
    header: &StringRecord,
    record: &StringRecord,
    column: usize,
    [least, most]: [f64; 2],
) -> Result<f64, String> {
    let x = number(header, record, column)?;
    if (least..=most).contains(&x) {
        Ok(x)
    } else {
        Err(told(header, record, column, &format!("is out of range: must be {least} to {most} deg")))
    }
}

/// Fault of the cell of a row's column, with its place.
fn told(header: &StringRecord, record: &StringRecord, column: usize, why: &str) -> String {
    let name = header.get(column).unwrap_or_default();
    let cell = record.get(column).unwrap_or_default();
    format!("line {}: column {name}: {cell:?} {why}", line(record))
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

/// A table's rows, whatever stands between its columns.
pub(super) fn table(text: &str) -> csv::Reader<&[u8]> {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(delimiter(text)).comment(Some(b'#')).trim(csv::Trim::All).flexible(false);
    builder.from_reader(text.as_bytes())
}

/// Character between the columns: the one of comma, semicolon and tab that the header has most of.
fn delimiter(text: &str) -> u8 {
    let header = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let count = |delimiter: &u8| header.bytes().filter(|byte| byte == delimiter).count();
    // The last of equal ones is taken: comma.
    [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',')
}

/// Value that a line `# key = value` states; capitals do not count.
pub(super) fn stated<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix('#')?.split_once('='));
    lines.find(|(name, _)| name.trim().eq_ignore_ascii_case(key)).map(|(_, value)| value.trim())
}

/// Refuses two columns of one meaning among those that are `read`. `named` has the header's columns by their meaning.
pub(super) fn each_once<'a>(
    header: &StringRecord,
    named: &[String],
    read: impl IntoIterator<Item = &'a str>,
) -> Result<(), String> {
    for name in read {
        let mut of_name = header.iter().zip(named).filter(|(_, named)| *named == name).map(|(written, _)| written);
        if let (Some(first), Some(second)) = (of_name.next(), of_name.next()) {
            return Err(format!("columns {first:?} and {second:?} are both {name}: leave out one of them"));
        }
    }
    Ok(())
}

/// Refuses two complete groups of columns of one quantity, which differ in unit or sign. `named` has the header's
/// columns by their meaning.
pub(super) fn one_group<'a>(
    header: &StringRecord,
    named: &[String],
    quantity: &str,
    groups: impl IntoIterator<Item = &'a [&'a str]>,
) -> Result<(), String> {
    let find = |name: &&str| header.iter().zip(named).find(|(_, named)| named == name).map(|(written, _)| written);
    let written = |group: &[&str]| Some(group.iter().map(find).collect::<Option<Vec<_>>>()?.join(", "));
    let mut complete = groups.into_iter().filter_map(written);
    if let (Some(first), Some(second)) = (complete.next(), complete.next()) {
        return Err(format!("columns {first:?} and {second:?} are both {quantity}: leave out one of them"));
    }
    Ok(())
}
