//! Parquet: a table as Arrow, pandas, Spark and DuckDB write it; groups and short lists as columns of their own.

use std::{collections::BTreeMap, fs::File};

use parquet::{
    file::reader::{FileReader, SerializedFileReader},
    record::{Field, Row},
};

use super::table::{Column, Table};

/// First bytes of such a file.
pub const MAGIC: &[u8] = b"PAR1";
/// Elements of a list that become columns.
const LISTED: usize = 16;

/// Reads a file.
///
/// # Errors
/// Description of what is wrong with the file.
pub fn read(file: File, name: &str) -> Result<Vec<Table>, String> {
    let failed = |error: parquet::errors::ParquetError| format!("the Parquet file cannot be read: {error}");
    let reader = SerializedFileReader::new(file).map_err(failed)?;
    let mut columns: Vec<Column> = Vec::new();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut rows = 0;
    for row in reader.get_row_iter(None).map_err(failed)? {
        let mut numbers = Vec::new();
        group(&row.map_err(failed)?, "", &mut numbers);
        for (path, number) in numbers {
            let next = columns.len();
            let place = *places.entry(path.clone()).or_insert(next);
            if place == next {
                columns.push(Column::of(&path, Vec::new()));
            }
            if let Some(column) = columns.get_mut(place) {
                column.values.resize(rows, f64::NAN);
                match number {
                    Ok(number) => column.values.push(number),
                    Err(text) => {
                        column.values.push(f64::NAN);
                        column.not_numbers += 1;
                        column.not_a_number.get_or_insert((rows as u64 + 1, text));
                    }
                }
            }
        }
        rows += 1;
    }
    for column in &mut columns {
        column.values.resize(rows, f64::NAN);
    }
    if columns.is_empty() || rows == 0 {
        Err("the Parquet file has no row".into())
    } else {
        Ok(vec![Table { name: name.to_owned(), columns, keys: Vec::new() }])
    }
}

type Numbers = Vec<(String, Result<f64, String>)>;

fn group(row: &Row, path: &str, found: &mut Numbers) {
    for (name, field) in row.get_column_iter() {
        let name = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        value(field, name, found);
    }
}

fn value(field: &Field, path: String, found: &mut Numbers) {
    let number = match field {
        Field::Null => return,
        Field::Bool(is) => f64::from(u8::from(*is)),
        Field::Byte(x) => f64::from(*x),
        Field::Short(x) => f64::from(*x),
        Field::Int(x) => f64::from(*x),
        Field::Long(x) => *x as f64,
        Field::UByte(x) => f64::from(*x),
        Field::UShort(x) => f64::from(*x),
        Field::UInt(x) => f64::from(*x),
        Field::ULong(x) => *x as f64,
        Field::Float16(x) => f64::from(x.to_f32()),
        Field::Float(x) => f64::from(*x),
        Field::Double(x) => *x,
        // The format's own clocks.
        Field::TimeMillis(x) => return found.push((format!("{path} [ms]"), Ok(f64::from(*x)))),
        Field::TimestampMillis(x) => return found.push((format!("{path} [ms]"), Ok(*x as f64))),
        Field::TimeMicros(x) | Field::TimestampMicros(x) => {
            return found.push((format!("{path} [us]"), Ok(*x as f64)));
        }
        Field::Group(row) => return group(row, &path, found),
        Field::ListInternal(list) => {
            let elements = list.elements();
            if elements.len() <= LISTED {
                for (index, element) in elements.iter().enumerate() {
                    value(element, format!("{path}[{index}]"), found);
                }
            }
            return;
        }
        other => return found.push((path, Err(other.to_string()))),
    };
    found.push((path, Ok(number)));
}
