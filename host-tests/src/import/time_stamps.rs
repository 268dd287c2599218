//! Time stamps of a sensor: which column they are, and in which unit.

use super::{
    column_map::Part,
    median::median,
    names::{is_time, sensor_of},
    table::{Column, TOLD, Table, listed},
    units::Quantity,
};

/// Units of time stamps that are guessed.
const UNITS: [&str; 4] = ["s", "ms", "us", "ns"];

/// Clock of the gyro, by which the unit of another sensor's time stamps is told.
pub(super) struct Clock<'a> {
    table: &'a Table,
    /// Column of the time stamps; `None` for rows of a given rate.
    column: Option<&'a Column>,
    /// Unit of the time stamps; `None` for clock times.
    unit: Option<&'static str>,
    /// Time from its first row to its last, seconds.
    span_s: f64,
}

impl<'a> Clock<'a> {
    /// The clock of a sensor; `None` if it tells no time.
    pub fn of(tables: &'a [Table], part: &Part) -> Option<Self> {
        let table = tables.iter().find(|table| Some(&table.name) == part.table.as_ref())?;
        let column = part.time.as_deref().filter(|_| part.rate_hz.is_none()).and_then(|time| table.column(time));
        let unit = part.time_unit.as_deref().and_then(|unit| Quantity::Time.unit(unit));
        let span_s = match (part.rate_hz, column) {
            (Some(rate), _) => table.rows().saturating_sub(1) as f64 / rate,
            (None, column) => span(&column?.values)? * unit.map_or(1.0, |unit| unit.factor),
        };
        (span_s > 0.0).then_some(Self { table, column, unit: unit.map(|unit| unit.name), span_s })
    }

    /// The unit in which a column's span agrees best with the gyro's, with the reason. The step of a slow sensor does
    /// not tell it: 0.5 is that of 2 Hz in seconds and of 2 kHz in milliseconds.
    fn unit_of(&self, table: &Table, column: &Column) -> Option<(&'static str, String)> {
        if self.table.name == table.name && self.column.is_some_and(|own| own.name == column.name) {
            return Some((self.unit?, "as of the gyro".to_owned()));
        }
        let span = span(&column.values).filter(|span| *span > 0.0)?;
        let in_s = |unit: &str| span * factor(unit);
        let apart = |unit: &str| (in_s(unit) / self.span_s).ln().abs();
        let unit = UNITS.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        Some((unit, format!("by its span of {:.3} s, where the gyro's is {:.3} s", in_s(unit), self.span_s)))
    }
}

fn factor(unit: &str) -> f64 {
    Quantity::Time.unit(unit).map_or(1.0, |unit| unit.factor)
}

/// Difference of the last and the first value of a column.
fn span(values: &[f64]) -> Option<f64> {
    let mut there = values.iter().filter(|value| value.is_finite());
    let first = there.next()?;
    Some(there.next_back()? - first)
}

/// Gives a sensor of the gyro's table the time or the rate that the user's map gives the gyro, and returns why; `None`
/// if the map gives the sensor one, or the table has a time that names the sensor.
pub(super) fn inherit(
    table: &Table,
    quantity: Quantity,
    part: &mut Part,
    gyro: &Part,
    user_gyro: &Part,
) -> Option<&'static str> {
    let is_given = part.time.is_some() || part.rate_hz.is_some();
    let has_own = || time_column(table, quantity).is_ok_and(|name| sensor_of(&name) == Some(quantity));
    if is_given || (user_gyro.time.is_none() && user_gyro.rate_hz.is_none()) || has_own() {
        return None;
    }
    (part.time, part.rate_hz) = (gyro.time.clone(), gyro.rate_hz);
    if part.time_unit.is_none() {
        part.time_unit.clone_from(&gyro.time_unit);
    }
    Some("as of the gyro")
}

/// Sets the time of a part, and says why; `gyro` is the clock of the gyro, for the sensors after it.
pub(super) fn time(table: &Table, quantity: Quantity, part: &mut Part, gyro: Option<&Clock>) -> Result<String, String> {
    if let Some(rate) = part.rate_hz {
        return if rate > 0.0 { Ok("by the map".into()) } else { Err(format!("rate_hz must be positive, not {rate}")) };
    }
    let name = match &part.time {
        Some(name) => name.clone(),
        None => time_column(table, quantity)?,
    };
    let column = table.column(&name).ok_or_else(|| {
        format!("there is no column {name:?} for the time; there are {}", listed(table.names(), TOLD))
    })?;
    let (unit, reason) = match (&part.time_unit, column.is_clock, Quantity::Time.unit_in(&name)) {
        (_, true, _) => ("clock", "clock times".to_owned()),
        (Some(given), ..) => {
            let unit = Quantity::Time
                .unit(given)
                .ok_or_else(|| format!("time_unit {given:?} is not known; known are s, ms, us, ns, min"))?;
            (unit.name, "by the map".to_owned())
        }
        (None, false, Some(unit)) => step(column).map(|_| (unit.name, "by its name".to_owned()))?,
        (None, false, None) => match gyro.and_then(|gyro| gyro.unit_of(table, column)) {
            Some(told) => told,
            None => by_step(column)?,
        },
    };
    part.time_unit = Some(unit.to_owned());
    part.time = Some(name);
    Ok(reason)
}

