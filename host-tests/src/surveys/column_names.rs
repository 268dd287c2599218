//! Names of a stations file's columns, as other programs write them. A unit stands in the name, as in `gx_g`,
//! `Gx (g)` or `Gx [g]`, or in a line `# units = m g nT` for depth, gravity and field. Nothing is guessed: a
//! column whose unit is nowhere stated has no name here.

/// Metres in a foot.
pub const FOOT_M: f64 = 0.3048;
/// Metres in a foot of the United States' old surveys (National Bureau of Standards, Federal Register 59-5442, 1959).
const SURVEY_FOOT_M: f64 = 1_200.0 / 3_937.0;
/// Columns of the depth, with their factors to metres.
pub const DEPTHS: [(&str, f64); 3] = [("md_m", 1.0), ("md_ft", FOOT_M), ("md_usft", SURVEY_FOOT_M)];

/// Units by the ways in which they are written, small letters.
const UNITS: [(&str, &str); 20] = [
    ("m", "m"),
    ("ft", "ft"),
    ("feet", "ft"),
    ("usft", "usft"),
    ("ftus", "usft"),
    ("s", "s"),
    ("g", "g"),
    ("mg", "mg"),
    ("m_s2", "m_s2"),
    ("m/s2", "m_s2"),
    ("m/s^2", "m_s2"),
    ("m/s²", "m_s2"),
    ("nt", "nt"),
    ("ut", "ut"),
    ("µt", "ut"),
    ("μt", "ut"),
    ("deg", "deg"),
    ("degrees", "deg"),
    ("°", "deg"),
    ("metres", "m"),
];

/// Quantities by the ways in which they are written, small letters, words joined by `_`.
const QUANTITIES: [(&str, &str); 8] = [
    ("depth", "md"),
    ("measured_depth", "md"),
    ("inc", "inclination"),
    ("incl", "inclination"),
    ("mag_azimuth", "magnetic_azimuth"),
    ("mag_azi", "magnetic_azimuth"),
    ("magnetic_azi", "magnetic_azimuth"),
    ("time", "t"),
];

/// Quantities that a line of units is for: depth, gravity, field.
const OF_LINE: [&[&str]; 3] = [&["md"], &["gx", "gy", "gz", "ax", "ay", "az"], &["bx", "by", "bz"]];

/// Units of depth, gravity and field that a line `# units = ..` states.
#[derive(Clone, Debug, PartialEq)]
pub struct Units([&'static str; 3]);

impl Units {
    /// Reads what stands behind `units =`.
    ///
    /// # Errors
    /// It is not three units that are known.
    pub fn parse(text: &str) -> Result<Self, String> {
        let bad = || format!("units = {text}: must be those of depth, gravity and field, such as m g nT");
        let mut words = text.split_whitespace();
        let mut next = || words.next().and_then(unit).ok_or_else(bad);
        let units = [next()?, next()?, next()?];
        if words.next().is_none() { Ok(Self(units)) } else { Err(bad()) }
    }
}

fn unit(text: &str) -> Option<&'static str> {
    let text = text.to_lowercase();
    UNITS.iter().find(|(written, _)| *written == text).map(|(_, unit)| *unit)
}

/// Name of a column with its unit at the end, as the stations' reader knows it. The line of units is for columns
/// without a bracket: one whose bracket holds no known unit has none.
#[must_use]
pub fn named(column: &str, units: Option<&Units>) -> String {
    let column = column.trim().to_lowercase();
    let (name, bracket) = match column.find(['(', '[']).and_then(|at| column.split_at_checked(at)) {
        Some((name, rest)) => (name, Some(rest.trim_matches(['(', ')', '[', ']', ' ']))),
        None => (column.as_str(), None),
    };
    let joined = name.split_whitespace().collect::<Vec<_>>().join("_");
    let quantity = QUANTITIES.iter().find(|(written, _)| *written == joined).map_or(joined.as_str(), |(_, name)| name);
    let of_line = || {
        let place = OF_LINE.iter().position(|names| names.contains(&quantity))?;
        units.and_then(|Units(units)| units.get(place)).copied()
    };
    match bracket.map_or_else(of_line, unit) {
        Some(unit) => format!("{quantity}_{unit}"),
        None => quantity.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_unit_stands_in_the_name_or_in_the_line() {
        for (written, name) in [
            ("gx_g", "gx_g"),
            (" Gx (g)", "gx_g"),
            ("Gz [mG]", "gz_mg"),
            ("Bx (nT)", "bx_nt"),
            ("BY [µT]", "by_ut"),
            ("Measured Depth (ft)", "md_ft"),
            ("MD (feet)", "md_ft"),
            ("Depth [usft]", "md_usft"),
            ("Inc (°)", "inclination_deg"),
            ("Magnetic azimuth [deg]", "magnetic_azimuth_deg"),
            ("Az (m/s^2)", "az_m_s2"),
        ] {
            assert_eq!(named(written, None), name);
        }
        let units = Units::parse("ft m/s2 nT").unwrap();
        assert_eq!(["MD", "Gx", "bz", "Gx (g)"].map(|x| named(x, Some(&units))), ["md_ft", "gx_m_s2", "bz_nt", "gx_g"]);
        // The line overrules no bracket.
        assert_eq!(["Bx (Oe)", "MD (yd)", "MD (m)"].map(|x| named(x, Some(&units))), ["bx", "md", "md_m"]);
        // No unit, no name that is read.
        assert_eq!(["Gx", "Bx (Oe)", "azimuth (deg)"].map(|x| named(x, None)), ["gx", "bx", "azimuth_deg"]);
        for bad in ["m g", "m g nT deg", "m g Oe"] {
            assert!(Units::parse(bad).unwrap_err().contains("m g nT"), "{bad}");
        }
    }
}
