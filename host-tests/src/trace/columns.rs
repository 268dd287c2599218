//! Which cell of a row is what.

use super::error::{Fault, Located, quoted};

/// What a column holds; the index is the axis or the quaternion's component.
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

/// Columns that come together. Without one of a required group there is no trace; an optional group is there or not,
/// but a part of it is a mistake.
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
    /// Name and quantity of each column, in the row's order.
    pub cells: Vec<(&'static str, Quantity)>,
    /// Names of the columns that nothing reads.
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

/// The cells of a row, without blanks and without a pair of quotes around each. Quotes matter only where a program writes
/// them around everything; no number holds a comma.
pub(super) fn cells(row: &str) -> impl Iterator<Item = &str> {
    row.split(',').map(|cell| {
        let cell = cell.trim();
        cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell)
    })
}
