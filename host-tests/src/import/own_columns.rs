//! Columns that only this program's traces have: flags of the driver, motion and rest.

use meerkat_mwd::SampleFlags;

use super::{resolve::Resolved, series::Series, table::Table};

/// Columns of one of this program's traces, a value for each of the gyro's readings; `None` without the column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnColumns {
    /// Flags that the driver set.
    pub sample_flags: Option<Vec<SampleFlags>>,
    /// True if a sample is scored.
    pub movement: Option<Vec<bool>>,
    /// True if the probe rests.
    pub rest: Option<Vec<bool>>,
}

/// Columns that a trace's table has at least; another logger's `rest` may be anything.
const OF_A_TRACE: [&str; 7] = ["t_s", "gx", "gy", "gz", "ax", "ay", "az"];

const FLAGS: &str = "sample_flags";
const MOVEMENT: &str = "movement";
const REST: &str = "rest";

impl OwnColumns {
    /// The columns of the gyro's table, if that is one of a trace; the gyro's part and readings come first.
    #[must_use]
    pub fn of(tables: &[Table], parts: &[Resolved], all: &[Series]) -> Self {
        let Some((part, gyro)) = parts.first().zip(all.first()) else { return Self::default() };
        let Some(table) = tables.iter().find(|table| Some(&table.name) == part.part.table.as_ref()) else {
            return Self::default();
        };
        let exact = |name: &str| table.columns.iter().find(|column| column.name == name);
        if OF_A_TRACE.iter().any(|name| exact(name).is_none()) {
            return Self::default();
        }
        // Numbers of the gyro's rows; none if a cell is no number.
        let cells = |name: &str| {
            let column = exact(name).filter(|column| column.not_a_number.is_none())?;
            Some(gyro.places.iter().map(|place| column.values.get(*place).copied().unwrap_or(f64::NAN)))
        };
        // As in a trace: an empty cell is no flag, no motion and no rest.
        let is_one = |name| Some(cells(name)?.map(|value| value == 1.0).collect());
        let flags = |value: f64| {
            let bits = if value.is_nan() { 0.0 } else { value };
            let is_whole = bits.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&bits);
            SampleFlags::from_bits(bits as u16).filter(|_| is_whole)
        };
        Self {
            sample_flags: cells(FLAGS).and_then(|cells| cells.map(flags).collect()),
            movement: is_one(MOVEMENT),
            rest: is_one(REST),
        }
    }

    /// Leaves out the first rows.
    pub fn drop_first(&mut self, rows: usize) {
        self.sample_flags.iter_mut().for_each(|flags| drop(flags.drain(..rows)));
        [&mut self.movement, &mut self.rest].into_iter().flatten().for_each(|column| drop(column.drain(..rows)));
    }

    /// Names of the columns that are there.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let is_there =
            [(FLAGS, self.sample_flags.is_some()), (MOVEMENT, self.movement.is_some()), (REST, self.rest.is_some())];
        is_there.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name)
    }
}
