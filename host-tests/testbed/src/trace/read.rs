//! Reading of a trace: lines to samples.

use std::{collections::BTreeSet, io::BufRead, path::Path, str::FromStr};

use meerkat_mwd::{Sample, SampleFlags};

use super::{
    Trace,
    columns::{Columns, Quantity, cells},
    decimal_time::parse_time_us,
    error::{Fault, Located, TraceError, quoted},
    keys::{KeyOutcome, Keys},
    lines::{self, Lines},
    row_order::{RowOrder, RowPlace},
    rows::Spooled,
};

/// Tolerance of a reference quaternion's norm: further from 1 it is no rotation. Rounding to a few decimals
/// or interpolation costs well under 1 %.
const REFERENCE_NORM_TOLERANCE: f64 = 0.05;

/// Rows that are in memory before they go to a temporary file: of a trace that is no longer, all stay there. About
/// a megabyte.
const IN_MEMORY: usize = 1 << 13;

pub(super) fn read(path: &Path) -> Result<Trace, TraceError> {
    read_into(path, None)
}

pub(super) fn of_bytes(bytes: &[u8]) -> Result<Trace, TraceError> {
    let lines = lines::of(bytes, false);
    lines.and_then(|lines| read_lines(lines, None)).map_err(|located| located.of(Path::new("")))
}

pub(super) fn spooled(path: &Path) -> Result<Trace, TraceError> {
    read_into(path, Some(Spooled::default()))
}

/// Keys of a trace's header, whatever is wrong with its rows; `None` if the header cannot be read.
pub(super) fn header(path: &Path) -> Option<Keys> {
    let (_, trace) = lines::open(path).and_then(|mut lines| read_header(&mut lines)).ok()?;
    Some(trace.keys)
}

fn read_into(path: &Path, spooled: Option<Spooled>) -> Result<Trace, TraceError> {
    let trace = lines::open(path).and_then(|lines| read_lines(lines, spooled)).map_err(|located| located.of(path))?;
    Ok(Trace { path: path.to_owned(), ..trace })
}

fn read_lines<R: BufRead>(mut lines: Lines<R>, mut spooled: Option<Spooled>) -> Result<Trace, Located> {
    let (columns, mut trace) = read_header(&mut lines)?;
    let mut not_rotations = 0_usize;
    let mut order = RowOrder::default();
    let mut last = None;
    while let Some((line, row)) = lines.next_line()? {
        if row.is_empty() {
            continue;
        }
        let mut row = parse_row(row, line, &columns)?;
        let t_us = row.time_us().map_err(|fault| fault.in_column(line, "t_s"))?;
        if let Some(Last { line, t_us: ahead_us, before_us, has_bad_reference }) = last
            && order.shows_last_ahead(t_us)
        {
            trace.drop_last();
            not_rotations -= usize::from(has_bad_reference);
            trace.dropped.count(Fault::TimeAhead { ahead_us, next_us: t_us }.in_column(line, "t_s"));
            last = Some(Last { line, t_us: before_us, before_us, has_bad_reference: false });
        }
        let before_us = last.map_or(t_us, |last| last.t_us);
        let fault = match order.place(t_us) {
            RowPlace::Next => None,
            RowPlace::Repeated => Some(Fault::TimeRepeated(t_us)),
            RowPlace::Late => Some(Fault::TimeBack { now_us: t_us, before_us }),
        };
        if let Some(fault) = fault {
            trace.dropped.count(fault.in_column(line, "t_s"));
            continue;
        }
        let has_bad_reference = row.drop_reference_that_is_no_rotation();
        not_rotations += usize::from(has_bad_reference);
        last = Some(Last { line, t_us, before_us, has_bad_reference });
        row.append_to(t_us, &mut trace);
        // A doubted row stays in memory until the next one.
        let is_full = trace.samples.len() >= IN_MEMORY && !order.is_in_doubt();
        if let Some(spooled) = spooled.as_mut().filter(|_| is_full) {
            spooled.take(&mut trace);
        }
    }
    trace.spooled = spooled.filter(|spooled| spooled.len() > 0).map(|mut spooled| {
        spooled.take(&mut trace);
        spooled
    });
    if trace.is_empty() {
        return Err(Fault::NoSamples.of_file());
    }
    if let Some(fault) = trace.dropped.too_many(trace.len()) {
        return Err(fault);
    }
    trace.notes.extend(trace.dropped.note());
    if not_rotations > 0 {
        trace.notes.push(format!("{not_rotations} reference quaternions are far from unit norm and count as missing"));
    }
    trace.mark_clipped(&trace.keys.full_scale());
    Ok(trace)
}

