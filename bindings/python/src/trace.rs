//! A recording.

use std::path::PathBuf;

use meerkat_mwd::{Sample, SampleFlags};
use numpy::{IntoPyArray, PyReadonlyArray1, PyReadonlyArray2, ndarray::Array2};
use pyo3::{prelude::*, types::PyDict};
use testbed::trace::{Keys, RowOrder, RowPlace, Trace as Inner, TraceError};

use crate::bad;

/// A recording: samples, keys of its header, and a reference attitude if there is one.
#[pyclass(frozen, module = "meerkat_mwd")]
pub struct Trace(pub Inner);

#[pymethods]
impl Trace {
    /// Reads a trace file, .csv or .csv.gz; `strict` makes a row that is dropped for its time an error.
    #[staticmethod]
    #[pyo3(signature = (path, strict=false))]
    fn read(py: Python<'_>, path: PathBuf, strict: bool) -> PyResult<Self> {
        let trace = py.detach(|| Inner::read(&path)).map_err(bad)?;
        if strict {
            trace.none_dropped().map_err(bad)?;
        }
        Ok(Self(trace))
    }

    /// A trace of arrays: times in seconds (N), rad/s (N, 3), m/s^2 (N, 3), uT (N, 3), degC (N). NaN is a
    /// missing value, infinity an error. A row whose time is not after that of the row before, or far ahead of the
    /// rows around it, is dropped and counted; with `strict`, or over one in twenty, it is an error.
    #[staticmethod]
    #[pyo3(signature = (t_s, gyr, acc, mag=None, temperature=None, keys=Vec::new(), strict=false))]
    fn from_arrays(
        t_s: PyReadonlyArray1<'_, f64>,
        gyr: PyReadonlyArray2<'_, f64>,
        acc: PyReadonlyArray2<'_, f64>,
        mag: Option<PyReadonlyArray2<'_, f64>>,
        temperature: Option<PyReadonlyArray1<'_, f64>>,
        keys: Vec<(String, String)>,
        strict: bool,
    ) -> PyResult<Self> {
        let mut trace = Inner { path: "arrays".into(), keys: header(&keys)?, ..Inner::default() };
        let times = t_s.as_array();
        let count = times.len();
        for (name, shape) in [
            ("gyr", Some(gyr.as_array().dim())),
            ("acc", Some(acc.as_array().dim())),
            ("mag", mag.as_ref().map(|mag| mag.as_array().dim())),
        ] {
            if shape.is_some_and(|shape| shape != (count, 3)) {
                return Err(bad(format!(
                    "{name} must have the shape ({count}, 3) of the times, not {:?}",
                    shape.unwrap_or_default()
                )));
            }
        }
        if temperature.as_ref().is_some_and(|temperature| temperature.as_array().len() != count) {
            return Err(bad(format!("temperature must have {count} values, as the times")));
        }
        let (mut order, mut last, mut first_dropped) = (RowOrder::default(), (0, 0.0), None);
        for (row, time) in times.iter().enumerate() {
            let t_us = microseconds(row, *time)?;
            if order.shows_last_ahead(t_us) {
                trace.samples.pop();
                trace.dropped.late += 1;
                first_dropped.get_or_insert((last.0, far_ahead(last.0, last.1)));
            }
            let place = order.place(t_us);
            match place {
                RowPlace::Next => last = (row, *time),
                RowPlace::Repeated => trace.dropped.repeated += 1,
                RowPlace::Late => trace.dropped.late += 1,
            }
            if place != RowPlace::Next {
                first_dropped.get_or_insert_with(|| (row, not_after(row, *time)));
            }
            if let Some((_, told)) = first_dropped.as_ref().filter(|_| strict) {
                return Err(bad(told.clone()));
            }
            if place != RowPlace::Next {
                continue;
            }
            let mut flags = SampleFlags::empty();
            let mut three = |name: &str, values: Option<&PyReadonlyArray2<'_, f64>>, missing| {
                let read = values.map(|values| {
                    let values = values.as_array();
                    [0, 1, 2].map(|axis| values[(row, axis)] as f32)
                });
                if let Some(axis) = read.and_then(|read| read.iter().position(|x| x.is_infinite())) {
                    return Err(infinite(row, &format!("{name}[{axis}]")));
                }
                Ok(read.filter(|read| !read.iter().any(|x| x.is_nan())).unwrap_or_else(|| {
                    flags.insert(missing);
                    [0.0; 3]
                }))
            };
            let gyro_rad_s = three("gyr", Some(&gyr), SampleFlags::GYRO_MISSING)?;
            let accel_m_s2 = three("acc", Some(&acc), SampleFlags::ACCEL_MISSING)?;
            let mag_ut = three("mag", mag.as_ref(), SampleFlags::MAG_MISSING)?;
            let warm = temperature.as_ref().map(|values| values.as_array()[row] as f32).filter(|x| !x.is_nan());
            if warm.is_some_and(f32::is_infinite) {
                return Err(infinite(row, "temperature"));
            }
            flags.set(SampleFlags::TEMPERATURE_MISSING, warm.is_none());
            trace.samples.push(Sample {
                t_us,
                gyro_rad_s,
                accel_m_s2,
                mag_ut,
                temperature_c: warm.unwrap_or(0.0),
                flags,
            });
        }
        if trace.samples.is_empty() {
            return Err(bad("there is no sample"));
        }
        if let Some((row, told)) = first_dropped {
            if trace.dropped.are_too_many(trace.samples.len()) {
                return Err(bad(format!("{told}; {}", trace.dropped.told())));
            }
            trace.notes.push(format!("{}; the first is row {row}", trace.dropped.told()));
        }
        trace.mark_clipped(&trace.keys.full_scale());
        Ok(Self(trace))
    }

    /// A trace of columns of float64, each with its name in a trace's file; read as the file would be. NaN is an empty
    /// cell. `ignored` names columns that are not read.
    #[staticmethod]
    #[pyo3(signature = (names, columns, ignored=Vec::new(), keys=Vec::new(), strict=false))]
    fn from_columns(
        py: Python<'_>,
        names: Vec<String>,
        columns: Vec<PyReadonlyArray1<'_, f64>>,
        ignored: Vec<String>,
        keys: Vec<(String, String)>,
        strict: bool,
    ) -> PyResult<Self> {
        let keys = header(&keys)?;
        let columns: Vec<_> = columns.iter().map(|column| column.as_array()).collect();
        let count = columns.first().map_or(0, |column| column.len());
        if let Some((name, _)) = names.iter().zip(&columns).find(|(_, column)| column.len() != count) {
            return Err(bad(format!("column {name} has another length than column {}", names[0])));
        }
        let time = names.iter().position(|name| name == "t_s");
        let mut text = names.join(",");
        for row in 0..count {
            text.push('\n');
            for (place, column) in columns.iter().enumerate() {
                let value = column[row];
                if place > 0 {
                    text.push(',');
                }
                if time == Some(place) {
                    let t_us = microseconds(row, value)?;
                    text += &format!("{}.{:06}", t_us / 1_000_000, t_us % 1_000_000);
                } else if !value.is_nan() {
                    text += &value.to_string();
                }
            }
        }
        let told = |error: TraceError| {
            // Above the first row is the header row.
            let row = error.line.and_then(|line| line.checked_sub(2)).map(|row| format!("row {row}"));
            let column = error.column.map(|column| format!("column {column}"));
            let place: Vec<String> = row.into_iter().chain(column).collect();
            bad(format!("{}: {}", place.join(", "), error.fault).trim_start_matches(": "))
        };
        let mut trace = py.detach(|| Inner::of_bytes(text.as_bytes())).map_err(told)?;
        if strict {
            trace.none_dropped().map_err(told)?;
        }
        for note in &mut trace.notes {
            if let Some((before, line)) = note.rsplit_once("the first in line ") {
                *note = format!("{before}the first is row {}", line.parse::<usize>().unwrap_or(2).saturating_sub(2));
            }
        }
        if !ignored.is_empty() {
            trace.notes.insert(0, format!("ignored columns: {}", ignored.join(", ")));
        }
        (trace.path, trace.keys) = ("table".into(), keys);
        trace.mark_clipped(&trace.keys.full_scale());
        Ok(Self(trace))
    }

    /// Writes the trace, gzip when the name ends in .gz.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.0.write(&path)).map_err(bad)
    }

    /// Arrays by name; NaN where a value is missing.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let samples = &self.0.samples;
        let arrays = PyDict::new(py);
        let times: Vec<f64> = samples.iter().map(|sample| sample.t_us as f64 / 1e6).collect();
        arrays.set_item("t_s", times.into_pyarray(py))?;
        let three = |of: fn(&Sample) -> [f32; 3], missing| {
            let row = |sample: &Sample| if sample.flags.contains(missing) { [f32::NAN; 3] } else { of(sample) };
            rows(samples.iter().map(row))
        };
        arrays.set_item("gyr", three(|s| s.gyro_rad_s, SampleFlags::GYRO_MISSING).into_pyarray(py))?;
        arrays.set_item("acc", three(|s| s.accel_m_s2, SampleFlags::ACCEL_MISSING).into_pyarray(py))?;
        arrays.set_item("mag", three(|s| s.mag_ut, SampleFlags::MAG_MISSING).into_pyarray(py))?;
        let warm =
            |s: &Sample| if s.flags.contains(SampleFlags::TEMPERATURE_MISSING) { f32::NAN } else { s.temperature_c };
        arrays.set_item("temperature", samples.iter().map(warm).collect::<Vec<_>>().into_pyarray(py))?;
        if !self.0.reference.is_empty() {
            let reference = self.0.reference.iter().map(|q| q.unwrap_or([f64::NAN; 4]));
            arrays.set_item("reference", rows(reference).into_pyarray(py))?;
        }
        if let Some(rates) = &self.0.true_rate {
            arrays.set_item("true_rate", rows(rates.iter().copied()).into_pyarray(py))?;
        }
        Ok(arrays)
    }

    /// Numbers of rows that were dropped: whose time repeats, and whose time goes back.
    #[getter]
    const fn dropped(&self) -> (usize, usize) {
        (self.0.dropped.repeated, self.0.dropped.late)
    }

    /// Remarks of the reader, such as ignored columns.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// From the first sample to the last, seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.0.duration_s()
    }

    fn __len__(&self) -> usize {
        self.0.samples.len()
    }

    fn __repr__(&self) -> String {
        format!("Trace({} samples, {:.3} s, {})", self.0.samples.len(), self.0.duration_s(), self.0.path.display())
    }
}

