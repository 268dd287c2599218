//! The attitude filter alone, in the call of VQF.

use meerkat_mwd::{
    Config,
    attitude::{AttitudeFilter as Inner, AttitudeFlags},
    config::Motion,
};
use nalgebra::Vector3;
use numpy::{IntoPyArray, PyReadonlyArray2, ndarray::ArrayView2};
use pyo3::{prelude::*, types::PyDict};

use crate::{bad, trace::rows};

/// Attitude of rates that are taken as they are: nothing is identified.
#[pyclass(module = "meerkat_mwd")]
pub struct AttitudeFilter {
    inner: Box<Inner>,
    /// The same without the field, for the attitude that it cannot disturb.
    without_field: Box<Inner>,
    period_s: f32,
}

/// Outputs of the filter after a sample.
struct Row {
    quaternion: [f32; 4],
    bias_rad_s: [f32; 3],
    bias_sigma_rad_s: f32,
    rests: bool,
    field_is_refused: bool,
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
        let config = Config::default();
        let started = || {
            let mut inner = Box::new(Inner::new());
            inner.start(&config.attitude, &config.earth, motion);
            inner
        };
        Ok(Self { inner: started(), without_field: started(), period_s: period_s as f32 })
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
        let period_s = self.period_s;
        let (inner, without_field) = (&mut self.inner, &mut self.without_field);
        // Without a field the filter that takes one goes on, too, so that it is at the next batch's time.
        let (rows_with, rows_without) = py.detach(|| {
            let with = filtered(inner, period_s, &gyr, &acc, mag.as_ref());
            (with, filtered(without_field, period_s, &gyr, &acc, None))
        });
        let arrays = PyDict::new(py);
        let quaternions = |of: &[Row]| rows(of.iter().map(|row| row.quaternion)).into_pyarray(py);
        arrays.set_item("quat6D", quaternions(&rows_without))?;
        if mag.is_some() {
            arrays.set_item("quat9D", quaternions(&rows_with))?;
            let refused: Vec<bool> = rows_with.iter().map(|row| row.field_is_refused).collect();
            arrays.set_item("magDistDetected", refused.into_pyarray(py))?;
        }
        let said = if mag.is_some() { &rows_with } else { &rows_without };
        arrays.set_item("bias", rows(said.iter().map(|row| row.bias_rad_s)).into_pyarray(py))?;
        let sigmas: Vec<f32> = said.iter().map(|row| row.bias_sigma_rad_s).collect();
        arrays.set_item("biasSigma", sigmas.into_pyarray(py))?;
        let rests: Vec<bool> = said.iter().map(|row| row.rests).collect();
        arrays.set_item("restDetected", rests.into_pyarray(py))?;
        Ok(arrays)
    }
}

/// Passes whole arrays through a filter.
fn filtered(
    inner: &mut Inner,
    period_s: f32,
    gyr: &ArrayView2<'_, f64>,
    acc: &ArrayView2<'_, f64>,
    mag: Option<&ArrayView2<'_, f64>>,
) -> Vec<Row> {
    let three = |values: &ArrayView2<'_, f64>, row: usize| {
        Vector3::new(values[(row, 0)] as f32, values[(row, 1)] as f32, values[(row, 2)] as f32)
    };
    let is_there = |v: &Vector3<f32>| v.iter().all(|x| x.is_finite());
    let one = |row: usize| {
        let rate = three(gyr, row);
        if is_there(&rate) {
            let rate = rate - inner.earth_rate_rad_s();
            inner.propagate(period_s, &rate);
        } else {
            inner.gap(period_s);
        }
        let force = Some(three(acc, row)).filter(is_there);
        // The filter takes no field of zeros either.
        let field = mag.map(|mag| three(mag, row)).filter(|field| is_there(field) && *field != Vector3::zeros());
        inner.observe(force.as_ref(), field.as_ref());
        let attitude = inner.attitude(AttitudeFlags::empty());
        Row {
            quaternion: attitude.map_or([f32::NAN; 4], |attitude| attitude.q),
            bias_rad_s: inner.residual_bias_rad_s().into(),
            bias_sigma_rad_s: inner.residual_bias_sigma_rad_s().max(),
            rests: inner.is_at_rest(),
            field_is_refused: field.is_some()
                && attitude.is_some_and(|attitude| attitude.flags.contains(AttitudeFlags::MAG_UNUSED)),
        }
    };
    (0..gyr.nrows()).map(one).collect()
}
