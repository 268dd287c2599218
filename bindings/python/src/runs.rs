//! Whole jobs, each as the command of its name does it.

use std::path::PathBuf;

use mwd::{
    batch::{Options, result},
    import::{ColumnMap, import},
    surveys::{files, reference::Reference, settings::RunSettings, stations_csv, surveyed},
};
use pyo3::prelude::*;
use testbed::simulate::Scenario;

use crate::{bad, flight::Flight, trace::Trace};

/// Options of a flight.
pub fn options(
    config: Option<PathBuf>,
    hold_out: Option<f64>,
    seed: Option<u64>,
    no_effects: bool,
    force: bool,
) -> PyResult<Options> {
    if hold_out.is_some_and(|share| !(share > 0.0 && share < 1.0)) {
        return Err(bad("hold_out must be between 0 and 1"));
    }
    Ok(Options { config, hold_out, seed, no_effects, force, attitude_dir: None, html_dir: None })
}

/// Flies a recording.
#[pyfunction]
#[pyo3(signature = (trace, config=None, hold_out=None, seed=None, no_effects=false, force=false))]
pub fn replay(
    py: Python<'_>,
    trace: &Trace,
    config: Option<PathBuf>,
    hold_out: Option<f64>,
    seed: Option<u64>,
    no_effects: bool,
    force: bool,
) -> PyResult<Flight> {
    let options = options(config, hold_out, seed, no_effects, force)?;
    py.detach(|| result(trace.0.clone(), &options)).map(Flight).map_err(bad)
}

/// Simulates a scenario of TOML text; the trace and the true gyro model (P row by row, then b).
#[pyfunction]
pub fn simulate(py: Python<'_>, scenario: PathBuf, seed: u64) -> PyResult<(Trace, Vec<f64>)> {
    let scenario = Scenario::read(&scenario).map_err(bad)?;
    let (trace, truth) = py.detach(|| testbed::simulate::simulate(&scenario, seed));
    let model = truth.gyro.p.as_flattened().iter().chain(&truth.gyro.b_rad_s).map(|x| f64::from(*x)).collect();
    Ok((Trace(trace), model))
}

/// Calibrates; the account as JSON, and the record as TOML if anything could be calibrated.
#[pyfunction]
#[pyo3(signature = (traces, config=None, hold_out=None))]
pub fn calibrate(
    py: Python<'_>,
    traces: Vec<PyRef<'_, Trace>>,
    config: Option<PathBuf>,
    hold_out: Option<f64>,
) -> PyResult<(String, Option<String>)> {
    let traces: Vec<_> = traces.iter().map(|trace| trace.0.clone()).collect();
    let calibration = py.detach(|| mwd::calibrate::calibrate(&traces, config.as_deref(), hold_out)).map_err(bad)?;
    Ok((mwd::calibrate::result::value(&calibration).to_string(), mwd::calibrate::record::text(&calibration)))
}

/// Works out a run of stations (CSV text) with its settings (TOML text); the result as JSON.
#[pyfunction]
#[pyo3(signature = (stations, run=None))]
pub fn survey(py: Python<'_>, stations: &str, run: Option<&str>) -> PyResult<String> {
    let settings = run.map_or_else(|| Ok(RunSettings::default()), RunSettings::parse).map_err(bad)?;
    let stations = stations_csv::read(stations).map_err(bad)?;
    let reference = Reference::of(&settings).map_err(bad)?;
    let run = py.detach(|| surveyed::surveyed(&stations, &settings, &reference)).map_err(bad)?;
    files::json(&run).map_err(bad)
}

/// Imports a foreign recording: the trace, the map as TOML, what was understood and found as text, and
/// whether it is wrong.
#[pyfunction]
#[pyo3(signature = (sources, map=None, keys=Vec::new()))]
pub fn import_recording(
    py: Python<'_>,
    sources: Vec<PathBuf>,
    map: Option<PathBuf>,
    keys: Vec<(String, String)>,
) -> PyResult<(Trace, String, String, bool)> {
    let map = map.map_or_else(|| Ok(ColumnMap::default()), |map| ColumnMap::read(&map)).map_err(bad)?;
    let imported = py.detach(|| import(&sources, &map, &keys)).map_err(bad)?;
    let mut told = Vec::new();
    imported.describe(&mut told).map_err(bad)?;
    let (map, wrong) = (imported.map.to_toml(), imported.is_wrong());
    Ok((Trace(imported.trace), map, String::from_utf8_lossy(&told).into_owned(), wrong))
}
