//! WITSML 2.0: a trajectory (Energistics, 2016). Elements stand in the order of the schema's sequence.

use super::{
    push,
    xml::{element, escaped},
};
use crate::surveys::surveyed::{SurveyedRun, SurveyedStation};

/// The run as a `Trajectory` document. Identifiers follow from the well's name, so that the same well has the same.
#[must_use]
pub fn witsml(run: &SurveyedRun) -> String {
    let well = escaped(&run.well);
    let now = if run.provenance.date.is_empty() { "1970-01-01" } else { run.provenance.date.as_str() };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <Trajectory xmlns=\"http://www.energistics.org/energyml/data/witsmlv2\" \
         xmlns:eml=\"http://www.energistics.org/energyml/data/commonv2\" schemaVersion=\"2.0\" uuid=\"{}\">\n\
         <eml:Citation>\n<eml:Title>{well} MWD surveys</eml:Title>\n<eml:Originator>meerkat-mwd</eml:Originator>\n\
         <eml:Creation>{now}T00:00:00Z</eml:Creation>\n<eml:Format>meerkat-mwd</eml:Format>\n</eml:Citation>\n\
         <GrowingStatus>closed</GrowingStatus>\n",
        identifier("trajectory", &run.well)
    );
    if let (Some(first), Some(last)) = (run.stations.first(), run.stations.last()) {
        depth(&mut text, "MdMn", first.md_m);
        depth(&mut text, "MdMx", last.md_m);
        number(&mut text, "MagDeclUsed", "dega", last.reference.declination_deg, 4);
    }
    number(&mut text, "GridConUsed", "dega", run.convergence_deg.unwrap_or(0.0), 4);
    number(&mut text, "AziVertSect", "dega", run.vertical_section_deg, 4);
    element(&mut text, "AziRef", None, if run.convergence_deg.is_some() { "grid north" } else { "true north" });
    for (k, station) in run.stations.iter().enumerate() {
        push(&mut text, format_args!("<TrajectoryStation uid=\"{}\">\n", k + 1));
        one(&mut text, run, station);
        text.push_str("</TrajectoryStation>\n");
    }
    push(
        &mut text,
        format_args!(
            "<Wellbore>\n<eml:ContentType>application/x-witsml+xml;version=2.0;type=Wellbore</eml:ContentType>\n\
             <eml:Title>{well}</eml:Title>\n<eml:Uuid>{}</eml:Uuid>\n</Wellbore>\n</Trajectory>\n",
            identifier("wellbore", &run.well)
        ),
    );
    text
}

fn number(text: &mut String, name: &str, unit: &str, value: f64, decimals: usize) {
    element(text, name, Some(unit), &format!("{value:.decimals$}"));
}

/// A depth, which names what it counts from: the kelly bushing.
fn depth(text: &mut String, name: &str, value: f64) {
    push(text, format_args!("<{name} uom=\"m\" datum=\"KB\">{value:.3}</{name}>\n"));
}

fn one(text: &mut String, run: &SurveyedRun, s: &SurveyedStation) {
    let [north, east, tvd] = s.position_m;
    element(text, "TypeTrajStation", None, if s.readings.is_some() { "MD INCL and AZI" } else { "unknown" });
    element(text, "TypeSurveyTool", None, "magnetic MWD");
    element(text, "CalcAlgorithm", None, "minimum curvature");
    depth(text, "Md", s.md_m);
    depth(text, "Tvd", tvd);
    number(text, "Incl", "dega", s.inclination_deg, 4);
    number(text, "Azi", "dega", s.azimuth_deg, 4);
    if let Some(toolface) = s.gravity_toolface_deg {
        number(text, "Gtf", "dega", toolface, 2);
    }
    number(text, "DispNs", "m", north, 3);
    number(text, "DispEw", "m", east, 3);
    number(text, "VertSect", "m", s.vertical_section_m, 3);
    number(text, "Dls", "dega/m", s.dogleg_deg_30m / 30.0, 6);
    element(text, "SagCorUsed", None, if s.sag_deg == 0.0 { "false" } else { "true" });
    element(text, "AxialMagInterferenceCorUsed", None, if s.corrected == "axial" { "true" } else { "false" });
    element(text, "MSACorUsed", None, if s.corrected == "multi-station" { "true" } else { "false" });
    number(text, "GravTotalFieldReference", "m/s2", s.reference.gravity_m_s2, 5);
    number(text, "MagTotalFieldReference", "nT", 1e3 * s.reference.field_ut, 1);
    number(text, "MagDipAngleReference", "dega", s.reference.dip_deg, 4);
    element(text, "MagModelUsed", None, &run.provenance.model);
    element(text, "MagModelValid", None, &run.provenance.date);
    element(text, "StatusTrajStation", None, if s.doubted { "rejected" } else { "open" });
    if let Some([gravity, field, dip]) = s.off_reference {
        text.push_str("<Valid>\n");
        number(text, "MagTotalFieldCalc", "nT", 1e3 * (field + s.reference.field_ut), 1);
        number(text, "MagDipAngleCalc", "dega", dip + s.reference.dip_deg, 4);
        number(text, "GravTotalFieldCalc", "m/s2", gravity + s.reference.gravity_m_s2, 5);
        text.push_str("</Valid>\n");
    }
    text.push_str("<MatrixCov>\n");
    let c = &s.covariance_m2;
    for (name, value) in [
        ("VarianceNN", c[0][0]),
        ("VarianceNE", c[0][1]),
        ("VarianceNVert", c[0][2]),
        ("VarianceEE", c[1][1]),
        ("VarianceEVert", c[1][2]),
        ("VarianceVertVert", c[2][2]),
        // The error model has no offsets.
    ] {
        number(text, name, "m2", value, 5);
    }
    for name in ["BiasN", "BiasE", "BiasVert"] {
        number(text, name, "m", 0.0, 1);
    }
    text.push_str("</MatrixCov>\n");
    if let Some([force, field]) = s.readings {
        text.push_str("<RawData>\n");
        // Gravity, down: the accelerometer reads the opposite.
        for (name, value) in [("GravAxialRaw", -force[2]), ("GravTran1Raw", -force[0]), ("GravTran2Raw", -force[1])] {
            number(text, name, "m/s2", value, 5);
        }
        for (name, value) in [("MagAxialRaw", field[2]), ("MagTran1Raw", field[0]), ("MagTran2Raw", field[1])] {
            number(text, name, "nT", 1e3 * value, 1);
        }
        text.push_str("</RawData>\n");
    }
}

/// An identifier of a custom kind (UUID version 8, RFC 9562) from two texts, by the 64-bit FNV-1a hash.
fn identifier(kind: &str, name: &str) -> String {
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