/// The last row that was kept.
#[derive(Clone, Copy)]
struct Last {
    line: u64,
    t_us: u64,
    /// Time of the row before, microseconds.
    before_us: u64,
    has_bad_reference: bool,
}

impl Trace {
    /// Takes the last row back.
    fn drop_last(&mut self) {
        self.samples.pop();
        self.reference.pop();
        for column in [&mut self.movement, &mut self.rest].into_iter().flatten() {
            column.pop();
        }
        if let Some(column) = &mut self.driver_flags {
            column.pop();
        }
        if let Some(column) = &mut self.true_rate {
            column.pop();
        }
    }
}

fn read_header<R: BufRead>(lines: &mut Lines<R>) -> Result<(Columns, Trace), Located> {
    let mut keys = Keys::default();
    let (mut unknown_keys, mut given, mut repeated) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    let columns = loop {
        let Some((line, text)) = lines.next_line()? else {
            return Err(Fault::NoHeader.of_file());
        };
        if text.is_empty() {
            continue;
        }
        let Some(comment) = text.strip_prefix('#') else {
            break Columns::parse(text, line)?;
        };
        if let Some((key, value)) = comment.split_once('=') {
            let (key, value) = (key.trim(), value.trim());
            match keys.set(key, value).map_err(|fault| fault.at(line))? {
                KeyOutcome::Unknown => unknown_keys.push(quoted(key)),
                KeyOutcome::Taken if given.insert(key.to_owned()) => {}
                KeyOutcome::Taken => {
                    repeated.insert(key.to_owned());
                }
            }
        }
    };
    let mut trace = Trace { keys, ..Trace::default() };
    let mut note = |what: &str, names: Vec<String>| {
        if !names.is_empty() {
            trace.notes.push(format!("{what}: {}", names.join(", ")));
        }
    };
    note("ignored keys", unknown_keys);
    note("keys given more than once, of which the last counts", repeated.into_iter().collect());
    note("ignored columns", columns.ignored.clone());
    trace.movement = columns.has(Quantity::Movement).then(Vec::new);
    trace.rest = columns.has(Quantity::Rest).then(Vec::new);
    trace.driver_flags = columns.has(Quantity::DriverFlags).then(Vec::new);
    trace.true_rate = columns.has(Quantity::TrueRate(0)).then(Vec::new);
    Ok((columns, trace))
}

/// Cells of one group; complete only if each has a value.
#[derive(Clone, Copy)]
struct Group<T, const N: usize> {
    values: [T; N],
    present: usize,
}

impl<T: Copy + Default, const N: usize> Default for Group<T, N> {
    fn default() -> Self {
        Self { values: [T::default(); N], present: 0 }
    }
}

impl<T: FromStr + Copy + Into<f64>, const N: usize> Group<T, N> {
    fn take(&mut self, index: usize, cell: &str) -> Result<(), Fault> {
        if let (Some(value), Some(place)) = (parse_number(cell)?, self.values.get_mut(index)) {
            *place = value;
            self.present += 1;
        }
        Ok(())
    }

    fn complete(&self) -> Option<[T; N]> {
        (self.present == N).then_some(self.values)
    }
}

#[derive(Default)]
struct Row<'a> {
    time: &'a str,
    gyro: Group<f32, 3>,
    accel: Group<f32, 3>,
    mag: Group<f32, 3>,
    temperature: Group<f32, 1>,
    reference: Group<f64, 4>,
    has_reference: bool,
    movement: bool,
    rest: bool,
    true_rate: [f64; 3],
    driver_flags: SampleFlags,
}

fn parse_row<'a>(row: &'a str, line: u64, columns: &Columns) -> Result<Row<'a>, Located> {
    let ragged = || {
        let count = cells(row).count();
        (count != columns.cells.len()).then(|| Fault::Ragged { cells: count, columns: columns.cells.len() }.at(line))
    };
    let mut parsed = Row::default();
    let mut cells = cells(row);
    for &(name, quantity) in &columns.cells {
        let taken = cells.next().map(|cell| parsed.take(quantity, cell));
        match taken {
            Some(Ok(())) => {}
            // No cell of a row with too few or too many cells is blamed: it may stand in another's column.
            Some(Err(fault)) => return Err(ragged().unwrap_or_else(|| fault.in_column(line, name))),
            None => return Err(ragged().unwrap_or_else(|| Fault::MissingColumn.in_column(line, name))),
        }
    }
    match cells.next().and_then(|_| ragged()) {
        Some(fault) => Err(fault),
        None => Ok(parsed),
    }
}

