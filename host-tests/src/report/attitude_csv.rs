//! The `--attitude` file. The same code writes it for a flight on the host and on the emulated chip, so that
//! equal outputs give equal bytes.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use meerkat_mwd::probe::Output;

use testbed::{console, failure::Failure, trace::seconds};

const HEADER: &str = "t_s,qw,qx,qy,qz,inclination_deg,azimuth_deg,gravity_toolface_deg,magnetic_toolface_deg,\
                      sigma_inclination_deg,sigma_azimuth_deg,sigma_toolface_deg,flags";
const NO_ATTITUDE: &str = ",,,,,,,,,,,,";

/// Writes one row per sample: time of validity, body to NED, angles and their 1-sigma in degrees, flags;
/// empty cells where there is no attitude yet or a number does not exist.
///
/// # Errors
/// When the file cannot be written.
pub fn write_attitude_csv(outputs: impl Iterator<Item = Output>, path: &Path) -> Result<(), Failure> {
    let write = move || -> io::Result<()> {
        let mut file = BufWriter::new(console::create(path)?);
        write_rows(outputs, &mut file)?;
        file.flush()
    };
    write().map_err(|error| Failure::output(path, &error))
}

fn write_rows(outputs: impl Iterator<Item = Output>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")?;
    for output in outputs {
        write!(out, "{}", seconds(output.t_us))?;
        let Some(attitude) = &output.attitude else {
            writeln!(out, "{NO_ATTITUDE}")?;
            continue;
        };
        let angles_rad = [
            attitude.inclination_rad,
            attitude.azimuth_rad,
            attitude.gravity_toolface_rad,
            attitude.magnetic_toolface_rad,
            attitude.sigma_inclination_rad,
            attitude.sigma_azimuth_rad,
            attitude.sigma_toolface_rad,
        ];
        for number in attitude.q.into_iter().chain(angles_rad.map(f32::to_degrees)) {
            write_cell(out, number)?;
        }
        writeln!(out, ",{}", attitude.flags.bits())?;
    }
    Ok(())
}

/// Writes a comma and the shortest decimal that reads back as the same f32; an empty cell for NaN or
/// infinity.
pub(crate) fn write_cell(out: &mut impl Write, number: f32) -> io::Result<()> {
    if number.is_finite() { write!(out, ",{number}") } else { out.write_all(b",") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f32::consts::{FRAC_PI_2, PI};

    use meerkat_mwd::attitude::{Attitude, AttitudeFlags};

    use super::*;

    #[test]
    fn a_row_holds_degrees_and_the_flags_and_one_without_attitude_as_many_cells() {
        let attitude = Attitude {
            q: [0.6, 0.0, -0.8, 0.0],
            inclination_rad: FRAC_PI_2,
            azimuth_rad: PI,
            gravity_toolface_rad: 0.0,
            magnetic_toolface_rad: FRAC_PI_2,
            sigma_inclination_rad: 0.5_f32.to_radians(),
            sigma_azimuth_rad: f32::INFINITY,
            sigma_toolface_rad: 1.0_f32.to_radians(),
            flags: AttitudeFlags::NO_HEADING | AttitudeFlags::AFTER_GAP,
        };
        let rate_rad_s = [0.0; 3];
        let outputs = [
            Output { t_us: 0, rate_rad_s, attitude: None },
            Output { t_us: 3_500, rate_rad_s, attitude: Some(attitude) },
        ];
        let mut text = Vec::new();
        write_rows(outputs.into_iter(), &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let rows: Vec<&str> = text.lines().collect();
        assert!(rows.iter().all(|row| row.matches(',').count() == 12));
        assert_eq!(rows[1], format!("0.000000{NO_ATTITUDE}"));
        assert_eq!(rows[2], "0.003500,0.6,0,-0.8,0,90,180,0,90,0.5,,1,80");
    }
}
