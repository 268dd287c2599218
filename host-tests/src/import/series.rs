//! A sensor's readings in the trace's units on the trace's clock.

use super::{
    resolve::{Resolved, name, unsigned},
    table::{Column, Table},
};
use testbed::{
    failure::Failure,
    trace::{RowOrder, RowPlace},
};

/// Readings of one sensor, in order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Times, microseconds, strictly increasing.
    pub t_us: Vec<i64>,
    /// Readings; NaN where one is missing.
    pub rows: Vec<[f64; 4]>,
    /// Row of the table that each reading stands in.
    pub places: Vec<usize>,
    /// Rows dropped since their time is that of the row before.
    pub repeated: usize,
    /// Rows dropped since their time is before that of the row before, or far ahead of the rows around it.
    pub late: usize,
    /// Rows dropped since they have no time.
    pub without_time: usize,
    /// Name of table and time, by which sensors of one clock are counted once.
    pub clock: (String, String),
}

/// Beyond this a start of time is a date, not a time since the start: the trace's clock starts at zero then.
const DATE_S: f64 = 1e8;

/// The series of a part.
///
/// # Errors
/// A cell that is needed is no number.
pub fn series(tables: &[Table], resolved: &Resolved) -> Result<Series, Failure> {
    let part = &resolved.part;
    let table_name = part.table.clone().unwrap_or_default();
    let bad = |what: String| Failure::BadInput(format!("{table_name}: {what}"));
    let table = tables.iter().find(|table| table.name == table_name).ok_or_else(|| bad("is not there".into()))?;
    let column = |name: &str| {
        let column = table.column(name).ok_or_else(|| bad(format!("there is no column {name:?}")))?;
        match &column.not_a_number {
            Some((line, cell)) => Err(bad(format!(
                "line {line}, column {name}: {cell:?} is not a number ({} such cells)",
                column.not_numbers
            ))),
            None => Ok(column),
        }
    };
    let unit = part.unit.as_deref().and_then(|unit| resolved.quantity.unit(unit));
    let unit = unit.ok_or_else(|| bad(format!("the unit of the {} is not known", name(resolved.quantity))))?;
    let scale = part.scale.unwrap_or(1.0);
    let mut columns = Vec::new();
    for name in part.columns.iter().flatten() {
        // A name that begins with a minus may be a column's own.
        let own = table.column(name).is_some();
        let sign = if !own && name.trim_start().starts_with('-') { -1.0 } else { 1.0 };
        columns.push((column(if own { name } else { unsigned(name) })?, sign));
    }
    let times: Vec<f64> = match (&part.time, part.rate_hz) {
        (_, Some(rate)) => (0..table.rows()).map(|row| row as f64 / rate).collect(),
        (Some(time), None) => {
            let factor = part
                .time_unit
                .as_deref()
                .and_then(|unit| super::units::Quantity::Time.unit(unit))
                .map_or(1.0, |unit| unit.factor);
            column(time)?.values.iter().map(|value| value * factor).collect()
        }
        (None, None) => return Err(bad("has no time".into())),
    };
    let clock = (table_name.clone(), part.time.clone().unwrap_or_else(|| format!("{:?} Hz", part.rate_hz)));
    let mut series = Series { clock, ..Series::default() };
    let added = part.time_offset_s.unwrap_or(0.0);
    let mut order = RowOrder::default();
    for (row, time) in times.iter().enumerate() {
        let value = |column: &Column| column.values.get(row).copied().unwrap_or(f64::NAN);
        if !time.is_finite() {
            // A row of another sensor, with a time of its own.
            if columns.iter().all(|(column, _)| value(column).is_nan()) {
                continue;
            }
            series.without_time += 1;
            continue;
        }
        let t_us = ((time + added) * 1e6).round() as i64;
        if order.shows_last_ahead(t_us) {
            series.drop_last();
            series.late += 1;
        }
        match order.place(t_us) {
            RowPlace::Next => {}
            RowPlace::Repeated => {
                series.repeated += 1;
                continue;
            }
            RowPlace::Late => {
                series.late += 1;
                continue;
            }
        }
        series.t_us.push(t_us);
        series.places.push(row);
        series.rows.push(std::array::from_fn(|axis| {
            columns.get(axis).map_or(0.0, |(column, sign)| sign * (value(column) * scale * unit.factor + unit.offset))
        }));
    }
    if series.t_us.is_empty() {
        return Err(bad("no row has a time".into()));
    }
    Ok(series)
}

impl Series {
    fn drop_last(&mut self) {
        self.t_us.pop();
        self.places.pop();
        self.rows.pop();
    }

    /// Median step, microseconds; 0 for fewer than two rows.
    #[must_use]
    pub fn period_us(&self) -> i64 {
        let mut steps: Vec<i64> = self.t_us.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        if steps.is_empty() { 0 } else { *steps.select_nth_unstable(middle).1 }
    }

    /// Rate, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        1e6 / (self.period_us().max(1)) as f64
    }

    /// Steps of over three periods.
    #[must_use]
    pub fn gaps(&self) -> usize {
        let longest = 3 * self.period_us();
        self.t_us.windows(2).filter(|pair| pair[1] - pair[0] > longest).count()
    }

    /// Rows that were dropped.
    #[must_use]
    pub const fn dropped(&self) -> usize {
        self.repeated + self.late + self.without_time
    }
}

/// Moves all clocks by the same whole seconds, so that a date is not counted in the trace; returns how many
/// seconds.
pub fn start_at_zero<'a>(all: impl Iterator<Item = &'a mut Series>) -> i64 {
    let mut all: Vec<&mut Series> = all.collect();
    let first = all.iter().filter_map(|series| series.t_us.first().copied()).min().unwrap_or(0);
    if first >= 0 && (first as f64) < DATE_S * 1e6 {
        return 0;
    }
    let seconds = first.div_euclid(1_000_000);
    for series in &mut all {
        series.t_us.iter_mut().for_each(|t_us| *t_us -= seconds * 1_000_000);
    }
    seconds
}
