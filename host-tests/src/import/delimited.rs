//! Text files of rows and cells: separator, decimal sign, preamble, header row and a row of units are told
//! from the file itself.

use serde::{Deserialize, Serialize};

use super::{
    clock_time::{ClockTime, unfold_midnights},
    table::{Column, Contents, Table},
};

/// Dialect of a text file: the separator of its cells and the decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dialect {
    /// Character between two cells; a blank stands for any run of blanks.
    pub separator: char,
    /// Decimal sign.
    pub decimal: char,
}

/// Lines from which the dialect is told.
const LOOKED_AT: usize = 60;

/// The dialect of a text.
#[must_use]
pub fn dialect(text: &str) -> Dialect {
    let lines: Vec<&str> = rows(text).map(|(_, line)| line).take(LOOKED_AT).collect();
    // Number of cells of a line by this separator; 0 if it is one, or if fewer than half of the lines agree on it.
    let columns = |separator: char| {
        let mut counts: Vec<usize> = lines.iter().map(|line| split(line, separator).len()).collect();
        counts.sort_unstable();
        let median = counts.get(counts.len() / 2).copied().unwrap_or(0);
        let agree = counts.iter().filter(|&&count| count == median).count();
        if 2 * agree >= counts.len() && median > 1 { median } else { 0 }
    };
    let with = |separator| {
        let sign_is = |sign: char| {
            let number = |cell: &String| cell.contains(sign) && cell.replacen(sign, ".", 1).parse::<f64>().is_ok();
            lines.iter().flat_map(|line| split(line, separator)).any(|cell| number(&cell))
        };
        let decimal = if separator != ',' && sign_is(',') && !sign_is('.') { ',' } else { '.' };
        Dialect { separator, decimal }
    };
    // A comma comes last but one: beside a semicolon or a tab it is the decimal sign.
    for separator in ['\t', ';', '|'] {
        if columns(separator) > 2 {
            return with(separator);
        }
    }
    if columns(',') > 2 || columns(' ') < 3 { with(',') } else { with(' ') }
}

/// Reads a text: its table, and what is lost of it.
///
/// # Errors
/// Description of what is wrong, with its line.
pub fn read(text: &str, name: &str, dialect: Dialect) -> Result<Contents, String> {
    if text.trim().is_empty() {
        return Err("the file is empty".into());
    }
    let keys = text.lines().filter_map(|line| line.trim().strip_prefix('#')?.split_once('='));
    let keys = keys.map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned())).collect();
    let mut rows = rows(text).map(|(line, row)| (line, split(row, dialect.separator))).peekable();
    let (names, width) = header(&mut rows, dialect)?;
    let mut columns: Vec<Column> = names.iter().map(|name| Column::of(name, Vec::new())).collect();
    let mut lost = Vec::new();
    for (line, mut cells) in rows {
        // A separator at the end of each line.
        if cells.len() == width + 1 && ends_empty(&cells) {
            cells.pop();
        }
        if cells.len() != width {
            // The last line of a recording that was cut off.
            if cells.len() < width && is_last(text, line) {
                lost.push(format!("the last line is cut off: {} of {width} cells in line {line}", cells.len()));
                break;
            }
            return Err(format!("line {line}: {} cells where the header row has {width}", cells.len()));
        }
        for (cell, column) in cells.iter().zip(&mut columns) {
            take(cell, line, dialect, column);
        }
    }
    for column in columns.iter_mut().filter(|column| column.is_clock && !column.has_date) {
        unfold_midnights(&mut column.values);
    }
    if columns.first().is_none_or(|column| column.values.is_empty()) {
        return Err("no row of numbers follows the header row".into());
    }
    Ok(Contents { lost, ..Contents::whole(vec![Table { name: name.to_owned(), columns, keys }]) })
}

/// Reason if a text holds no table at all.
#[must_use]
pub fn none_in(text: &str, dialect: Dialect) -> Option<String> {
    if text.trim().is_empty() {
        return Some("the file is empty".into());
    }
    let mut rows = rows(text).map(|(line, row)| (line, split(row, dialect.separator))).peekable();
    header(&mut rows, dialect).err()
}

fn is_last(text: &str, line: u64) -> bool {
    text.trim_end().lines().count() as u64 == line
}

