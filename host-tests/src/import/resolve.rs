//! The whole map of a source: what the user's map says, and for the rest a guess from names, values and
//! rates, each with its reason.

use std::collections::BTreeMap;

use super::{
    column_map::{ColumnMap, Part},
    median::median,
    names::{Meaning, meaning},
    table::{TOLD, Table, listed},
    time_stamps::{Clock, inherit, time},
    units::{Quantity, STANDARD_GRAVITY, foreign_unit},
};
use testbed::failure::Failure;

/// One sensor's part of the map with its reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The sensor.
    pub quantity: Quantity,
    /// Its part of the map, with nothing left open.
    pub part: Part,
    /// Why this unit.
    pub unit_why: String,
    /// Why this unit of time.
    pub time_why: String,
}

/// Choice that the names of a table's columns leave: the columns of each group of axes.
type Groups = BTreeMap<(u8, usize, String), Vec<Option<String>>>;

/// Number of columns of a quantity.
const fn width(quantity: Quantity) -> usize {
    match quantity {
        Quantity::Temperature => 1,
        Quantity::Reference => 4,
        _ => 3,
    }
}

/// Sensors in the order in which they are printed, with their names in a map.
pub const SENSORS: [(Quantity, &str); 5] = [
    (Quantity::Gyro, "gyro"),
    (Quantity::Accel, "accel"),
    (Quantity::Mag, "mag"),
    (Quantity::Temperature, "temperature"),
    (Quantity::Reference, "reference"),
];

/// Name of a sensor in a map.
#[must_use]
pub fn name(quantity: Quantity) -> &'static str {
    SENSORS.iter().find(|(known, _)| *known == quantity).map_or("time", |(_, name)| name)
}

/// Name of a sensor in a message.
#[must_use]
pub const fn in_words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Gyro => "gyro",
        Quantity::Accel => "accelerometer",
        Quantity::Mag => "magnetometer",
        Quantity::Temperature => "thermometer",
        Quantity::Reference => "reference attitude",
        Quantity::Time => "time",
    }
}

impl ColumnMap {
    /// The part of a sensor.
    #[must_use]
    pub fn part(&self, quantity: Quantity) -> &Part {
        match quantity {
            Quantity::Accel => &self.accel,
            Quantity::Mag => &self.mag,
            Quantity::Temperature => &self.temperature,
            Quantity::Reference => &self.reference,
            Quantity::Gyro | Quantity::Time => &self.gyro,
        }
    }

    /// The same, to be set.
    pub fn part_mut(&mut self, quantity: Quantity) -> &mut Part {
        match quantity {
            Quantity::Accel => &mut self.accel,
            Quantity::Mag => &mut self.mag,
            Quantity::Temperature => &mut self.temperature,
            Quantity::Reference => &mut self.reference,
            Quantity::Gyro | Quantity::Time => &mut self.gyro,
        }
    }
}

/// The parts of all sensors that the source has.
///
/// # Errors
/// A required sensor is not found, or a name or unit of the user's map is not there; the message lists what
/// is.
pub fn resolve(tables: &[Table], user: &ColumnMap) -> Result<Vec<Resolved>, Failure> {
    let mut parts: Vec<Resolved> = Vec::new();
    for (quantity, sensor) in SENSORS {
        let required = matches!(quantity, Quantity::Gyro | Quantity::Accel);
        let given = user.part(quantity);
        let found = columns(tables, quantity, given)
            .map_err(|why| Failure::BadInput(format!("[{sensor}] of the map: {why}")))?;
        let Some((table, columns)) = found else {
            if required {
                return Err(Failure::BadInput(not_found(tables, sensor)));
            }
            continue;
        };
        let bad = |why: String| Failure::BadInput(format!("[{sensor}] {}: {why}", table.name));
        let mut part = Part { table: Some(table.name.clone()), columns: Some(columns), ..given.clone() };
        let (unit, unit_why) = unit(table, quantity, &part).map_err(bad)?;
        part.unit = Some(unit);
        let of_gyro = parts.first().map(|gyro| &gyro.part).filter(|gyro| gyro.table == part.table);
        let inherited = of_gyro.and_then(|gyro| inherit(table, quantity, &mut part, gyro, &user.gyro));
        let gyro = parts.first().and_then(|gyro| Clock::of(tables, &gyro.part));
        let time_why = time(table, quantity, &mut part, gyro.as_ref()).map_err(bad)?;
        let time_why = inherited.map_or(time_why, str::to_owned);
        parts.push(Resolved { quantity, part, unit_why, time_why });
    }
    Ok(parts)
}

