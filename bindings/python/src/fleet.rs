//! One recording of a batch whose tasks an engine distributes: its key, and its three tables.

use std::path::PathBuf;

use mwd::batch::{Key, Options, alone};
use pyo3::prelude::*;

use crate::{bad, runs::options};

/// Options of a flight, as a dictionary that has all of them.
#[derive(FromPyObject)]
pub struct Given {
    #[pyo3(item)]
    config: Option<PathBuf>,
    #[pyo3(item)]
    hold_out: Option<f64>,
    #[pyo3(item)]
    seed: Option<u64>,
    #[pyo3(item)]
    no_effects: bool,
    #[pyo3(item)]
    force: bool,
}

impl Given {
    fn options(self) -> PyResult<Options> {
        options(self.config, self.hold_out, self.seed, self.no_effects, self.force)
    }
}

/// Hash of a recording and all that its result depends on: its bytes, the configuration's, the options, and
/// the program that flies it, which a hash tells.
#[pyfunction]
pub fn key(py: Python<'_>, file: PathBuf, program: &[u8], given: Given) -> PyResult<String> {
    let options = given.options()?;
    let key = py.detach(|| Key::by(program, &file, &options))?;
    Ok(key.text().to_owned())
}

/// Flies a recording's file and writes `results` and the tables beside it; what cannot be flown is a row with
/// its reason. Returns the key of the rows: another than `key` where the recording is not to blame and should
/// be flown again.
#[pyfunction]
pub fn tables(
    py: Python<'_>,
    address: &str,
    file: PathBuf,
    key: String,
    results: PathBuf,
    given: Given,
) -> PyResult<String> {
    let options = given.options()?;
    let key = py.detach(|| alone(address, Ok(&file), Key::told(key), &results, &options)).map_err(bad)?;
    Ok(key.text().to_owned())
}

/// Writes the tables of a recording that could not be fetched, with the reason in its row; returns the key of
/// the row.
#[pyfunction]
pub fn tables_of_unread(address: &str, why: String, results: PathBuf) -> PyResult<String> {
    let key = alone(address, Err(why), Key::told(String::new()), &results, &Options::default()).map_err(bad)?;
    Ok(key.text().to_owned())
}
