//! Columns of a stations file: which holds what, in which unit and with which sign.

use nalgebra::Vector3;

use super::{
    cells::{each_once, one_group, stated},
    column_names::{DEPTHS, Units, named},
    measured::STANDARD_GRAVITY_M_S2,
};

/// Columns of three axes: their names, and the factor to this program's unit.
const FORCES: [([&str; 3], f64); 4] = [
    (["ax_m_s2", "ay_m_s2", "az_m_s2"], 1.0),
    (["gx_m_s2", "gy_m_s2", "gz_m_s2"], -1.0),
    (["gx_g", "gy_g", "gz_g"], -STANDARD_GRAVITY_M_S2),
    (["gx_mg", "gy_mg", "gz_mg"], -1e-3 * STANDARD_GRAVITY_M_S2),
];
const FIELDS: [([&str; 3], f64); 2] = [(["bx_ut", "by_ut", "bz_ut"], 1.0), (["bx_nt", "by_nt", "bz_nt"], 1e-3)];
/// Columns of one number that are neither an axis nor the depth.
const OTHERS: [&str; 4] = ["t_s", "inclination_deg", "magnetic_azimuth_deg", "sag_deg"];

/// The columns that are used, by their places in a row.
pub(super) struct Columns {
    /// Time, seconds.
    pub time: Option<usize>,
    /// Measured depth, with the factor to metres.
    pub depth: Option<(usize, f64)>,
    /// Three axes of force and of field, with the factors to m/s^2 and microtesla.
    pub six: Option<[([usize; 3], f64); 2]>,
    /// Inclination and magnetic azimuth, degrees.
    pub angles: Option<[usize; 2]>,
    /// Sag, degrees.
    pub sag: Option<usize>,
    /// The file's axes.
    pub axes: Axes,
}

/// Which of the file's axes, 1 to 3 with a sign, is the tool's x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axes([i8; 3]);

impl Axes {
    fn parse(text: &str) -> Result<Self, String> {
        let bad = || format!("axes = {text}: must be a right-handed order such as x y z or -y x z");
        let mut axes = [0; 3];
        let mut words = text.split_whitespace();
        for axis in &mut axes {
            *axis = match words.next().ok_or_else(bad)?.to_lowercase().as_str() {
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

    /// A vector of the file, in the tool's axes.
    pub fn turned(self, v: [f64; 3]) -> Vector3<f64> {
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

/// The columns of a header; `text` is that of the file.
///
/// # Errors
/// Description of what is lacking, or has no unit.
pub(super) fn columns(header: &csv::StringRecord, text: &str) -> Result<Columns, String> {
    let units = stated(text, "units").map(Units::parse).transpose()?;
    let written = header;
    let header: Vec<String> = written.iter().map(|column| named(column, units.as_ref())).collect();
    let axes_of = FORCES.iter().chain(&FIELDS).flat_map(|(names, _)| *names);
    each_once(written, &header, axes_of.chain(DEPTHS.map(|(name, _)| name)).chain(OTHERS))?;
    one_group(written, &header, "depth", DEPTHS.iter().map(|(name, _)| std::slice::from_ref(name)))?;
    one_group(written, &header, "gravity", FORCES.iter().map(|(names, _)| names.as_slice()))?;
    one_group(written, &header, "field", FIELDS.iter().map(|(names, _)| names.as_slice()))?;
    let find = |name: &str| header.iter().position(|column| column == name);
    let three = |names: [&str; 3]| {
        let [x, y, z] = names.map(find);
        Some([x?, y?, z?])
    };
    let force = FORCES.iter().find_map(|(names, factor)| Some((three(*names)?, *factor)));
    let field = FIELDS.iter().find_map(|(names, factor)| Some((three(*names)?, *factor)));
    let depth = DEPTHS.iter().find_map(|(name, factor)| Some((find(name)?, *factor)));
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
    let is_bare = |name: &String| ["md", "gx", "ax", "bx"].contains(&name.as_str());
    let bare = header.iter().filter(|name| is_bare(name)).map(String::as_str).collect::<Vec<_>>().join(", ");
    let bracketed =
        || written.iter().zip(&header).find(|(written, name)| is_bare(name) && written.contains(['(', '[']));
    let [placed, measured] =
        [columns.time.is_some() || columns.depth.is_some(), columns.six.is_some() || columns.angles.is_some()];
    let usable = placed && measured;
    if let (false, Some((written, _))) = (usable, bracketed()) {
        return Err(format!(
            "column {written:?} has a unit that is not known here: m, ft or usft of depth, g, mg or m/s2 of gravity, nT or uT \
             of the field"
        ));
    }
    if !usable && !bare.is_empty() {
        return Err(format!(
            "{bare} without a unit: a line \"# units = m g nT\" before the header gives those of depth, gravity and field"
        ));
    }
    if !placed {
        return Err("lacks a column md_m, md_ft, md_usft or t_s".to_owned());
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

/// Description of what is missing where some of what belongs together is there: an axis of three, gravity or field of
/// the two, or the north of an azimuth.
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
