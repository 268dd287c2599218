//! Stations from a CSV file, as this program or another one writes them. A column's name says its unit and its sign:
//! nothing is guessed.

use nalgebra::Vector3;

use super::{
    cells::{degrees_within, line, number, table, unmarked, unread},
    measured::Measured,
    station_columns::{Columns, columns},
};
use testbed::failure::Failure;

/// Range of an inclination, degrees.
const INCLINATION_DEG: [f64; 2] = [0.0, 180.0];

/// Range of an azimuth, degrees: a turn beyond 0 to 360 on either side is a convention, more is no azimuth.
const AZIMUTH_DEG: [f64; 2] = [-360.0, 720.0];

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadStation {
    /// Time, seconds, if the file has it.
    pub t_s: Option<f64>,
    /// Measured depth, metres; `None` in a file by time alone.
    pub md_m: Option<f64>,
    /// Measurement of the tool.
    pub measured: Measured,
    /// Sag to add to the inclination, degrees, if the file has it.
    pub sag_deg: Option<f64>,
    /// Standard deviations of inclination and azimuth, radians, that a survey of the tool states of itself.
    pub sigma_rad: Option<[f64; 2]>,
}

/// Reads the text of a file.
///
/// # Errors
/// The first line or column that cannot be used, and why.
pub fn read(text: &str) -> Result<Vec<ReadStation>, Failure> {
    rows(text).map_err(Failure::BadInput)
}

fn rows(text: &str) -> Result<Vec<ReadStation>, String> {
    let text = unmarked(text);
    let mut reader = table(text);
    let header = reader.headers().map_err(|error| unread(&error))?.clone();
    if header.iter().all(str::is_empty) {
        return Err("is empty: it needs a line with the columns' names and a line for each station".to_owned());
    }
    let columns = columns(&header, text)?;
    let mut stations: Vec<ReadStation> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| unread(&error))?;
        let station = row(&columns, &header, &record)?;
        if let (Some(last), Some(md)) = (stations.last().and_then(|last| last.md_m), station.md_m)
            && md < last
        {
            return Err(format!(
                "line {}: depth falls from {last:.2} to {md:.2} m: sort the rows by depth; another run of the tool goes into a file \
                 of its own",
                line(&record)
            ));
        }
        stations.push(station);
    }
    if stations.is_empty() { Err("has no stations".to_owned()) } else { Ok(stations) }
}

