//! The probe, sample by sample.

use std::collections::VecDeque;

use meerkat_mwd::{
    Config, Probe as Inner, Sample, SampleFlags, compensation::effects::LIBRARY, diagnosis::DiagnosisReport,
    identification::WindowReport,
};
use mwd::report::json::{diagnosis_json, window_json};
use pyo3::{prelude::*, types::PyDict};

use crate::bad;

/// Reports that wait to be taken: half a day of windows.
const WAITING: usize = 1_000;

/// A probe as the firmware runs it.
#[pyclass(module = "meerkat_mwd")]
pub struct Probe {
    inner: Box<Inner>,
    config: Config,
    reports: VecDeque<WindowReport>,
    diagnoses: VecDeque<DiagnosisReport>,
}

#[pymethods]
impl Probe {
    /// `rate_hz` is the nominal rate; `config` is TOML over the defaults.
    #[new]
    #[pyo3(signature = (rate_hz, config=None))]
    fn new(rate_hz: f64, config: Option<&str>) -> PyResult<Self> {
        let mut table =
            toml::Table::try_from(Config { sample_period_us: (1e6 / rate_hz).round() as u32, ..Config::default() })
                .map_err(bad)?;
        let given: toml::Table = config.unwrap_or_default().parse().map_err(bad)?;
        overlay(&mut table, given);
        let config: Config = table.try_into().map_err(bad)?;
        let mut inner = Box::new(Inner::new());
        inner.set_library(&LIBRARY);
        inner.configure(&config).map_err(bad)?;
        Ok(Self { inner, config, reports: VecDeque::new(), diagnoses: VecDeque::new() })
    }

    /// Lets nothing new take effect from a time on, seconds: for a part that is held out.
    fn freeze(&mut self, at_s: f64) -> PyResult<()> {
        self.inner.freeze(microseconds(at_s)?);
        Ok(())
    }

    /// Pushes a sample and does the work that the chip does beside it. Returns the attitude, or None.
    #[pyo3(signature = (t_s, gyr, acc, mag=None, temperature=None))]
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        t_s: f64,
        gyr: [f64; 3],
        acc: [f64; 3],
        mag: Option<[f64; 3]>,
        temperature: Option<f64>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let mut flags = SampleFlags::empty();
        let mut three = |values: Option<[f64; 3]>, missing| {
            let read = values.filter(|values| values.iter().all(|x| x.is_finite()));
            flags.set(missing, read.is_none());
            read.unwrap_or_default().map(|x| x as f32)
        };
        let gyro_rad_s = three(Some(gyr), SampleFlags::GYRO_MISSING);
        let accel_m_s2 = three(Some(acc), SampleFlags::ACCEL_MISSING);
        let mag_ut = three(mag, SampleFlags::MAG_MISSING);
        let warm = temperature.filter(|x| x.is_finite());
        flags.set(SampleFlags::TEMPERATURE_MISSING, warm.is_none());
        let sample = Sample {
            t_us: microseconds(t_s)?,
            gyro_rad_s,
            accel_m_s2,
            mag_ut,
            temperature_c: warm.unwrap_or(0.0) as f32,
            flags,
        };
        let output = self.inner.push(&sample);
        put(&mut self.reports, self.inner.poll(self.inner.poll_budget()));
        put(&mut self.diagnoses, self.inner.take_diagnosis());
        let Some(output) = output else { return Ok(None) };
        let Some(attitude) = output.attitude else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("t_s", output.t_us as f64 / 1e6)?;
        dict.set_item("q", attitude.q)?;
        dict.set_item("rate", output.rate_rad_s)?;
        for (name, angle) in [
            ("inclination_deg", attitude.inclination_rad),
            ("azimuth_deg", attitude.azimuth_rad),
            ("gravity_toolface_deg", attitude.gravity_toolface_rad),
            ("magnetic_toolface_deg", attitude.magnetic_toolface_rad),
            ("sigma_inclination_deg", attitude.sigma_inclination_rad),
            ("sigma_azimuth_deg", attitude.sigma_azimuth_rad),
            ("sigma_toolface_deg", attitude.sigma_toolface_rad),
        ] {
            dict.set_item(name, angle.to_degrees())?;
        }
        dict.set_item("flags", attitude.flags.bits())?;
        Ok(Some(dict))
    }

    /// The oldest window's report that was not taken yet, or None.
    fn take_report<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let text = self.reports.pop_front().map(|report| window_json(&report, &self.config));
        text.map(|text| dictionary(py, &text.map_err(bad)?)).transpose()
    }

    /// The oldest diagnosis that was not taken yet, or None.
    fn take_diagnosis<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let text = self.diagnoses.pop_front().map(|report| diagnosis_json(&report, &LIBRARY));
        text.map(|text| dictionary(py, &text.map_err(bad)?)).transpose()
    }

    /// A magnet's interval when it has begun, and again when it has ended, or None.
    fn take_hard_iron_interval<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(interval) = self.inner.take_hard_iron_interval() else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("from_s", interval.from_us as f64 / 1e6)?;
        dict.set_item("to_s", interval.to_us.map(|to_us| to_us as f64 / 1e6))?;
        dict.set_item("offset_ut", interval.offset_ut)?;
        dict.set_item("sigma_ut", interval.sigma_ut)?;
        dict.set_item("field_use", format!("{:?}", interval.field_use))?;
        Ok(Some(dict))
    }
}

fn microseconds(t_s: f64) -> PyResult<u64> {
    let t_us = (t_s * 1e6).round();
    if !(0.0..1.8e19).contains(&t_us) {
        return Err(bad(format!("time {t_s} s is negative, too large or no number")));
    }
    Ok(t_us as u64)
}

/// Adds what there is; the oldest is lost where nobody takes them.
fn put<T>(waiting: &mut VecDeque<T>, new: Option<T>) {
    if waiting.len() == WAITING && new.is_some() {
        waiting.pop_front();
    }
    waiting.extend(new);
}

fn dictionary<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}

fn overlay(base: &mut toml::Table, on_top: toml::Table) {
    for (key, value) in on_top {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => overlay(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}
