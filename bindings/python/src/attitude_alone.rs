//! The attitude filter alone, in the call of VQF.

use meerkat_mwd::{Config, attitude::AttitudeFlags, config::Motion};
use nalgebra::Vector3;
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::{prelude::*, types::PyDict};

use crate::{bad, trace::rows};

/// Attitude of rates that are taken as they are: nothing is identified.
#[pyclass(module = "meerkat_mwd")]
pub struct AttitudeFilter {
    inner: Box<meerkat_mwd::attitude::AttitudeFilter>,
    period_s: f32,
}

#[pymethods]
impl AttitudeFilter {
    /// `period_s` is the time between two samples, seconds; `motion` is `hand` or `drill_string`.
    #[new]
    fn new(period_s: f64, motion: &str) -> PyResult<Self> {
        if !(1e-4..=0.05).contains(&period_s) {
            return Err(bad(format!("the period must be 0.0001 to 0.05 s, not {period_s}")));
        }
        let motion = match motion {
            "hand" => Motion::Hand,
            "drill_string" => Motion::DrillString,
            other => return Err(bad(format!("motion must be 'hand' or 'drill_string', not '{other}'"))),
        };
        let (config, mut inner) = (Config::default(), Box::new(meerkat_mwd::attitude::AttitudeFilter::new()));
        inner.start(&config.attitude, &config.earth, motion);
        Ok(Self { inner, period_s: period_s as f32 })
    }

    /// Attitudes of whole arrays, (N, 3) each: rad/s, m/s^2, and a field in any unit of microtesla's size.
    #[pyo3(signature = (gyr, acc, mag=None))]
    fn update_batch<'py>(
        &mut self,
        py: Python<'py>,
        gyr: PyReadonlyArray2<'_, f64>,
        acc: PyReadonlyArray2<'_, f64>,
        mag: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (gyr, acc, mag) = (gyr.as_array(), acc.as_array(), mag.as_ref().map(|mag| mag.as_array()));
        let shape = gyr.dim();
        if shape.1 != 3 || acc.dim() != shape || mag.is_some_and(|mag| mag.dim() != shape) {
            return Err(bad(format!("gyr, acc and mag must have one shape (N, 3); gyr has {shape:?}")));
        }
        let (inner, period_s) = (&mut self.inner, self.period_s);
        let three = |values: &numpy::ndarray::ArrayView2<'_, f64>, row: usize| {
            Vector3::new(values[(row, 0)] as f32, values[(row, 1)] as f32, values[(row, 2)] as f32)
        };
        let is_there = |v: &Vector3<f32>| v.iter().all(|x| x.is_finite());
        let quaternions: Vec<[f32; 4]> = py.detach(|| {
            let one = |row: usize| {
                let rate = three(&gyr, row);
                if is_there(&rate) {
                    let rate = rate - inner.earth_rate_rad_s();
                    inner.propagate(period_s, &rate);
                } else {
                    inner.gap(period_s);
                }
                let force = Some(three(&acc, row)).filter(is_there);
                let field = mag.as_ref().map(|mag| three(mag, row)).filter(is_there);
                inner.observe(force.as_ref(), field.as_ref());
                inner.attitude(AttitudeFlags::empty()).map_or([f32::NAN; 4], |attitude| attitude.q)
            };
            (0..shape.0).map(one).collect()
        });
        let arrays = PyDict::new(py);
        arrays.set_item("quatNED", rows(quaternions.into_iter()).into_pyarray(py))?;
        Ok(arrays)
    }
}