impl<'a> Row<'a> {
    fn take(&mut self, quantity: Quantity, cell: &'a str) -> Result<(), Fault> {
        let is_one = |cell| parse_number::<f64>(cell).map(|value| value == Some(1.0));
        match quantity {
            Quantity::Time => self.time = cell,
            Quantity::Gyro(axis) => self.gyro.take(axis, cell)?,
            Quantity::Accel(axis) => self.accel.take(axis, cell)?,
            Quantity::Mag(axis) => self.mag.take(axis, cell)?,
            Quantity::Temperature => self.temperature.take(0, cell)?,
            Quantity::Reference(component) => {
                self.has_reference = true;
                self.reference.take(component, cell)?;
            }
            Quantity::Movement => self.movement = is_one(cell)?,
            Quantity::Rest => self.rest = is_one(cell)?,
            // A simulated trace knows its true rate at every sample.
            Quantity::TrueRate(axis) => {
                let value = parse_number(cell)?.ok_or_else(|| Fault::NotANumber(String::new()))?;
                if let Some(place) = self.true_rate.get_mut(axis) {
                    *place = value;
                }
            }
            Quantity::DriverFlags => {
                let bits = parse_number::<u16>(cell)?.unwrap_or_default();
                self.driver_flags = SampleFlags::from_bits(bits).ok_or_else(|| Fault::NotANumber(quoted(cell)))?;
            }
            Quantity::Ignored => {}
        }
        Ok(())
    }

    fn time_us(&self) -> Result<u64, Fault> {
        if self.time.is_empty() { Err(Fault::TimeMissing) } else { parse_time_us(self.time) }
    }

    fn drop_reference_that_is_no_rotation(&mut self) -> bool {
        let Some(q) = self.reference.complete() else { return false };
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_rotation = (norm - 1.0).abs() <= REFERENCE_NORM_TOLERANCE;
        if !is_rotation {
            self.reference = Group::default();
        }
        !is_rotation
    }

    fn append_to(&self, t_us: u64, trace: &mut Trace) {
        let mut flags = SampleFlags::empty();
        let mut or_missing = |group: &Group<f32, 3>, missing| {
            group.complete().unwrap_or_else(|| {
                flags.insert(missing);
                [0.0; 3]
            })
        };
        let gyro_rad_s = or_missing(&self.gyro, SampleFlags::GYRO_MISSING);
        let accel_m_s2 = or_missing(&self.accel, SampleFlags::ACCEL_MISSING);
        let mag_ut = or_missing(&self.mag, SampleFlags::MAG_MISSING);
        let temperature = self.temperature.complete();
        flags.set(SampleFlags::TEMPERATURE_MISSING, temperature.is_none());
        let temperature_c = temperature.map_or(0.0, |[value]| value);
        trace.samples.push(Sample { t_us, gyro_rad_s, accel_m_s2, mag_ut, temperature_c, flags });
        if self.has_reference {
            trace.reference.push(self.reference.complete());
        }
        let flag_columns = [(&mut trace.movement, self.movement), (&mut trace.rest, self.rest)];
        for (column, value) in flag_columns {
            if let Some(column) = column {
                column.push(value);
            }
        }
        if let Some(column) = &mut trace.driver_flags {
            column.push(self.driver_flags);
        }
        if let Some(column) = &mut trace.true_rate {
            column.push(self.true_rate);
        }
    }
}

/// A cell's number, parsed in the precision in which it is used; `None` for an empty cell.
fn parse_number<T: FromStr + Copy + Into<f64>>(cell: &str) -> Result<Option<T>, Fault> {
    if cell.is_empty() {
        return Ok(None);
    }
    let value: T = cell.parse().map_err(|_| Fault::NotANumber(quoted(cell)))?;
    if value.into().is_finite() { Ok(Some(value)) } else { Err(Fault::NotFinite(quoted(cell))) }
}
