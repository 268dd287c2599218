//! A table as a Parquet file: every column may be null, rows are written in groups, and the file appears when
//! it is whole.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use parquet::{
    basic::{Compression, ConvertedType, Repetition, Type as Physical},
    data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type},
    errors::ParquetError,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::types::Type,
};
use serde_json::Value;
use tempfile::NamedTempFile;

use super::schema::{Column, Kind, RECORDINGS, STATIONS, WINDOWS, single};
use testbed::failure::Failure;

/// Rows that are held in memory.
const GROUP: usize = 10_000;

/// Files of the three tables of a batch: `results`, and beside it those of windows and of stations.
#[must_use]
pub fn tables(results: &Path) -> [PathBuf; 3] {
    let beside = |name: &str| results.with_extension(format!("{name}.parquet"));
    [results.to_owned(), beside("windows"), beside("stations")]
}

/// The three tables of a batch.
pub struct Tables([Table; 3]);

impl Tables {
    /// Begins `results`, and beside it the tables of windows and of stations.
    pub fn create(results: &Path) -> Result<Self, Failure> {
        let [results, windows, stations] = tables(results);
        Ok(Self([
            Table::create(results, RECORDINGS)?,
            Table::create(windows, WINDOWS)?,
            Table::create(stations, STATIONS)?,
        ]))
    }

    /// Adds the rows of a recording.
    pub fn push(&mut self, rows: &[Vec<Value>; 3]) -> Result<(), Failure> {
        let mut all = self.0.iter_mut().zip(rows);
        all.try_for_each(|(table, rows)| rows.iter().try_for_each(|row| table.push(row)))
    }

    /// Gives the files their names.
    pub fn finish(self) -> Result<(), Failure> {
        self.0.into_iter().try_for_each(Table::finish)
    }
}

/// A table that is being written.
struct Table {
    path: PathBuf,
    columns: Vec<(String, String, Kind)>,
    held: Vec<Values>,
    rows: usize,
    writer: SerializedFileWriter<NamedTempFile>,
}

/// Values of a column in the group; the levels are 1 where there is one.
struct Values {
    levels: Vec<i16>,
    values: Held,
}

enum Held {
    Text(Vec<ByteArray>),
    Count(Vec<i64>),
    Number(Vec<f64>),
    Flag(Vec<bool>),
}

impl Values {
    fn new(kind: Kind) -> Self {
        let values = match kind {
            Kind::Text => Held::Text(Vec::new()),
            Kind::Count => Held::Count(Vec::new()),
            Kind::Number => Held::Number(Vec::new()),
            Kind::Flag => Held::Flag(Vec::new()),
        };
        Self { levels: Vec::new(), values }
    }

    fn push(&mut self, value: Option<&Value>) {
        let there = match &mut self.values {
            Held::Text(held) => value.and_then(Value::as_str).map(|text| held.push(text.into())),
            Held::Count(held) => value.and_then(Value::as_i64).map(|count| held.push(count)),
            Held::Number(held) => value.and_then(Value::as_f64).map(|number| held.push(number)),
            Held::Flag(held) => value.and_then(Value::as_bool).map(|flag| held.push(flag)),
        };
        self.levels.push(i16::from(there.is_some()));
    }
}

impl Table {
    /// Begins the table of `results`, or the one beside it that is called `name`.
    fn create(path: PathBuf, columns: &[Column]) -> Result<Self, Failure> {
        let columns = single(columns);
        let failed = |error: &dyn std::fmt::Display| Failure::Output { path: path.clone(), why: error.to_string() };
        let field = |(name, _, kind): &(String, String, Kind)| {
            let (physical, converted) = match kind {
                Kind::Text => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
                Kind::Count => (Physical::INT64, ConvertedType::NONE),
                Kind::Number => (Physical::DOUBLE, ConvertedType::NONE),
                Kind::Flag => (Physical::BOOLEAN, ConvertedType::NONE),
            };
            let builder = Type::primitive_type_builder(name, physical).with_converted_type(converted);
            builder.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
        };
        let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>().map_err(|error| failed(&error))?;
        let schema =
            Type::group_type_builder("meerkat_mwd").with_fields(fields).build().map_err(|error| failed(&error))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = NamedTempFile::new_in(folder).map_err(|error| failed(&error))?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let writer =
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map_err(|error| failed(&error))?;
        let held = columns.iter().map(|(_, _, kind)| Values::new(*kind)).collect();
        Ok(Self { path, columns, held, rows: 0, writer })
    }

    /// Adds a row.
    fn push(&mut self, row: &Value) -> Result<(), Failure> {
        for ((_, pointer, _), held) in self.columns.iter().zip(&mut self.held) {
            held.push(row.pointer(pointer));
        }
        self.rows += 1;
        if self.rows == GROUP { self.group() } else { Ok(()) }
    }

    fn failed(&self, error: &dyn std::fmt::Display) -> Failure {
        Failure::Output { path: self.path.clone(), why: error.to_string() }
    }

    fn group(&mut self) -> Result<(), Failure> {
        let new: Vec<Values> = self.columns.iter().map(|(_, _, kind)| Values::new(*kind)).collect();
        let held = std::mem::replace(&mut self.held, new);
        self.rows = 0;
        write(&mut self.writer, &held).map_err(|error| self.failed(&error))
    }

    /// Writes what is held, and gives the file its name.
    fn finish(mut self) -> Result<(), Failure> {
        if self.rows > 0 {
            self.group()?;
        }
        let path = self.path.clone();
        let failed = |error: &dyn std::fmt::Display| Failure::Output { path: path.clone(), why: error.to_string() };
        let file = self.writer.into_inner().map_err(|error| failed(&error))?;
        file.persist(&path).map_err(|error| failed(&error.error)).map(|_| ())
    }
}

fn write(writer: &mut SerializedFileWriter<NamedTempFile>, held: &[Values]) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for Values { levels, values } in held {
        let Some(mut column) = group.next_column()? else { break };
        match values {
            Held::Text(values) => column.typed::<ByteArrayType>().write_batch(values, Some(levels), None)?,
            Held::Count(values) => column.typed::<Int64Type>().write_batch(values, Some(levels), None)?,
            Held::Number(values) => column.typed::<DoubleType>().write_batch(values, Some(levels), None)?,
            Held::Flag(values) => column.typed::<BoolType>().write_batch(values, Some(levels), None)?,
        };
        column.close()?;
    }
    group.close().map(|_| ())
}
