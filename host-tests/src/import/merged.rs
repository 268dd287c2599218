//! All sensors of a source on one clock, in the trace's units.

use meerkat_mwd::{Sample, SampleFlags};

use super::{
    one_clock::{How, at_shared_times, on_clock},
    own_columns::OwnColumns,
    resolve::{Resolved, name},
    series::{Series, start_at_zero},
    units::Quantity,
};
use testbed::{
    failure::Failure,
    trace::{Keys, Trace},
};

/// One row for each of the gyro's readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    /// Times, microseconds.
    pub t_us: Vec<i64>,
    /// Angular rate, rad/s.
    pub gyro: Vec<[f64; 4]>,
    /// Specific force, m/s^2.
    pub accel: Vec<[f64; 4]>,
    /// Field, microtesla; empty without a magnetometer.
    pub mag: Vec<[f64; 4]>,
    /// Temperature, degrees Celsius; empty without a thermometer.
    pub temperature: Vec<[f64; 4]>,
    /// Reference attitude; empty without one.
    pub reference: Vec<[f64; 4]>,
    /// Columns of the gyro's table that only a trace has.
    pub own: OwnColumns,
    /// Way in which each sensor came on the clock.
    pub how: Vec<(Quantity, How)>,
    /// Remarks.
    pub notes: Vec<String>,
    /// Seconds by which the clock was moved.
    pub start_s: i64,
}

/// Brings all sensors on the gyro's clock; `own` are the columns that only a trace has.
///
/// # Errors
/// The sensors have no time in common.
pub fn merged(parts: &[Resolved], mut all: Vec<Series>, own: OwnColumns) -> Result<Merged, Failure> {
    let start_s = start_at_zero(all.iter_mut());
    let Some(gyro) = all.first().cloned() else { return Ok(Merged::default()) };
    let mut merged = Merged { t_us: gyro.t_us.clone(), gyro: gyro.rows.clone(), own, start_s, ..Merged::default() };
    if start_s != 0 {
        merged.notes.push(format!("time starts at second {start_s} of the source's clock"));
    }
    for (part, series) in parts.iter().zip(&all).skip(1) {
        let sensor = name(part.quantity);
        let (first, last) = (series.t_us.first(), series.t_us.last());
        if first > gyro.t_us.last() || last < gyro.t_us.first() {
            if matches!(part.quantity, Quantity::Temperature | Quantity::Reference) {
                merged.notes.push(format!("the {sensor} is left out: it has no time in common with the gyro"));
                continue;
            }
            return Err(Failure::BadInput(format!(
                "the {sensor} and the gyro have no time in common: {} to {} s and {} to {} s. Name another column of time, \
                 or time_offset_s = ... in [{sensor}] of --map",
                told(first),
                told(last),
                told(gyro.t_us.first()),
                told(gyro.t_us.last())
            )));
        }
        if part.quantity == Quantity::Reference {
            // Between two quaternions there is no line.
            let (rows, how, shared) = at_shared_times(&gyro, series);
            let count = series.t_us.len();
            if 2 * shared < count {
                merged.notes.push(format!(
                    "the reference attitude is left out: {shared} of its {count} rows have a time of the gyro's, and between \
                     its rows nothing is made up; give it the gyro's times"
                ));
                continue;
            }
            merged.reference = rows;
            merged.how.push((part.quantity, how));
            continue;
        }
        let (rows, how) = on_clock(&gyro, series, part.quantity == Quantity::Mag);
        match part.quantity {
            Quantity::Accel => merged.accel = rows,
            Quantity::Mag => merged.mag = rows,
            Quantity::Temperature => merged.temperature = rows,
            Quantity::Reference | Quantity::Gyro | Quantity::Time => {}
        }
        merged.how.push((part.quantity, how));
    }
    // Time before zero: a trace has none.
    let before = merged.t_us.partition_point(|&t_us| t_us < 0);
    if before > 0 {
        merged.notes.push(format!("{before} rows before time zero are left out"));
        merged.t_us.drain(..before);
        let columns =
            [&mut merged.gyro, &mut merged.accel, &mut merged.mag, &mut merged.temperature, &mut merged.reference];
        columns.into_iter().filter(|column| !column.is_empty()).for_each(|column| drop(column.drain(..before)));
        merged.own.drop_first(before);
    }
    Ok(merged)
}

fn told(t_us: Option<&i64>) -> f64 {
    t_us.map_or(f64::NAN, |&t_us| (t_us as f64 * 1e-3).round() * 1e-3)
}

impl Merged {
    /// The trace.
    #[must_use]
    pub fn trace(&self, keys: Keys) -> Trace {
        let OwnColumns { sample_flags, movement, rest } = self.own.clone();
        let mut trace =
            Trace { keys, notes: self.notes.clone(), driver_flags: sample_flags, movement, rest, ..Trace::default() };
        for (row, &t_us) in self.t_us.iter().enumerate() {
            let mut flags = SampleFlags::empty();
            let mut values = |rows: &[[f64; 4]], width: usize, missing| match rows.get(row) {
                Some(values) if values[..width].iter().all(|x| x.is_finite()) => {
                    [values[0] as f32, values[1] as f32, values[2] as f32]
                }
                _ => {
                    flags.insert(missing);
                    [0.0; 3]
                }
            };
            let gyro_rad_s = values(&self.gyro, 3, SampleFlags::GYRO_MISSING);
            let accel_m_s2 = values(&self.accel, 3, SampleFlags::ACCEL_MISSING);
            let mag_ut = values(&self.mag, 3, SampleFlags::MAG_MISSING);
            let [temperature_c, ..] = values(&self.temperature, 1, SampleFlags::TEMPERATURE_MISSING);
            trace.samples.push(Sample {
                t_us: t_us.unsigned_abs(),
                gyro_rad_s,
                accel_m_s2,
                mag_ut,
                temperature_c,
                flags,
            });
            if let Some(q) = self.reference.get(row) {
                trace.reference.push(q.iter().all(|x| x.is_finite()).then_some(*q));
            }
        }
        trace.mark_clipped(&trace.keys.full_scale());
        trace
    }
}
