//! Units of a source by their usual spellings, and the factor of each to the trace's own.

/// Quantity that a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Time stamps, to seconds.
    Time,
    /// Angular rate, to rad/s.
    Gyro,
    /// Specific force, to m/s^2.
    Accel,
    /// Magnetic field, to microtesla.
    Mag,
    /// Temperature, to degrees Celsius.
    Temperature,
    /// Attitude quaternion, scalar first.
    Reference,
}

/// A unit: name as printed and written, spellings, factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name in maps and messages.
    pub name: &'static str,
    /// Trace unit in one of these.
    pub factor: f64,
    /// Trace unit at zero of these.
    pub offset: f64,
    spellings: &'static [&'static str],
}

const fn unit(name: &'static str, factor: f64, spellings: &'static [&'static str]) -> Unit {
    Unit { name, factor, offset: 0.0, spellings }
}

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Standard gravity, m/s^2 (CGPM 1901): what "g" means.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

const TIME: &[Unit] = &[
    unit("s", 1.0, &["s", "sec", "secs", "second", "seconds", "secondselapsed"]),
    unit("ms", 1e-3, &["ms", "msec", "millis", "millisecond", "milliseconds"]),
    unit("us", 1e-6, &["us", "usec", "micros", "microsecond", "microseconds"]),
    unit("ns", 1e-9, &["ns", "nsec", "nanos", "nanosecond", "nanoseconds"]),
    unit("min", 60.0, &["min", "minutes"]),
];
const GYRO: &[Unit] = &[
    unit("rad/s", 1.0, &["rad/s", "rads", "rad", "radsec", "radpersec", "rads1"]),
    unit("deg/s", DEG, &["deg/s", "degs", "dps", "degsec", "degpersec", "degs1", "/s"]),
    unit("mdeg/s", DEG * 1e-3, &["mdeg/s", "mdps", "mdegs"]),
    unit("mrad/s", 1e-3, &["mrad/s", "mrads"]),
    unit("deg/h", DEG / 3_600.0, &["deg/h", "degh", "dph", "deghr"]),
    unit("rpm", std::f64::consts::PI / 30.0, &["rpm"]),
];
const ACCEL: &[Unit] = &[
    unit("m/s^2", 1.0, &["m/s2", "ms2", "m/s/s", "mpss", "mps2", "mss"]),
    unit("g", STANDARD_GRAVITY, &["g", "gn", "gs", "g0"]),
    unit("mg", STANDARD_GRAVITY * 1e-3, &["mg"]),
    unit("ug", STANDARD_GRAVITY * 1e-6, &["ug"]),
    unit("ft/s^2", 0.3048, &["ft/s2", "fts2"]),
];
const MAG: &[Unit] = &[
    unit("uT", 1.0, &["ut", "microtesla"]),
    unit("nT", 1e-3, &["nt", "nanotesla", "gamma"]),
    unit("mT", 1e3, &["mt", "millitesla"]),
    unit("T", 1e6, &["t", "tesla"]),
    unit("gauss", 100.0, &["gauss", "ga", "gs", "g"]),
    unit("mgauss", 0.1, &["mgauss", "mga", "mg", "milligauss"]),
];
const TEMPERATURE: &[Unit] = &[
    unit("degC", 1.0, &["degc", "c", "celsius"]),
    Unit { name: "K", factor: 1.0, offset: -273.15, spellings: &["k", "kelvin"] },
    Unit { name: "degF", factor: 5.0 / 9.0, offset: -160.0 / 9.0, spellings: &["degf", "f", "fahrenheit"] },
];
const NONE: &[Unit] = &[unit("1", 1.0, &["1"])];

impl Quantity {
    /// All units of this quantity.
    #[must_use]
    pub const fn units(self) -> &'static [Unit] {
        match self {
            Self::Time => TIME,
            Self::Gyro => GYRO,
            Self::Accel => ACCEL,
            Self::Mag => MAG,
            Self::Temperature => TEMPERATURE,
            Self::Reference => NONE,
        }
    }

    /// The unit of this spelling.
    #[must_use]
    pub fn unit(self, text: &str) -> Option<Unit> {
        let plain = plain(text);
        let spelt = |unit: &&Unit| unit.spellings.iter().any(|known| self::plain(known) == plain);
        self.units().iter().find(|unit| unit.name == text.trim()).or_else(|| self.units().iter().find(spelt)).copied()
    }

    /// The unit that stands in a column's name: in brackets, or as its last words.
    #[must_use]
    pub fn unit_in(self, name: &str) -> Option<Unit> {
        let bracketed = name.split(['(', '[', '{']).skip(1).filter_map(|rest| rest.split([')', ']', '}']).next());
        if let Some(unit) = bracketed.filter_map(|inside| self.unit(inside)).last() {
            return Some(unit);
        }
        let is_axis =
            |word: &&str| !matches!(word.to_ascii_lowercase().as_str(), "x" | "y" | "z" | "0" | "1" | "2" | "");
        let words: Vec<&str> = name.split(['_', ' ', '[', ']', '(', ')', '.']).filter(is_axis).collect();
        // Not the first word: alone it is the quantity's own name.
        (1..words.len()).find_map(|from| self.unit(&words[from..].concat()))
    }
}

