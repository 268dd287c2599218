//! Result of a recording's flight.

use std::path::PathBuf;

use meerkat_mwd::probe::Output;
use mwd::{
    batch::Result as Inner,
    report::{attitude_csv::write_attitude_csv, rates_csv::write_rates_csv, surveys_csv::surveys_csv},
};
use numpy::IntoPyArray;
use pyo3::{prelude::*, types::PyDict};

use crate::{bad, trace::rows};

/// A flight: attitude and rate of every sample, windows, effects and surveys.
#[pyclass(frozen, module = "meerkat_mwd")]
pub struct Flight(pub Inner);

#[pymethods]
impl Flight {
    /// The result as `cargo mwd replay --json` writes it.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.0.json()).map_err(bad)
    }

    /// The surveys as `cargo mwd replay --surveys` writes them.
    fn surveys_csv(&self) -> String {
        surveys_csv(&self.0.surveys)
    }

    /// Writes the attitude as `cargo mwd replay --attitude` does.
    fn write_attitude(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_attitude_csv(self.0.flight.rows(), &path)).map_err(bad)
    }

    /// Writes the rates as `cargo mwd replay --rates` does.
    fn write_rates(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_rates_csv(self.0.flight.rows(), &path)).map_err(bad)
    }

    /// Arrays of the attitude by name, a row a sample; NaN where there is none, yet or for a refused sample.
    fn attitude<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        attitude(py, &self.0.flight.rows().collect::<Vec<_>>())
    }

    /// Compensated rates, rad/s, (N, 3), with their times of validity.
    fn rates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let outputs: Vec<Output> = self.0.flight.rows().collect();
        let arrays = PyDict::new(py);
        arrays.set_item(
            "t_s",
            outputs.iter().map(|output| output.t_us as f64 / 1e6).collect::<Vec<_>>().into_pyarray(py),
        )?;
        arrays.set_item("rate", rows(outputs.iter().map(|output| output.rate_rad_s)).into_pyarray(py))?;
        Ok(arrays)
    }
}

/// Arrays of outputs, named as the columns of `--attitude`.
pub fn attitude<'py>(py: Python<'py>, outputs: &[Output]) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    arrays
        .set_item("t_s", outputs.iter().map(|output| output.t_us as f64 / 1e6).collect::<Vec<_>>().into_pyarray(py))?;
    let q = outputs.iter().map(|output| output.attitude.map_or([f32::NAN; 4], |attitude| attitude.q));
    arrays.set_item("q", rows(q).into_pyarray(py))?;
    type Angle = fn(&meerkat_mwd::attitude::Attitude) -> f32;
    let angles: [(&str, Angle); 7] = [
        ("inclination_deg", |a| a.inclination_rad),
        ("azimuth_deg", |a| a.azimuth_rad),
        ("gravity_toolface_deg", |a| a.gravity_toolface_rad),
        ("magnetic_toolface_deg", |a| a.magnetic_toolface_rad),
        ("sigma_inclination_deg", |a| a.sigma_inclination_rad),
        ("sigma_azimuth_deg", |a| a.sigma_azimuth_rad),
        ("sigma_toolface_deg", |a| a.sigma_toolface_rad),
    ];
    for (name, angle) in angles {
        let column = outputs
            .iter()
            .map(|output| output.attitude.as_ref().map_or(f32::NAN, |attitude| angle(attitude).to_degrees()));
        arrays.set_item(name, column.collect::<Vec<_>>().into_pyarray(py))?;
    }
    let flags = outputs.iter().map(|output| output.attitude.map_or(0, |attitude| u64::from(attitude.flags.bits())));
    arrays.set_item("flags", flags.collect::<Vec<_>>().into_pyarray(py))?;
    Ok(arrays)
}
