//! MATLAB's .mat of version 5 (what `save -v6` and `-v7` write): numeric arrays, and structures of them.
//!
//! Read here because the crates for it panic on a damaged file. Source: MathWorks, MAT-File Format, Level 5.

use std::{collections::BTreeMap, io::Read};

use flate2::read::ZlibDecoder;

use super::table::{Column, Table};

/// First bytes of such a file.
pub const MAGIC: &[u8] = b"MATLAB 5.0";
/// Length of the header, bytes.
const HEADER: usize = 128;
/// Columns that a matrix may have to be taken for readings, one row a sample.
const WIDEST: usize = 64;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const STRUCTURE: u8 = 2;
/// Classes double to uint64.
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;

/// Reads all variables: those of one length are a table, and so are the fields of a structure.
///
/// # Errors
/// Description of what is wrong with the file.
pub fn read(bytes: &[u8], name: &str) -> Result<Vec<Table>, String> {
    if bytes.get(126..HEADER) != Some(b"IM") {
        return Err("the .mat file is truncated, or of a big-endian machine".into());
    }
    let mut found = Vec::new();
    let mut rest = bytes.get(HEADER..).unwrap_or_default();
    while !rest.is_empty() {
        let (kind, data, next) = element(rest)?;
        match kind {
            MATRIX => matrix(data, "", name, &mut found)?,
            COMPRESSED => {
                let mut plain = Vec::new();
                let read = ZlibDecoder::new(data).read_to_end(&mut plain);
                read.map_err(|error| format!("a compressed variable is damaged: {error}"))?;
                let (kind, data, _) = element(&plain)?;
                if kind == MATRIX {
                    matrix(data, "", name, &mut found)?;
                }
            }
            _ => {}
        }
        rest = next;
    }
    let mut tables: BTreeMap<(String, usize), Vec<Column>> = BTreeMap::new();
    for (table, column) in found {
        tables.entry((table, column.values.len())).or_default().push(column);
    }
    // The longest of a name first: the readings, not the settings beside them.
    let mut tables: Vec<Table> =
        tables.into_iter().map(|((name, _), columns)| Table { name, columns, keys: Vec::new() }).collect();
    tables.sort_by_key(|table| std::cmp::Reverse(table.rows()));
    tables.retain(|table| table.rows() > 1);
    if tables.is_empty() { Err("the .mat file has no numeric array of more than one row".into()) } else { Ok(tables) }
}

/// Kind and data of the first element, and what follows it.
fn element(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), String> {
    let cut = || "the .mat file is truncated".to_owned();
    let word = |at: usize| -> Result<u32, String> {
        bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes).ok_or_else(cut)
    };
    let kind = word(0)?;
    // A small element has its length and its data in the tag.
    if kind >> 16 != 0 {
        let data = bytes.get(4..8).and_then(|data| data.get(..(kind >> 16) as usize)).ok_or_else(cut)?;
        return Ok((kind & 0xffff, data, bytes.get(8..).unwrap_or_default()));
    }
    let length = word(4)? as usize;
    let data = bytes.get(8..).and_then(|data| data.get(..length)).ok_or_else(cut)?;
    let padded = if kind == COMPRESSED { length } else { length.next_multiple_of(8) };
    Ok((kind, data, bytes.get(8 + padded..).unwrap_or_default()))
}

/// Adds the columns of a variable or a field, each with the name of its table.
fn matrix(bytes: &[u8], field: &str, table: &str, found: &mut Vec<(String, Column)>) -> Result<(), String> {
    let (_, flags, rest) = element(bytes)?;
    let (_, dimensions, rest) = element(rest)?;
    let (_, own_name, rest) = element(rest)?;
    let class = flags.first().copied().unwrap_or(0);
    let dimensions: Vec<usize> = dimensions
        .chunks_exact(4)
        .map(|size| u32::from_le_bytes([size[0], size[1], size[2], size[3]]) as usize)
        .collect();
    let name = if field.is_empty() { String::from_utf8_lossy(own_name).into_owned() } else { field.to_owned() };
    if class == STRUCTURE {
        let (_, length, rest) = element(rest)?;
        let length = length.first().copied().unwrap_or(0) as usize;
        let (_, names, mut rest) = element(rest)?;
        for field in names.chunks(length.max(1)) {
            let field = String::from_utf8_lossy(field.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned();
            let (kind, data, next) = element(rest)?;
            // An empty field has no data.
            if kind == MATRIX && !data.is_empty() {
                matrix(data, &field, &name, found)?;
            }
            rest = next;
        }
        return Ok(());
    }
    if !NUMERIC.contains(&class) || dimensions.len() != 2 {
        return Ok(());
    }
    let (kind, data, _) = element(rest)?;
    let values = numbers(kind, data);
    let (rows, columns) = (dimensions[0], dimensions[1]);
    if values.len() != rows.saturating_mul(columns) {
        return Err(format!("variable {name}: {} numbers for {rows} by {columns}", values.len()));
    }
    // One row a sample; a wide array is a long one that lies.
    let lies = columns > rows;
    let (length, width) = if lies { (columns, rows) } else { (rows, columns) };
    for index in 0..width.min(WIDEST) {
        let value = |row: usize| if lies { values[row * width + index] } else { values[index * length + row] };
        let suffix = match width {
            1 => String::new(),
            3 => format!("_{}", ["x", "y", "z"][index]),
            _ => format!("_{}", index + 1),
        };
        found.push((table.to_owned(), Column::of(&format!("{name}{suffix}"), (0..length).map(value).collect())));
    }
    Ok(())
}

/// Numbers of an element, whose type may be smaller than the array's class.
fn numbers(kind: u32, data: &[u8]) -> Vec<f64> {
    fn of<const N: usize>(data: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        data.as_chunks::<N>().0.iter().map(|bytes| number(*bytes)).collect()
    }
    match kind {
        1 => of(data, |b: [u8; 1]| f64::from(i8::from_le_bytes(b))),
        2 => of(data, |b: [u8; 1]| f64::from(b[0])),
        3 => of(data, |b| f64::from(i16::from_le_bytes(b))),
        4 => of(data, |b| f64::from(u16::from_le_bytes(b))),
        5 => of(data, |b| f64::from(i32::from_le_bytes(b))),
        6 => of(data, |b| f64::from(u32::from_le_bytes(b))),
        7 => of(data, |b| f64::from(f32::from_le_bytes(b))),
        9 => of(data, f64::from_le_bytes),
        12 => of(data, |b| i64::from_le_bytes(b) as f64),
        13 => of(data, |b| u64::from_le_bytes(b) as f64),
        _ => Vec::new(),
    }
}
