//! The compiled half of the Python package: traces and flights as classes that hold Rust values, arrays out
//! without copies. The other half, `python/meerkat_mwd`, is what users call.

mod attitude_alone;
mod fleet;
mod flight;
mod probe;
mod runs;
mod trace;

use pyo3::{exceptions::PyValueError, prelude::*};

/// An error of the library as Python's `ValueError`.
fn bad(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Compiled module on which the package's Python files build.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<trace::Trace>()?;
    module.add_class::<flight::Flight>()?;
    module.add_class::<probe::Probe>()?;
    module.add_class::<attitude_alone::AttitudeFilter>()?;
    module.add_function(wrap_pyfunction!(runs::replay, module)?)?;
    module.add_function(wrap_pyfunction!(runs::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(runs::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(runs::survey, module)?)?;
    module.add_function(wrap_pyfunction!(runs::import_recording, module)?)?;
    module.add_function(wrap_pyfunction!(fleet::key, module)?)?;
    module.add_function(wrap_pyfunction!(fleet::tables, module)?)?;
    module.add_function(wrap_pyfunction!(fleet::tables_of_unread, module)?)?;
    Ok(())
}
