//! Stations of a trajectory, as the two versions of WITSML share them. Elements stand in the order of the schemas'
//! sequences; the versions differ in their names' first letter, in depths, and in where the readings stand.

use quick_xml::{
    Writer,
    events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event},
};

use crate::surveys::run::{SurveyedRun, SurveyedStation};

/// A version of WITSML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    /// 1.4.1.1: names begin small.
    V1,
    /// 2.0: names begin with a capital, and depths say what they count from.
    V2,
}

/// A document that is being written.
pub(super) struct Document {
    version: Version,
    writer: Writer<Vec<u8>>,
}

impl Document {
    /// A document that says what it is.
    pub(super) fn new(version: Version) -> Self {
        let mut document = Self { version, writer: Writer::new_with_indent(Vec::new(), b' ', 1) };
        document.write(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        document
    }

    /// The text.
    pub(super) fn text(self) -> String {
        String::from_utf8_lossy(&self.writer.into_inner()).into_owned() + "\n"
    }

    /// Writing to memory does not fail.
    fn write(&mut self, event: Event<'_>) {
        let _ = self.writer.write_event(event);
    }

    /// An element of elements, its name as it stands.
    pub(super) fn within(&mut self, name: &str, attributes: &[(&str, &str)], inner: impl FnOnce(&mut Self)) {
        self.write(Event::Start(BytesStart::new(name).with_attributes(attributes.iter().copied())));
        inner(self);
        self.write(Event::End(BytesEnd::new(name)));
    }

    /// An element of a text, its name as it stands.
    pub(super) fn plain(&mut self, name: &str, attributes: &[(&str, &str)], value: &str) {
        let element = self.writer.create_element(name).with_attributes(attributes.iter().copied());
        let _ = element.write_text_content(BytesText::new(value));
    }

    /// The version's form of a name that begins small.
    fn named(&self, name: &str) -> String {
        match (self.version, name.get(..1), name.get(1..)) {
            (Version::V2, Some(first), Some(rest)) => first.to_uppercase() + rest,
            _ => name.to_owned(),
        }
    }

    /// A text.
    pub(super) fn word(&mut self, name: &str, value: &str) {
        self.plain(&self.named(name), &[], value);
    }

    /// A number with its unit.
    pub(super) fn number(&mut self, name: &str, unit: &str, value: f64, decimals: usize) {
        self.plain(&self.named(name), &[("uom", unit)], &format!("{value:.decimals$}"));
    }

    /// A depth; version 2.0 names its zero, the kelly bushing.
    pub(super) fn depth(&mut self, name: &str, value: f64) {
        let attributes: &[(&str, &str)] = match self.version {
            Version::V1 => &[("uom", "m")],
            Version::V2 => &[("uom", "m"), ("datum", "KB")],
        };
        self.plain(&self.named(name), attributes, &format!("{value:.3}"));
    }

    /// An element of elements, in the version's form of its name.
    fn group(&mut self, name: &str, attributes: &[(&str, &str)], inner: impl FnOnce(&mut Self)) {
        self.within(&self.named(name), attributes, inner);
    }
}

/// Depths of the whole run, and declination and convergence of its first station.
pub(super) fn ends(out: &mut Document, run: &SurveyedRun) {
    if let (Some(first), Some(last)) = (run.stations.first(), run.stations.last()) {
        out.depth("mdMn", first.md_m);
        out.depth("mdMx", last.md_m);
        out.number("magDeclUsed", "dega", first.reference.declination_deg, 4);
        out.number("gridConUsed", "dega", first.convergence_deg.unwrap_or(0.0), 4);
    }
}

/// Writes the north that azimuths count from, and all stations.
pub(super) fn stations(out: &mut Document, run: &SurveyedRun) {
    out.number("aziVertSect", "dega", run.vertical_section_deg, 4);
    out.word("aziRef", if run.convergence_deg.is_some() { "grid north" } else { "true north" });
    for (k, s) in run.stations.iter().enumerate() {
        out.group("trajectoryStation", &[("uid", &(k + 1).to_string())], |out| station(out, run, s));
    }
}

fn station(out: &mut Document, run: &SurveyedRun, s: &SurveyedStation) {
    // Each version has a list of its own; neither has one for angles of an unknown tool.
    let kind = match (s.readings, out.version) {
        (None, _) => "unknown",
        (Some(_), Version::V1) => "magnetic MWD",
        (Some(_), Version::V2) => "MD INCL and AZI",
    };
    out.word("typeTrajStation", kind);
    out.word("typeSurveyTool", "magnetic MWD");
    out.word("calcAlgorithm", "minimum curvature");
    let [north, east, tvd] = s.position_m;
    out.depth("md", s.md_m);
    out.depth("tvd", tvd);
    out.number("incl", "dega", s.inclination_deg, 4);
    out.number("azi", "dega", s.azimuth_deg, 4);
    if let Some(toolface) = s.gravity_toolface_deg {
        out.number("gtf", "dega", toolface, 2);
    }
    out.number("dispNs", "m", north, 3);
    out.number("dispEw", "m", east, 3);
    out.number("vertSect", "m", s.vertical_section_m, 3);
    out.number("dls", "dega/m", s.dogleg_deg_30m / 30.0, 6);
    let flag = |out: &mut Document, name: &str, is: bool| out.word(name, if is { "true" } else { "false" });
    flag(out, "sagCorUsed", run.sag.is_some());
    flag(out, "axialMagInterferenceCorUsed", s.corrected == "axial");
    flag(out, "MSACorUsed", s.corrected == "multi-station");
    out.number("gravTotalFieldReference", "m/s2", s.reference.gravity_m_s2, 5);
    out.number("magTotalFieldReference", "nT", 1e3 * s.reference.field_ut, 1);
    out.number("magDipAngleReference", "dega", s.reference.dip_deg, 4);
    out.word("magModelUsed", &short(&s.reference_model));
    out.word("magModelValid", &s.reference_date);
    out.word("statusTrajStation", if s.doubted { "rejected" } else { "open" });
    if out.version == Version::V1 {
        readings(out, s);
        north_corrections(out, s);
    }
    if let Some([gravity, field, dip]) = s.off_reference {
        out.group("valid", &[], |out| {
            out.number("magTotalFieldCalc", "nT", 1e3 * (field + s.reference.field_ut), 1);
            out.number("magDipAngleCalc", "dega", dip + s.reference.dip_deg, 4);
            out.number("gravTotalFieldCalc", "m/s2", gravity + s.reference.gravity_m_s2, 5);
        });
    }
    out.group("matrixCov", &[], |out| covariance(out, s));
    if out.version == Version::V2 {
        readings(out, s);
        north_corrections(out, s);
    }
}

/// Sag, declination and convergence that the angles have.
fn north_corrections(out: &mut Document, s: &SurveyedStation) {
    out.group("corUsed", &[], |out| {
        out.number("sagIncCor", "dega", s.sag_deg, 4);
        out.number("stnMagDeclUsed", "dega", s.reference.declination_deg, 4);
        out.number("stnGridConUsed", "dega", s.convergence_deg.unwrap_or(0.0), 4);
    });
}

fn readings(out: &mut Document, s: &SurveyedStation) {
    let Some([force, field]) = s.readings else { return };
    out.group("rawData", &[], |out| {
        // Gravity, down: the accelerometer reads the opposite.
        for (name, value) in [("gravAxialRaw", -force[2]), ("gravTran1Raw", -force[0]), ("gravTran2Raw", -force[1])] {
            out.number(name, "m/s2", value, 5);
        }
        for (name, value) in [("magAxialRaw", field[2]), ("magTran1Raw", field[0]), ("magTran2Raw", field[1])] {
            out.number(name, "nT", 1e3 * value, 1);
        }
    });
}

fn covariance(out: &mut Document, s: &SurveyedStation) {
    let c = &s.covariance_m2;
    for (name, value) in [
        ("varianceNN", c[0][0]),
        ("varianceNE", c[0][1]),
        ("varianceNVert", c[0][2]),
        ("varianceEE", c[1][1]),
        ("varianceEVert", c[1][2]),
        ("varianceVertVert", c[2][2]),
    ] {
        out.number(name, "m2", value, 5);
    }
    if out.version == Version::V2 {
        // The error model has no offsets.
        for name in ["biasN", "biasE", "biasVert"] {
            out.number(name, "m", 0.0, 1);
        }
    }
}

/// A name of at most 64 characters, as the schemas demand.
pub(super) fn short(name: &str) -> String {
    name.chars().take(64).collect()
}

/// An identifier of a custom kind (UUID version 8, RFC 9562) from two texts, by the 64-bit FNV-1a hash: the same well
/// has the same in both versions, and it holds no space, which 1.4.1.1 forbids.
pub(super) fn identifier(kind: &str, name: &str) -> String {
    let hash = |seed: u64| {
        (kind.bytes().chain([0]).chain(name.bytes()))
            .fold(0xcbf2_9ce4_8422_2325 ^ seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    };
    let (high, low) = (hash(0), hash(0x9e37_79b9_7f4a_7c15));
    let bits = u128::from(high) << 64 | u128::from(low);
    let bits = bits & !(0xf << 76) & !(0x3 << 62) | 0x8 << 76 | 0x2 << 62;
    let hex = format!("{bits:032x}");
    [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]].join("-")
}
