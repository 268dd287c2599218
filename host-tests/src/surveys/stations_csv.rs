//! Stations from a CSV file, as this program or another one writes them. A column's name says its unit and its sign:
//! nothing is guessed.

use nalgebra::Vector3;

use super::{
    cells::{line, number, unread},
    column_names::{Units, named},
};
use crate::failure::Failure;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;
/// Standard gravity, m/s^2.
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadStation {
    /// Time, seconds, if the file has it.
    pub t_s: Option<f64>,
    /// Measured depth, metres; `None` in a file by time alone.
    pub md_m: Option<f64>,
    /// What the tool measured.
    pub measured: Measured,
    /// Sag to add to the inclination, degrees, if the file has it.
    pub sag_deg: Option<f64>,
}

/// What a row says of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Specific force, m/s^2, and field, microtesla, tool axes (z down-hole, right-handed).
    SixAxis {
        /// Points up at rest.
        force_m_s2: Vector3<f64>,
        /// Field.
        field_ut: Vector3<f64>,
    },
    /// Inclination and azimuth from magnetic north, radians.
    Angles {
        /// From the vertical.
        inclination_rad: f64,
        /// From magnetic north.
        magnetic_azimuth_rad: f64,
    },
}

/// Columns of three axes: their names, and the factor to this program's unit.
const FORCES: [([&str; 3], f64); 4] = [
    (["ax_m_s2", "ay_m_s2", "az_m_s2"], 1.0),
    (["gx_m_s2", "gy_m_s2", "gz_m_s2"], -1.0),
    (["gx_g", "gy_g", "gz_g"], -STANDARD_GRAVITY_M_S2),
    (["gx_mg", "gy_mg", "gz_mg"], -1e-3 * STANDARD_GRAVITY_M_S2),
];
const FIELDS: [([&str; 3], f64); 2] = [(["bx_ut", "by_ut", "bz_ut"], 1.0), (["bx_nt", "by_nt", "bz_nt"], 1e-3)];

struct Columns {
    time: Option<usize>,
    depth: Option<(usize, f64)>,
    six: Option<[([usize; 3], f64); 2]>,
    angles: Option<[usize; 2]>,
    sag: Option<usize>,
    axes: Axes,
}

/// Which of the file's axes, 1 to 3 with a sign, is the tool's x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axes([i8; 3]);

impl Axes {
    fn parse(text: &str) -> Result<Self, String> {
        let bad = || format!("axes = {text}: must be a right-handed order such as x y z or -y x z");
        let mut axes = [0; 3];
        let mut words = text.split_whitespace();
        for axis in &mut axes {
            *axis = match words.next().ok_or_else(bad)? {
                "x" => 1,
                "y" => 2,
                "z" => 3,
                "-x" => -1,
                "-y" => -2,
                "-z" => -3,
                _ => return Err(bad()),
            };
        }
        let unit = |axis: i8| Vector3::ith(usize::from(axis.unsigned_abs()) - 1, f64::from(axis.signum()));
        let [x, y, z] = axes.map(unit);
        if words.next().is_none() && x.cross(&y) == z { Ok(Self(axes)) } else { Err(bad()) }
    }

    fn turned(self, v: [f64; 3]) -> Vector3<f64> {
        let [x, y, z] = v;
        let of = |axis: i8| match axis.unsigned_abs() {
            1 => x * f64::from(axis.signum()),
            2 => y * f64::from(axis.signum()),
            _ => z * f64::from(axis.signum()),
        };
        let Self([a, b, c]) = self;
        Vector3::new(of(a), of(b), of(c))
    }
}

/// Reads the text of a file.
///
/// # Errors
/// The first line or column that cannot be used, and why.
pub fn read(text: &str) -> Result<Vec<ReadStation>, Failure> {
    rows(text).map_err(Failure::BadInput)
}

fn rows(text: &str) -> Result<Vec<ReadStation>, String> {
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

/// A table's rows, whatever stands between its columns.
fn table(text: &str) -> csv::Reader<&[u8]> {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(delimiter(text)).comment(Some(b'#')).trim(csv::Trim::All).flexible(false);
    builder.from_reader(text.as_bytes())
}

/// What stands between the columns: the one of comma, semicolon and tab that the header has most of.
fn delimiter(text: &str) -> u8 {
    let header = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let count = |delimiter: &u8| header.bytes().filter(|byte| byte == delimiter).count();
    // Of equal ones the last is taken: comma.
    [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',')
}

/// What a line `# key = value` says.
fn stated<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix('#')?.split_once('='));
    lines.find(|(name, _)| name.trim() == key).map(|(_, value)| value.trim())
}

