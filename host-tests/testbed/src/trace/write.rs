//! Writing of a trace: samples to lines.

use std::{
    ffi::OsStr,
    io::{self, BufWriter, Write},
    path::Path,
};

use flate2::{Compression, write::GzEncoder};
use meerkat_mwd::SampleFlags;

use crate::console;

use super::{
    Trace,
    error::{Fault, TraceError},
    seconds::seconds,
};

pub(super) fn write(trace: &Trace, path: &Path) -> Result<(), TraceError> {
    to_file(trace, path).map_err(|error| Fault::NotWritten(error.to_string()).of_file().of(path))
}

fn to_file(trace: &Trace, path: &Path) -> io::Result<()> {
    let file = BufWriter::new(console::create(path)?);
    if path.extension() == Some(OsStr::new("gz")) {
        // The encoder's header holds no time and no name, so that the same trace gives the same bytes.
        let mut encoder = GzEncoder::new(file, Compression::default());
        write_rows(trace, &mut encoder)?;
        encoder.finish()?.flush()
    } else {
        let mut file = file;
        write_rows(trace, &mut file)?;
        file.flush()
    }
}

fn write_rows(trace: &Trace, out: &mut impl Write) -> io::Result<()> {
    for (key, value) in trace.keys.lines() {
        writeln!(out, "# {key} = {value}")?;
    }
    let any = |missing| trace.samples.iter().any(|sample| !sample.flags.contains(missing));
    let has_mag = any(SampleFlags::MAG_MISSING);
    let has_temperature = any(SampleFlags::TEMPERATURE_MISSING);
    let has_reference = !trace.reference.is_empty();
    let groups = [
        (has_mag, ",mx,my,mz"),
        (has_temperature, ",temp_c"),
        (has_reference, ",qw,qx,qy,qz"),
        (trace.movement.is_some(), ",movement"),
        (trace.rest.is_some(), ",rest"),
        (trace.driver_flags.is_some(), ",sample_flags"),
        (trace.true_rate.is_some(), ",wx_true,wy_true,wz_true"),
    ];
    write!(out, "t_s,gx,gy,gz,ax,ay,az")?;
    for (_, names) in groups.iter().filter(|(present, _)| *present) {
        write!(out, "{names}")?;
    }
    writeln!(out)?;
    for (row, sample) in trace.samples.iter().enumerate() {
        let present = |missing| !sample.flags.contains(missing);
        write!(out, "{}", seconds(sample.t_us))?;
        write_cells(out, present(SampleFlags::GYRO_MISSING).then_some(sample.gyro_rad_s))?;
        write_cells(out, present(SampleFlags::ACCEL_MISSING).then_some(sample.accel_m_s2))?;
        if has_mag {
            write_cells(out, present(SampleFlags::MAG_MISSING).then_some(sample.mag_ut))?;
        }
        if has_temperature {
            write_cells(out, present(SampleFlags::TEMPERATURE_MISSING).then_some([sample.temperature_c]))?;
        }
        if has_reference {
            write_cells(out, trace.reference.get(row).copied().flatten())?;
        }
        for column in [&trace.movement, &trace.rest].into_iter().flatten() {
            let value = column.get(row).is_some_and(|&value| value);
            write_cells(out, Some([u8::from(value)]))?;
        }
        if let Some(column) = &trace.driver_flags {
            write_cells(out, column.get(row).map(|said| [said.bits()]))?;
        }
        if let Some(column) = &trace.true_rate {
            write_cells(out, column.get(row).copied())?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A comma before each value; empty cells for a missing group. Floats are written with the fewest digits that
/// read back as the same value.
fn write_cells<T: std::fmt::Display, const N: usize>(out: &mut impl Write, values: Option<[T; N]>) -> io::Result<()> {
    match values {
        Some(values) => values.iter().try_for_each(|value| write!(out, ",{value}")),
        None => (0..N).try_for_each(|_| out.write_all(b",")),
    }
}