/// Steps between the values of a column; a slow sensor's time may stand in some rows only.
fn steps(column: &Column) -> Vec<f64> {
    let there: Vec<f64> = column.values.iter().copied().filter(|value| value.is_finite()).collect();
    there.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Median step of a column.
fn step(column: &Column) -> Result<f64, String> {
    median(steps(column).into_iter().filter(|step| *step > 0.0))
        .ok_or_else(|| format!("column {:?} does not increase: it is no time", column.name))
}

/// The unit of time in which the step of a column is one of a gyro, with the reason.
fn by_step(column: &Column) -> Result<(&'static str, String), String> {
    let step = step(column)?;
    // 5 Hz to 4 kHz: under a factor of a thousand, so that one unit fits.
    let fits = |unit: &&str| (2.5e-4..0.2).contains(&(step * factor(unit)));
    match UNITS.into_iter().find(fits) {
        Some(unit) => Ok((unit, format!("by its step of {step:.6}"))),
        None => {
            Err(format!("column {:?} steps by {step}: no unit of time makes a rate of 5 to 4000 Hz of it", column.name))
        }
    }
}

/// Share of its steps at which a sensor's own time goes forward. With more that do not, the gate would refuse it: it is
/// held between two readings, or no time, such as a `time_accuracy`.
const FORWARD: f64 = 0.95;

/// The column of a sensor's time: of those named so, one that names this sensor, else one that names none. One that
/// names another sensor is this one's only where the table tells no other time.
fn time_column(table: &Table, quantity: Quantity) -> Result<String, String> {
    let named = table.columns.iter().filter(|column| column.is_clock || is_time(&column.name));
    let (own, others): (Vec<&Column>, Vec<&Column>) =
        named.partition(|column| sensor_of(&column.name) == Some(quantity));
    let (of_others, general): (Vec<&Column>, Vec<&Column>) =
        others.into_iter().partition(|column| sensor_of(&column.name).is_some());
    let is_steady = |column: &&Column| forward(column) as f64 >= FORWARD * steps(column).len() as f64;
    let steady: Vec<&Column> = own.iter().copied().filter(is_steady).collect();
    if let Some(name) = [steady, general, own].iter().find_map(|columns| most_increasing(columns)) {
        return Ok(name);
    }
    let differ = |pair: &[&Column]| pair[0].values.iter().zip(&pair[1].values).any(|(a, b)| a.total_cmp(b).is_ne());
    if of_others.windows(2).any(differ) {
        let names = listed(of_others.iter().map(|column| column.name.as_str()), TOLD);
        return Err(format!(
            "the columns of time, {names}, are of other sensors; name this one's by `time = \"...\"` in --map"
        ));
    }
    most_increasing(&of_others).ok_or_else(|| {
        "no column is known as time by its name; name it by `time = \"...\"` in --map, or the rate of its rows by `rate_hz = ...`"
            .to_owned()
    })
}

/// Number of steps at which a column increases.
fn forward(column: &Column) -> usize {
    steps(column).into_iter().filter(|step| *step > 0.0).count()
}

/// The column that increases at most rows; between equals the first.
fn most_increasing(columns: &[&Column]) -> Option<String> {
    let mut best: Option<(usize, &str)> = None;
    for column in columns {
        let count = forward(column);
        if count > 0 && best.is_none_or(|(most, _)| count > most + most / 100) {
            best = Some((count, &column.name));
        }
    }
    best.map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: [&str; 3]) -> Table {
        // The second is held between the readings of a slow sensor.
        let values: [fn(usize) -> f64; 3] = [|row| row as f64, |row| (row / 6) as f64, |row| row as f64 + 0.5];
        let column = |(name, value): (&str, fn(usize) -> f64)| Column::of(name, (0..100).map(value).collect());
        Table { columns: names.into_iter().zip(values).map(column).collect(), ..Table::default() }
    }

    #[test]
    fn a_time_that_is_held_between_readings_is_not_preferred() {
        let of = |names, quantity| time_column(&table(names), quantity);
        let with_a_general_one = ["time", "time_mag", "time_acc"];
        assert_eq!(of(with_a_general_one, Quantity::Accel), Ok("time_acc".to_owned()));
        assert_eq!(of(with_a_general_one, Quantity::Mag), Ok("time".to_owned()));
        assert_eq!(of(with_a_general_one, Quantity::Gyro), Ok("time".to_owned()));
        assert_eq!(of(["a", "time_mag", "b"], Quantity::Mag), Ok("time_mag".to_owned()));
        assert_eq!(of(["a", "time_mag", "b"], Quantity::Gyro), Ok("time_mag".to_owned()), "the only one");
        assert!(of(["time_gyr", "time_mag", "b"], Quantity::Accel).is_err());
    }
}