/// Time of a row in whole microseconds.
fn microseconds(row: usize, time: f64) -> PyResult<u64> {
    let t_us = (time * 1e6).round();
    if !(0.0..1.8e19).contains(&t_us) {
        return Err(bad(format!("row {row}: time {time} s is negative, too large or no number")));
    }
    Ok(t_us as u64)
}

/// Error of a reading that is infinite, or too large for the number format.
fn infinite(row: usize, column: &str) -> PyErr {
    bad(format!("row {row}, column {column}: not a finite number; a missing value is NaN"))
}

fn far_ahead(row: usize, time: f64) -> String {
    format!("row {row}: time {time} s is far ahead of the rows around it")
}

fn not_after(row: usize, time: f64) -> String {
    format!("row {row}: time {time} s is not after that of the row before")
}

/// Keys of a header by their names.
pub fn header(keys: &[(String, String)]) -> PyResult<Keys> {
    let mut header = Keys::default();
    for (key, value) in keys {
        if !header.assign(key, value).map_err(bad)? {
            return Err(bad(format!("{key} is no key of a trace's header")));
        }
    }
    Ok(header)
}

/// Rows as one array, without a copy.
pub fn rows<T: Copy, const N: usize>(rows: impl Iterator<Item = [T; N]>) -> Array2<T> {
    let values: Vec<T> = rows.flatten().collect();
    let count = values.len() / N;
    // The shape is the values': it cannot fail.
    Array2::from_shape_vec((count, N), values).unwrap_or_else(|_| unreachable!())
}