fn row(columns: &Columns, header: &csv::StringRecord, record: &csv::StringRecord) -> Result<ReadStation, String> {
    let number = |column: usize| number(header, record, column);
    let three = |([x, y, z], factor): ([usize; 3], f64)| -> Result<Vector3<f64>, String> {
        Ok(columns.axes.turned([number(x)?, number(y)?, number(z)?]) * factor)
    };
    let measured = match (columns.six, columns.angles) {
        (Some([force, field]), _) => Measured::SixAxis { force_m_s2: three(force)?, field_ut: three(field)? },
        (None, Some([inclination, azimuth])) => Measured::Angles {
            inclination_rad: degrees_within(header, record, inclination, INCLINATION_DEG)?.to_radians(),
            magnetic_azimuth_rad: degrees_within(header, record, azimuth, AZIMUTH_DEG)?.to_radians(),
        },
        (None, None) => return Err("no measurement".to_owned()),
    };
    let t_s = columns.time.map(number).transpose()?;
    let md_m = columns.depth.map(|(column, factor)| number(column).map(|md| md * factor)).transpose()?;
    let sag_deg = columns.sag.map(number).transpose()?;
    Ok(ReadStation { t_s, md_m, measured, sag_deg, sigma_rad: None })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::{
        super::{column_names::FOOT_M, measured::STANDARD_GRAVITY_M_S2},
        *,
    };

    #[test]
    fn units_signs_and_axes_are_those_of_the_columns() {
        let ours = read("md_m,ax_m_s2,ay_m_s2,az_m_s2,bx_ut,by_ut,bz_ut\n100,1,2,-9.5,10,20,40\n").unwrap();
        let g = STANDARD_GRAVITY_M_S2;
        let theirs = format!(
            "# axes = -y x z\nmd_ft,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n{},{},{},{},20000,-10000,40000\n",
            100.0 / FOOT_M,
            -2.0 / g,
            1.0 / g,
            9.5 / g
        );
        let theirs = read(&theirs).unwrap();
        let (Measured::SixAxis { force_m_s2: a, field_ut: b }, Measured::SixAxis { force_m_s2: c, field_ut: d }) =
            (ours[0].measured, theirs[0].measured)
        else {
            panic!("six axes")
        };
        assert!((a - c).norm() < 1e-12 && (b - d).norm() < 1e-12, "{a} {c} {b} {d}");
        assert!((theirs[0].md_m.unwrap() - 100.0).abs() < 1e-9);
    }

    /// Spreadsheets write a byte order mark, and capitals where they like.
    #[test]
    fn axes_and_units_hold_behind_a_byte_order_mark_and_in_capitals() {
        let rest = "\nMD,Gx,Gy,Gz,Bx,By,Bz\n100,0.1,0.2,0.97,10000,20000,40000\n";
        let plain = read(&format!("# axes = y z x\n# units = ft g nT{rest}")).unwrap();
        assert_eq!(read(&format!("\u{feff}# Axes = Y Z X\n#UNITS = ft g nT{rest}")).unwrap(), plain);
        assert_eq!(read(&format!("\u{feff}# units = ft g nT\n# axes = y z x{rest}")).unwrap(), plain);
    }

    #[test]
    fn headers_of_other_programs_are_read() {
        let ours = read("md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n100,0.1,0.2,0.97,10000,20000,40000\n").unwrap();
        for theirs in [
            "MD (m),Gx (g),Gy (g),Gz (g),Bx (nT),By (nT),Bz (nT)\n100,0.1,0.2,0.97,10000,20000,40000\n",
            "Depth [m];Gx [mg];Gy [mg];Gz [mg];Bx [uT];By [uT];Bz [uT]\n100;100;200;970;10;20;40\n",
            "# units = m g nT\nMD\tGx\tGy\tGz\tBx\tBy\tBz\n100\t0.1\t0.2\t0.97\t10000\t20000\t40000\n",
        ] {
            let theirs = read(theirs).unwrap();
            let (Measured::SixAxis { force_m_s2: a, field_ut: b }, Measured::SixAxis { force_m_s2: c, field_ut: d }) =
                (ours[0].measured, theirs[0].measured)
            else {
                panic!("six axes")
            };
            assert!((a - c).norm() < 1e-12 && (b - d).norm() < 1e-12 && theirs[0].md_m == Some(100.0), "{theirs:?}");
        }
    }

    #[test]
    fn angles_out_of_their_range_are_told_with_their_place() {
        let with = |inclination: &str, azimuth: &str| {
            read(&format!("md_m,inclination_deg,magnetic_azimuth_deg\n1,2,3\n2,{inclination},{azimuth}\n"))
        };
        for inclination in ["-2", "-0.01", "180.01", "200"] {
            let error = with(inclination, "3").unwrap_err().to_string();
            let told =
                format!("line 3: column inclination_deg: \"{inclination}\" is out of range: must be 0 to 180 deg");
            assert_eq!(error, told);
        }
        for azimuth in ["-360.5", "721", "1e9"] {
            let error = with("2", azimuth).unwrap_err().to_string();
            let told =
                format!("line 3: column magnetic_azimuth_deg: \"{azimuth}\" is out of range: must be -360 to 720 deg");
            assert_eq!(error, told);
        }
        for (inclination, azimuth) in [("0", "-360"), ("-0.0", "-90"), ("180", "720")] {
            assert!(with(inclination, azimuth).is_ok(), "{inclination} {azimuth}");
        }
    }

    #[test]
    fn what_is_missing_or_no_number_is_told_with_its_line() {
        for (text, told) in [
            ("md_m,gx_g,gy_g,gz_g\n1,2,3,4\n", "lacks the field beside gx_g, gy_g, gz_g: bx_nt"),
            ("md_m,inclination_deg\n1,2\n", "lacks gravity (gx_g"),
            ("gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n", "lacks a column md_m"),
            (
                "md_m,inclination_deg,magnetic_azimuth_deg\n1,2,3\n0.9,2,3\n",
                "line 3: depth falls from 1.00 to 0.90 m: sort",
            ),
            (
                "md_m,inclination_deg,magnetic_azimuth_deg\n1,nan,3\n",
                "line 2: column inclination_deg: \"nan\" is no number: leave out",
            ),
            (
                "md_m;Inc (deg);magnetic_azimuth_deg\n1;2,5;3\n",
                "column Inc (deg): \"2,5\" is no number: write decimal points",
            ),
            ("md_m,inclination_deg,magnetic_azimuth_deg\n1,2,-999.25\n", "\"-999.25\" stands for no value"),
            ("md_m,inclination_deg,magnetic_azimuth_deg\n1,2,3\n1,2\n", "line 3: has 2 cells, the header 3"),
            ("", "is empty"),
            ("md_m,gx_g,gy_g,gz_g,bx_nt,by_nt\n1,2,3,4,5,6\n", "lacks bz_nt, beside bx_nt, by_nt"),
            ("MD (m),Inc (deg),Azi (deg)\n1,2,3\n", "azi_deg says not from which north: magnetic_azimuth_deg"),
            ("md_m,bx_nt,by_nt,bz_nt\n1,2,3,4\n", "lacks gravity beside bx_nt, by_nt, bz_nt: gx_g"),
            ("md_m,inclination_deg,magnetic_azimuth_deg\n", "no stations"),
            ("# axes = y x z\nmd_m,inclination_deg,magnetic_azimuth_deg\n1,2,3\n", "right-handed"),
            ("MD,Gx,Gy,Gz,Bx,By,Bz\n1,0,0,1,2,3,4\n", "md, gx, bx without a unit: a line \"# units = m g nT\""),
            (
                "Depth (m),MD (m),inclination_deg,magnetic_azimuth_deg\n1,2,3,4\n",
                "columns \"Depth (m)\" and \"MD (m)\" are both md_m",
            ),
            (
                "# units = m g nT\nMD,Gx,Gy,Gz,Bx (Oe),By,Bz\n1,0,0,1,2,3,4\n",
                "column \"Bx (Oe)\" has a unit that is not known",
            ),
            (
                "# units = m g nT\nMD (yd),Gx,Gy,Gz,Bx,By,Bz\n1,0,0,1,2,3,4\n",
                "column \"MD (yd)\" has a unit that is not known",
            ),
            ("# units = m g\nMD,Gx,Gy,Gz,Bx,By,Bz\n1,0,0,1,2,3,4\n", "must be those of depth, gravity and field"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