/// Adds a cell to its column: its number, NaN for an empty one or none.
fn take(cell: &str, line: u64, dialect: Dialect, column: &mut Column) {
    let mut value = number(cell, dialect);
    if value.is_none() && (column.is_clock || column.values.is_empty()) {
        let time = ClockTime::of(cell);
        column.is_clock |= time.is_some();
        column.has_date |= time.is_some_and(|time| time.has_date);
        value = time.map(|time| time.seconds);
    }
    let is_empty = matches!(cell.to_ascii_lowercase().as_str(), "" | "nan" | "na" | "n/a" | "null" | "none" | "-");
    if value.is_none() && !is_empty {
        column.not_numbers += 1;
        column.not_a_number.get_or_insert((line, cell.chars().take(40).collect()));
    }
    column.values.push(value.unwrap_or(f64::NAN));
}

fn number(cell: &str, dialect: Dialect) -> Option<f64> {
    let value = if dialect.decimal == ',' { cell.replacen(',', ".", 1).parse() } else { cell.parse::<f64>() };
    value.ok().filter(|value| value.is_finite())
}

/// Names of the columns and their number. Lines above the header row belong to the logger; a row of units
/// below it is added to the names.
fn header(
    rows: &mut std::iter::Peekable<impl Iterator<Item = (u64, Vec<String>)>>,
    dialect: Dialect,
) -> Result<(Vec<String>, usize), String> {
    let is_value = |cell: &String| number(cell, dialect).is_some() || ClockTime::of(cell).is_some();
    let values = |cells: &[String]| cells.iter().filter(|cell| is_value(cell)).count();
    let mut above: Option<Vec<String>> = None;
    for _ in 0..LOOKED_AT {
        let Some((_, next)) = rows.peek() else { break };
        let (numbers, filled) = (values(next), next.iter().filter(|cell| !cell.is_empty()).count());
        // Columns of sensors that are not there, or read seldom, may be empty.
        let is_data = next.len() > 2 && (2 * numbers > next.len() || (numbers > 2 && 2 * numbers > filled));
        if is_data {
            // With a separator at the end of each line the last cell is none; else it is one without a value.
            let is_named = above.as_ref().is_some_and(|names| names.len() == next.len() && !ends_empty(names));
            let width = if ends_empty(next) && !is_named { next.len() - 1 } else { next.len() };
            if let Some(names) = above.as_mut().filter(|names| names.len() == width + 1 && ends_empty(names)) {
                names.pop();
            }
            let names = match above {
                Some(names) if names.len() == width => names,
                _ => (1..=width).map(|index| format!("column {index}")).collect(),
            };
            return Ok((names, width));
        }
        let Some((_, cells)) = rows.next() else { break };
        above = Some(match above {
            // A row of units: as many cells, each short.
            Some(names) if names.len() == cells.len() && cells.len() > 2 => {
                let unit =
                    |(name, unit): (String, &String)| if unit.is_empty() { name } else { format!("{name} [{unit}]") };
                names.into_iter().zip(&cells).map(unit).collect()
            }
            _ => cells,
        });
    }
    Err(format!(
        "no row of at least three numbers with {:?} between them; name others by [dialect] in --map",
        dialect.separator
    ))
}

/// Lines that are neither empty nor a comment, with their numbers from 1.
fn rows(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let is_row = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    // A line of a spreadsheet that names its separator.
    let is_setting = |line: &str| line.starts_with("sep=");
    (1..).zip(text.lines()).filter(move |(_, line)| is_row(line) && !is_setting(line))
}

/// Cells of a line, without blanks and quotes around them.
fn ends_empty(cells: &[String]) -> bool {
    cells.len() > 1 && cells.last().is_some_and(String::is_empty)
}