/// The column that a name of a map means, without its sign.
#[must_use]
pub fn unsigned(name: &str) -> &str {
    let name = name.trim();
    name.strip_prefix(['-', '+']).unwrap_or(name).trim()
}

fn columns<'a>(
    tables: &'a [Table],
    quantity: Quantity,
    given: &Part,
) -> Result<Option<(&'a Table, Vec<String>)>, String> {
    let of_name = |name: &str| tables.iter().find(|table| table.name.eq_ignore_ascii_case(name));
    let table = match &given.table {
        Some(name) => Some(of_name(name).ok_or_else(|| {
            format!(
                "there is no table {name:?}; there are {}",
                listed(tables.iter().map(|table| table.name.as_str()), TOLD)
            )
        })?),
        None => None,
    };
    let among: Vec<&Table> = table.map_or_else(|| tables.iter().collect(), |table| vec![table]);
    if let Some(names) = &given.columns {
        if names.len() != width(quantity) {
            return Err(format!("columns must name {} columns, not {}", width(quantity), names.len()));
        }
        // A name with a minus may be a column's own name.
        let has = |table: &Table, name: &str| table.column(name).or_else(|| table.column(unsigned(name))).is_some();
        let holder = among.iter().find(|table| names.iter().all(|name| has(table, name)));
        return match holder {
            Some(holder) => Ok(Some((holder, names.clone()))),
            None => {
                let missing =
                    names.iter().find(|name| !among.iter().any(|table| has(table, name))).unwrap_or(&names[0]);
                let there = among.iter().flat_map(|table| table.names());
                Err(format!("there is no column {missing:?}; there are {}", listed(there, TOLD)))
            }
        };
    }
    let mut groups = Groups::new();
    for (index, table) in among.iter().enumerate() {
        for column in table.columns.iter().filter(|column| column.values.iter().any(|value| value.is_finite())) {
            let Some(Meaning { quantity: told, axis, group, rank }) = meaning(&table.name, &column.name) else {
                continue;
            };
            if told == quantity && !column.is_clock {
                let axes = groups.entry((rank, index, group)).or_insert_with(|| vec![None; width(quantity)]);
                if let Some(place @ None) = axes.get_mut(axis) {
                    *place = Some(column.name.clone());
                }
            }
        }
    }
    let whole = groups
        .into_iter()
        .find_map(|((_, index, _), axes)| Some((index, axes.into_iter().collect::<Option<Vec<_>>>()?)));
    Ok(whole.map(|(index, columns)| (among[index], columns)))
}

fn not_found(tables: &[Table], sensor: &str) -> String {
    let columns = tables.iter().map(|table| format!("\n  {}: {}", table.name, listed(table.names(), TOLD)));
    format!(
        "no columns of the {sensor} are known by their names; name them in a file for --map, for instance\n  \
         [{sensor}]\n  columns = [\"x\", \"y\", \"z\"]\nThere are{}",
        columns.collect::<String>()
    )
}

/// The three values of a row; `None` unless all are there.
fn rows(table: &Table, part: &Part) -> Vec<[f64; 3]> {
    let names = part.columns.as_deref().unwrap_or_default();
    let columns: Vec<_> =
        names.iter().filter_map(|name| table.column(name).or_else(|| table.column(unsigned(name)))).collect();
    let row = |index: usize| -> [f64; 3] {
        std::array::from_fn(|axis| {
            columns.get(axis).and_then(|column| column.values.get(index)).copied().unwrap_or(f64::NAN)
        })
    };
    (0..table.rows()).map(row).filter(|row| row.iter().all(|value| value.is_finite())).collect()
}

