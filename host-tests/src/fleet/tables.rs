//! Tables of a batch, read back.

use std::{fs::File, path::Path};

use parquet::{
    errors::ParquetError,
    file::reader::{FileReader, SerializedFileReader},
    record::Field,
};
use serde_json::Value;

use super::Row;
use testbed::failure::Failure;

/// All rows of a Parquet file. What is null is left out.
pub(super) fn rows(path: &Path) -> Result<Vec<Row>, Failure> {
    let bad = |why: String| Failure::BadInput(format!("{}: {why}", path.display()));
    let file = File::open(path).map_err(|error| Failure::unread(path, &error))?;
    read(file).map_err(|error| bad(format!("is no table of a batch: {error}")))
}

fn read(file: File) -> Result<Vec<Row>, ParquetError> {
    let reader = SerializedFileReader::new(file)?;
    let row = |row: Result<parquet::record::Row, ParquetError>| {
        let row = row?;
        let cells = row.get_column_iter().filter_map(|(name, field)| Some((name.clone(), value(field)?)));
        Ok(cells.collect())
    };
    reader.get_row_iter(None)?.map(row).collect()
}

/// Value of a field, if it is of a kind that a batch writes.
fn value(field: &Field) -> Option<Value> {
    match field {
        Field::Bool(flag) => Some((*flag).into()),
        Field::Long(count) => Some((*count).into()),
        Field::Double(number) => Some((*number).into()),
        Field::Str(text) => Some(text.as_str().into()),
        _ => None,
    }
}
