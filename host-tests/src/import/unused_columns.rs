//! Columns that nothing reads, told so that nobody misses them later.

use std::collections::BTreeSet;

use super::{
    column_map::Part,
    own_columns::OwnColumns,
    resolve::{Resolved, unsigned},
    table::{Column, Table, listed},
};
use testbed::failure::Failure;

/// Names that a note tells.
const MOST: usize = 12;

/// Refuses a column that is read and of which its table has two.
///
/// # Errors
/// The table and the name.
pub fn each_once(tables: &[Table], parts: &[Resolved], own: &OwnColumns) -> Result<(), Failure> {
    let of_gyro = parts.first().and_then(|gyro| gyro.part.table.as_ref());
    for table in tables {
        let of_table = parts.iter().map(|part| &part.part).filter(|part| part.table.as_ref() == Some(&table.name));
        let named = of_table.flat_map(|part| part.columns.iter().flatten().chain(&part.time)).map(String::as_str);
        for name in named.chain(own.names().filter(|_| of_gyro == Some(&table.name))) {
            if table.columns.iter().filter(|column| column.name == name || column.name == unsigned(name)).count() > 1 {
                return Err(Failure::BadInput(format!("{}: two columns are named {name}: leave out one", table.name)));
            }
        }
    }
    Ok(())
}

/// A note for each table that something is read of, on the columns that nothing reads.
#[must_use]
pub fn unused_columns(tables: &[Table], parts: &[Resolved], own: &OwnColumns) -> Vec<String> {
    let of_gyro = parts.first().and_then(|gyro| gyro.part.table.as_ref());
    let note = |table: &Table| {
        let of_table: Vec<&Part> =
            parts.iter().map(|part| &part.part).filter(|part| part.table.as_ref() == Some(&table.name)).collect();
        let named = of_table.iter().flat_map(|part| part.columns.iter().flatten().chain(&part.time));
        let own = own.names().filter(|_| of_gyro == Some(&table.name));
        let column = |name: &str| table.column(name).or_else(|| table.column(unsigned(name)));
        let read: BTreeSet<&str> = named
            .map(String::as_str)
            .chain(own)
            .filter_map(|name| column(name).map(|column| column.name.as_str()))
            .collect();
        // A column without any value holds nothing that could be missed.
        let is_filled =
            |column: &&Column| column.not_a_number.is_some() || column.values.iter().any(|value| value.is_finite());
        let names = table.columns.iter().filter(is_filled).map(|column| column.name.as_str());
        let unused = listed(names.filter(|name| !read.contains(name)), MOST);
        let is_told = !of_table.is_empty() && !unused.is_empty();
        is_told.then(|| format!("columns of {} that are not used: {unused}", table.name))
    };
    tables.iter().filter_map(note).collect()
}