fn columns(header: &csv::StringRecord, text: &str) -> Result<Columns, String> {
    let units = stated(text, "units").map(Units::parse).transpose()?;
    let header: Vec<String> = header.iter().map(|column| named(column, units.as_ref())).collect();
    let find = |name: &str| header.iter().position(|column| column == name);
    let three = |names: [&str; 3]| {
        let [x, y, z] = names.map(find);
        Some([x?, y?, z?])
    };
    let force = FORCES.iter().find_map(|(names, factor)| Some((three(*names)?, *factor)));
    let field = FIELDS.iter().find_map(|(names, factor)| Some((three(*names)?, *factor)));
    let depth = find("md_m").map(|k| (k, 1.0)).or_else(|| find("md_ft").map(|k| (k, FOOT_M)));
    let angles = find("inclination_deg").zip(find("magnetic_azimuth_deg")).map(|(i, a)| [i, a]);
    let axes = stated(text, "axes").map_or(Ok(Axes([1, 2, 3])), Axes::parse)?;
    let columns = Columns {
        time: find("t_s"),
        depth,
        six: force.zip(field).map(|(a, b)| [a, b]),
        angles,
        sag: find("sag_deg"),
        axes,
    };
    let bare = ["md", "gx", "ax", "bx"].into_iter().filter(|name| find(name).is_some()).collect::<Vec<_>>().join(", ");
    let [placed, measured] =
        [columns.time.is_some() || columns.depth.is_some(), columns.six.is_some() || columns.angles.is_some()];
    let usable = placed && measured;
    if !usable && !bare.is_empty() {
        return Err(format!(
            "{bare} without a unit: a line \"# units = m g nT\" before the header gives those of depth, gravity and field"
        ));
    }
    if !placed {
        return Err("lacks a column md_m, md_ft or t_s".to_owned());
    }
    if !measured {
        if let Some(part) = in_part(&header) {
            return Err(part);
        }
        return Err(
            "lacks gravity (gx_g, gx_mg, gx_m_s2, down; or ax_m_s2, up; likewise y and z) and field (bx_nt or \
                    bx_ut, likewise y and z), or inclination_deg and magnetic_azimuth_deg"
                .to_owned(),
        );
    }
    Ok(columns)
}