fn split(line: &str, separator: char) -> Vec<String> {
    if separator == ' ' {
        return line.split_whitespace().map(str::to_owned).collect();
    }
    let line = line.trim_matches(|c: char| c == '\r' || c == '\n' || (c.is_whitespace() && c != separator));
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            _ if letter == separator && !quoted => cells.push(String::new()),
            _ => cells.last_mut().into_iter().for_each(|cell| cell.push(letter)),
        }
    }
    cells.iter().map(|cell| cell.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Table of a text.
    fn read(text: &str, name: &str, dialect: Dialect) -> Result<Table, String> {
        super::read(text, name, dialect).map(|mut contents| contents.tables.remove(0))
    }

    #[test]
    fn separator_and_decimal_sign_are_told_from_the_rows() {
        for (text, separator, decimal) in [
            ("t;x;y\n0,1;0,2;0,3\n", ';', ','),
            ("t;x;y\n0.1;0.2;0.3\n", ';', '.'),
            ("t,x,y\n0.1,0.2,0.3\n", ',', '.'),
            ("t\tx\ty\n0,1\t2\t3\n", '\t', ','),
            ("t  x y\n0.1  2 3\n", ' ', '.'),
            ("t,x,y\n1,2,3\n", ',', '.'),
        ] {
            assert_eq!(dialect(text), Dialect { separator, decimal }, "{text}");
        }
    }

    #[test]
    fn a_preamble_a_row_of_units_and_a_cut_off_end_are_understood() {
        let text = "Logger 7\n# body_frame = tool\nName;A\n\nt;gx;gy\nms;dps;dps\n0;1,5;2\n5;;3\n10;4";
        let table = read(text, "log", dialect(text)).unwrap();
        assert_eq!(table.columns[1].name, "gx [dps]");
        assert_eq!(table.columns[0].values, [0.0, 5.0]);
        assert!(table.columns[1].values[0] == 1.5 && table.columns[1].values[1].is_nan());
        assert_eq!(table.keys, [("body_frame".to_owned(), "tool".to_owned())]);
        let lost = |text: &str| super::read(text, "log", dialect(text)).unwrap().lost;
        assert_eq!(lost(text), ["the last line is cut off: 2 of 3 cells in line 9"]);
        assert!(lost("t,x,y\n1,2,3\n2,3,4").is_empty());
    }

    #[test]
    fn a_last_cell_without_a_value_is_missing_and_a_separator_at_each_end_is_no_column() {
        let sparse = "t,x,y\n1,2,3\n2,4,\n3,5,6\n";
        let columns = read(sparse, "log", dialect(sparse)).unwrap().columns;
        assert!(columns.len() == 3 && columns[2].values[1].is_nan() && columns[2].values[2] == 6.0);
        for ended in ["t,x,y,\n1,2,3,\n2,4,5,\n", "t,x,y\n1,2,3,\n2,4,5,\n"] {
            let columns = read(ended, "log", dialect(ended)).unwrap().columns;
            assert_eq!(columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["t", "x", "y"], "{ended}");
            assert_eq!(columns[2].values, [3.0, 5.0]);
        }
    }

    #[test]
    fn clock_times_continue_after_midnight_and_a_date_is_taken_as_it_is() {
        let times = |cells: [&str; 2]| {
            let text = format!("t,x,y\n{},1,2\n{},3,4\n", cells[0], cells[1]);
            read(&text, "log", dialect(&text)).unwrap().columns[0].values.clone()
        };
        assert_eq!(times(["23:59:59", "00:00:01"]), [86_399.0, 86_401.0]);
        assert_eq!(times(["1970-01-03 00:00:01", "1970-01-02 00:00:02"]), [172_801.0, 86_402.0]);
    }

    #[test]
    fn what_is_no_number_is_kept_for_the_message() {
        let text = "t,x,y\n1,2,3\n2,oops,3\n3,NaN,3\n";
        let column = &read(text, "log", dialect(text)).unwrap().columns[1];
        assert_eq!((column.not_numbers, column.not_a_number.clone()), (1, Some((3, "oops".to_owned()))));
        assert_eq!(
            read("t,x,y\n1,2,3\n1,2\n1,2,3\n", "log", dialect("t,x,y\n1,2,3\n")).unwrap_err(),
            "line 3: 2 cells where the header row has 3"
        );
    }

    #[test]
    fn a_row_may_have_more_empty_cells_than_numbers() {
        let text = "t,x,y,mx,my,mz,temp\n1,2,3,,,,\n2,3,4,,,,\n";
        let table = read(text, "log", dialect(text)).unwrap();
        assert_eq!((table.columns.len(), table.columns[2].values.clone()), (7, vec![3.0, 4.0]));
    }

    #[test]
    fn a_file_without_numbers_says_what_was_looked_for() {
        assert!(
            read("hello\nworld\n", "log", dialect("hello\nworld\n")).unwrap_err().starts_with("no row of at least")
        );
        assert_eq!(read("\n", "log", dialect("")).unwrap_err(), "the file is empty");
    }
}
