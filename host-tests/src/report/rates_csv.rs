//! The `--rates` file.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use meerkat_mwd::probe::Output;

use crate::report::attitude_csv::write_cell;
use testbed::{console, failure::Failure, trace::seconds};

/// Writes one row per sample: time of validity and compensated body rate in rad/s.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rates_csv(outputs: impl Iterator<Item = Output>, path: &Path) -> Result<(), Failure> {
    let write = move || -> io::Result<()> {
        let mut file = BufWriter::new(console::create(path)?);
        writeln!(file, "t_s,wx,wy,wz")?;
        for output in outputs {
            write!(file, "{}", seconds(output.t_us))?;
            output.rate_rad_s.iter().try_for_each(|&rate| write_cell(&mut file, rate))?;
            writeln!(file)?;
        }
        file.flush()
    };
    write().map_err(|error| Failure::output(path, &error))
}