fn by_the_map(part: &Part) -> String {
    part.scale.map_or_else(|| "by the map".into(), |scale| format!("{scale} of it in one count, by the map"))
}

/// A note if a sensor's unit is known by its size alone although its columns name one, which is none.
fn guessed(table: &str, part: &Resolved) -> Option<String> {
    let named = part.part.columns.iter().flatten().map(|name| unsigned(name)).find_map(foreign_unit)?;
    let unit = part.part.unit.as_deref().unwrap_or_default();
    part.unit_why.starts_with("by its size").then(|| {
        format!(
            "the unit of the {} is a guess: {named:?} is no unit, and {unit} was taken {}. Counts in {table} have their size \
             by `scale = ...` in [{}] of --map: so many {} in one count",
            in_words(part.quantity),
            part.unit_why,
            name(part.quantity),
            part.quantity.units().first().map_or("", |unit| unit.name)
        )
    })
}

/// Notes on units that are guesses.
#[must_use]
pub fn guesses(parts: &[Resolved]) -> Vec<String> {
    parts.iter().filter_map(|part| guessed(part.part.table.as_deref().unwrap_or_default(), part)).collect()
}

/// The unit of a sensor's columns, with the reason.
fn unit(table: &Table, quantity: Quantity, part: &Part) -> Result<(String, String), String> {
    let known = || quantity.units().iter().map(|unit| unit.name).collect::<Vec<_>>();
    // The first is the trace's.
    let of_trace = known().first().copied().unwrap_or_default();
    if let Some(scale) = part.scale.filter(|scale| !(scale.is_finite() && *scale > 0.0)) {
        return Err(format!(
            "scale must be a positive number, not {scale}; a minus before a column's name turns its sign"
        ));
    }
    if let Some(given) = &part.unit {
        let unit = quantity.unit(given).ok_or_else(|| {
            format!(
                "unit {given:?} is not known; known are {}. For counts without a unit leave it out and give `scale = ...`, \
                 the {of_trace} in one count",
                known().join(", ")
            )
        })?;
        return Ok((unit.name.to_owned(), by_the_map(part)));
    }
    if part.scale.is_some() {
        return Ok((of_trace.to_owned(), by_the_map(part)));
    }
    let names = part.columns.iter().flatten().map(|name| unsigned(name));
    if let Some(unit) = names.chain([table.name.as_str()]).find_map(|name| quantity.unit_in(name)) {
        return Ok((unit.name.to_owned(), "by its name".into()));
    }
    let norms = rows(table, part).into_iter().map(|row| row.iter().map(|x| x * x).sum::<f64>().sqrt());
    let typical = median(norms.filter(|norm| norm.is_finite()));
    let by_value = |expected: f64, candidates: &[&'static str]| {
        let typical = typical?;
        let distance = |name: &&&str| {
            let factor = quantity.unit(name).map_or(1.0, |unit| unit.factor);
            (typical * factor / expected).ln().abs()
        };
        let name = candidates.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some(((*name).to_owned(), format!("by its size: the median norm is {typical:.4}")))
    };
    let guessed = match quantity {
        Quantity::Accel => by_value(STANDARD_GRAVITY, &["m/s^2", "g", "mg"]),
        // The middle of what the earth's field can be.
        Quantity::Mag => by_value(45.0, &["uT", "nT", "gauss", "mgauss", "T"]),
        // Told below from the vectors; a hand or a string that turns at over 35 rad/s is none.
        Quantity::Gyro => rows(table, part).iter().flatten().map(|x| x.abs()).reduce(f64::max).map(|largest| {
            let name = if largest > 35.0 { "deg/s" } else { "rad/s" };
            (name.to_owned(), format!("by its size: the largest rate is {largest:.3}"))
        }),
        Quantity::Temperature => Some(("degC".into(), "taken for granted".into())),
        Quantity::Reference | Quantity::Time => Some(("1".into(), String::new())),
    };
    guessed.ok_or_else(|| "no row has all its values".into())
}
