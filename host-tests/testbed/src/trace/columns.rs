//! Columns of a trace: which cell of a row holds what.

use super::error::{Fault, Located, quoted};

/// Quantity of a column; the index is the axis or the quaternion's component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Gyro(usize),
    Accel(usize),
    Mag(usize),
    Temperature,
    Reference(usize),
    Movement,
    Rest,
    TrueRate(usize),
    DriverFlags,
    Ignored,
}

/// Groups of columns that come together. A required group must be there; an optional one may be absent, but
/// not in part.
const GROUPS: [(&[(&str, Quantity)], bool); 10] = [
    (&[("t_s", Quantity::Time)], true),
    (&[("gx", Quantity::Gyro(0)), ("gy", Quantity::Gyro(1)), ("gz", Quantity::Gyro(2))], true),
    (&[("ax", Quantity::Accel(0)), ("ay", Quantity::Accel(1)), ("az", Quantity::Accel(2))], true),
    (&[("mx", Quantity::Mag(0)), ("my", Quantity::Mag(1)), ("mz", Quantity::Mag(2))], false),
    (&[("temp_c", Quantity::Temperature)], false),
    (
        &[
            ("qw", Quantity::Reference(0)),
            ("qx", Quantity::Reference(1)),
            ("qy", Quantity::Reference(2)),
            ("qz", Quantity::Reference(3)),
        ],
        false,
    ),
    (&[("movement", Quantity::Movement)], false),
    (&[("rest", Quantity::Rest)], false),
    (&[("sample_flags", Quantity::DriverFlags)], false),
    (
        &[("wx_true", Quantity::TrueRate(0)), ("wy_true", Quantity::TrueRate(1)), ("wz_true", Quantity::TrueRate(2))],
        false,
    ),
];

/// The header row.
#[derive(Debug)]
pub(super) struct Columns {
    /// Name and quantity of each column, in the order of the row.
    pub cells: Vec<(&'static str, Quantity)>,
    /// Names of columns that are not used.
    pub ignored: Vec<String>,
}

impl Columns {
    /// Reads the header row.
    pub fn parse(row: &str, line: u64) -> Result<Self, Located> {
        let mut columns = Self { cells: Vec::new(), ignored: Vec::new() };
        for name in cells(row) {
            let known = GROUPS.iter().flat_map(|(group, _)| group.iter()).find(|(known, _)| *known == name);
            columns.cells.push(known.copied().unwrap_or(("", Quantity::Ignored)));
            if known.is_none() {
                columns.ignored.push(quoted(name));
            }
        }
        if columns.cells.len() == columns.ignored.len() {
            return Err(Fault::NoHeader.at(line));
        }
        for (group, required) in GROUPS {
            let wanted = required || group.iter().any(|&(_, quantity)| columns.has(quantity));
            for &(name, quantity) in group {
                match columns.cells.iter().filter(|cell| cell.1 == quantity).count() {
                    0 if wanted => return Err(Fault::MissingColumn.in_column(line, name)),
                    0 | 1 => {}
                    _ => return Err(Fault::DuplicateColumn.in_column(line, name)),
                }
            }
        }
        Ok(columns)
    }

    pub fn has(&self, quantity: Quantity) -> bool {
        self.cells.iter().any(|cell| cell.1 == quantity)
    }
}

/// Cells of a row, without blanks and without a pair of quotes. Quotes need no more care: no number holds a
/// comma.
pub(super) fn cells(row: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(row);
    std::iter::from_fn(move || {
        let row = rest?;
        // Cells are short: a search by bytes is done before one that is set up for a long text has begun.
        let (cell, behind) = match row.bytes().position(|byte| byte == b',').and_then(|at| row.split_at_checked(at)) {
            Some((cell, behind)) => (cell, behind.get(1..)),
            None => (row, None),
        };
        rest = behind;
        Some(bare(cell))
    })
}

/// A cell without blanks and without a pair of quotes.
fn bare(cell: &str) -> &str {
    let is_of_a_number = |byte: Option<&u8>| matches!(byte, Some(b'0'..=b'9' | b'-'));
    let bytes = cell.as_bytes();
    if is_of_a_number(bytes.first()) && is_of_a_number(bytes.last()) {
        return cell;
    }
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_parts_at_each_comma_and_cells_lose_blanks_and_quotes() {
        let told = |row| cells(row).collect::<Vec<_>>();
        assert_eq!(told("1,-2.5,3"), ["1", "-2.5", "3"]);
        assert_eq!(told(" 1 ,\"2\",, \" 3\" ,\u{a0}4\u{2003},"), ["1", "2", "", " 3", "4", ""]);
        assert_eq!(told(""), [""]);
        assert_eq!(told("\"1,2"), ["\"1", "2"]);
    }
}