/// Text of a name's last brackets, if it is in letters and no axis: the place of a unit.
#[must_use]
pub fn foreign_unit(name: &str) -> Option<&str> {
    let inside = name.rsplit(['(', '[', '{']).next().filter(|rest| rest.len() < name.len())?;
    let inside = inside.split([')', ']', '}']).next()?.trim();
    let is_axis = matches!(inside.to_ascii_lowercase().as_str(), "x" | "y" | "z" | "w");
    (inside.chars().any(char::is_alphabetic) && !is_axis).then_some(inside)
}

/// A spelling without what varies in it.
fn plain(text: &str) -> String {
    let letters = text.chars().flat_map(char::to_lowercase).filter_map(|letter| match letter {
        '\u{b5}' | '\u{3bc}' => Some('u'),
        '\u{b2}' => Some('2'),
        '/' | '^' | '*' | '_' | ' ' | '-' | '\u{b7}' => None,
        other => Some(other),
    });
    letters.collect::<String>().replace('\u{b0}', "deg")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_found_in_the_name_of_its_column() {
        for (quantity, name, unit) in [
            (Quantity::Gyro, "gyro_rad[0]", Some("rad/s")),
            (Quantity::Gyro, "Gyroscope x (\u{b0}/s)", Some("deg/s")),
            (Quantity::Gyro, "gyr_x_dps", Some("deg/s")),
            (Quantity::Gyro, "gx", None),
            (Quantity::Accel, "accelerometer_m_s2[2]", Some("m/s^2")),
            (Quantity::Accel, "Acc X [m/s\u{b2}]", Some("m/s^2")),
            (Quantity::Accel, "ax_g", Some("g")),
            (Quantity::Mag, "magnetometer_ga[1]", Some("gauss")),
            (Quantity::Mag, "Magnetic field y (\u{3bc}T)", Some("uT")),
            (Quantity::Mag, "mag.z_nT", Some("nT")),
            (Quantity::Time, "t_s", Some("s")),
            (Quantity::Time, "Time (ms)", Some("ms")),
            (Quantity::Time, "timestamp_us", Some("us")),
            (Quantity::Time, "timestamp", None),
            (Quantity::Temperature, "temp_c", Some("degC")),
        ] {
            assert_eq!(quantity.unit_in(name).map(|unit| unit.name), unit, "{name}");
        }
    }

    #[test]
    fn a_spelling_stands_for_one_unit_of_its_quantity() {
        for quantity in [Quantity::Time, Quantity::Gyro, Quantity::Accel, Quantity::Mag, Quantity::Temperature] {
            let spellings =
                quantity.units().iter().flat_map(|unit| unit.spellings.iter().map(|text| (plain(text), unit.name)));
            for (text, name) in spellings {
                assert_eq!(quantity.unit(&text).map(|unit| unit.name), Some(name), "{text}");
            }
            for unit in quantity.units() {
                assert_eq!(quantity.unit(unit.name).map(|unit| unit.name), Some(unit.name));
            }
        }
    }
}