/// What is missing where some of what belongs together is there: an axis of three, gravity or field of the two, or the
/// north of an azimuth.
fn in_part(header: &[String]) -> Option<String> {
    let has = |name: &str| header.iter().any(|column| column == name);
    for (names, _) in FORCES.iter().chain(&FIELDS) {
        let [there, absent]: [Vec<&str>; 2] =
            [true, false].map(|is| names.iter().copied().filter(|n| has(n) == is).collect());
        if !there.is_empty() && !absent.is_empty() {
            return Some(format!("lacks {}, beside {}", absent.join(", "), there.join(", ")));
        }
    }
    let whole = |(names, _): &([&'static str; 3], f64)| names.iter().all(|name| has(name)).then(|| names.join(", "));
    let azimuth = header.iter().find(|column| column.starts_with("azi"));
    if let (Some(azimuth), true) = (azimuth, has("inclination_deg")) {
        return Some(format!(
            "{azimuth} says not from which north: magnetic_azimuth_deg is from magnetic north, as a tool reads it"
        ));
    }
    match (FORCES.iter().find_map(whole), FIELDS.iter().find_map(whole)) {
        (Some(gravity), None) => {
            Some(format!("lacks the field beside {gravity}: bx_nt, by_nt, bz_nt or bx_ut, by_ut, bz_ut"))
        }
        (None, Some(field)) => Some(format!(
            "lacks gravity beside {field}: gx_g, gy_g, gz_g (or _mg, _m_s2), down, or ax_m_s2, ay_m_s2, az_m_s2, up"
        )),
        _ => None,
    }
}

fn row(columns: &Columns, header: &csv::StringRecord, record: &csv::StringRecord) -> Result<ReadStation, String> {
    let number = |column: usize| number(header, record, column);
    let three = |([x, y, z], factor): ([usize; 3], f64)| -> Result<Vector3<f64>, String> {
        Ok(columns.axes.turned([number(x)?, number(y)?, number(z)?]) * factor)
    };
    let measured = match (columns.six, columns.angles) {
        (Some([force, field]), _) => Measured::SixAxis { force_m_s2: three(force)?, field_ut: three(field)? },
        (None, Some([inclination, azimuth])) => Measured::Angles {
            inclination_rad: number(inclination)?.to_radians(),
            magnetic_azimuth_rad: number(azimuth)?.to_radians(),
        },
        (None, None) => return Err("no measurement".to_owned()),
    };
    let t_s = columns.time.map(number).transpose()?;
    let md_m = columns.depth.map(|(column, factor)| number(column).map(|md| md * factor)).transpose()?;
    let sag_deg = columns.sag.map(number).transpose()?;
    Ok(ReadStation { t_s, md_m, measured, sag_deg })
}

/// Depths of the bit by time, to give stations by time their depths.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthByTime(Vec<[f64; 2]>);

impl DepthByTime {
    /// Reads the text of a file with the columns `t_s` and `md_m`. `offset_m` is the distance from the bit to the
    /// tool, `clock_s` what is added to the file's clock to get the tool's.
    ///
    /// # Errors
    /// The first line or column that cannot be used, and why.
    pub fn read(text: &str, offset_m: f64, clock_s: f64) -> Result<Self, Failure> {
        Self::rows(text, offset_m, clock_s).map_err(|why| Failure::BadInput(format!("depth file: {why}")))
    }

    fn rows(text: &str, offset_m: f64, clock_s: f64) -> Result<Self, String> {
        let mut reader = table(text);
        let header = reader.headers().map_err(|error| unread(&error))?.clone();
        let units = stated(text, "units").map(Units::parse).transpose()?;
        let find = |name: &str| header.iter().position(|column| named(column, units.as_ref()) == name);
        let depth = find("md_m").map(|k| (k, 1.0)).or_else(|| find("md_ft").map(|k| (k, FOOT_M)));
        let (Some(time), Some((depth, metres))) = (find("t_s"), depth) else {
            let has = header.iter().collect::<Vec<_>>().join(", ");
            return Err(format!(
                "lacks a column t_s, or md_m or md_ft: the first line must name them, and says {has:?}"
            ));
        };
        let mut points: Vec<[f64; 2]> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| unread(&error))?;
            let [t, md] = [number(&header, &record, time)?, metres * number(&header, &record, depth)?];
            if points.last().is_some_and(|[last, _]| t + clock_s <= *last) {
                return Err(format!(
                    "line {}: time does not increase: sort the rows by t_s, each time once",
                    line(&record)
                ));
            }
            points.push([t + clock_s, md - offset_m]);
        }
        Ok(Self(points))
    }

    /// First and last time, by the tool's clock; `None` without a line.
    #[must_use]
    pub fn span_s(&self) -> Option<[f64; 2]> {
        Some([self.0.first()?[0], self.0.last()?[0]])
    }

    /// Depth of the tool at a time, between the file's lines; `None` outside of it.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<f64> {
        self.0.windows(2).find_map(|pair| match pair {
            [[t0, md0], [t1, md1]] if t_s >= *t0 && t_s <= *t1 => Some(md0 + (md1 - md0) * (t_s - t0) / (t1 - t0)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;

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
            ("# units = m g\nMD,Gx,Gy,Gz,Bx,By,Bz\n1,0,0,1,2,3,4\n", "must be those of depth, gravity and field"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn a_depth_file_of_another_program_is_read_and_its_faults_are_told_with_their_lines() {
        let depth = DepthByTime::read("Time (s);Depth (ft)\n0;1000\n100;1100\n", 0.0, 0.0).unwrap();
        assert!((depth.at(50.0).unwrap() - 1_050.0 * FOOT_M).abs() < 1e-9);
        for (text, told) in [
            ("", "lacks a column t_s"),
            ("time,depth\n1,2\n", "says \"time, depth\""),
            ("t_s,md_m\n1,2\n1,3\n", "line 3: time does not increase"),
            ("t_s,md_m\n1,NaN\n", "line 2: column md_m: \"NaN\" is no number"),
        ] {
            let error = DepthByTime::read(text, 0.0, 0.0).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn depth_by_time_is_the_bits_less_the_distance_to_the_tool_by_the_tools_clock() {
        let depth = DepthByTime::read("t_s,md_m\n0,1000\n100,1010\n", 15.0, 7.0).unwrap();
        assert_eq!(depth.at(57.0), Some(990.0));
        assert_eq!((depth.at(6.9), depth.at(107.1)), (None, None));
    }
}
