//! WITSML 1.4.1.1: a trajectory (Energistics, 2011). Elements stand in the order of the schema's sequence.

use super::{
    push,
    xml::{element, escaped},
};
use crate::surveys::surveyed::{SurveyedRun, SurveyedStation};

/// The run as a `trajectorys` document.
#[must_use]
pub fn witsml(run: &SurveyedRun) -> String {
    let well = escaped(&run.well);
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <trajectorys xmlns=\"http://www.witsml.org/schemas/1series\" version=\"1.4.1.1\">\n\
         <trajectory uidWell=\"{well}\" uidWellbore=\"{well}-1\" uid=\"mwd\">\n\
         <nameWell>{well}</nameWell>\n<nameWellbore>{well}</nameWellbore>\n<name>MWD surveys</name>\n"
    );
    let number = |text: &mut String, name: &str, unit: &str, value: f64, decimals: usize| {
        element(text, name, Some(unit), &format!("{value:.decimals$}"));
    };
    if let (Some(first), Some(last)) = (run.stations.first(), run.stations.last()) {
        number(&mut text, "mdMn", "m", first.md_m, 3);
        number(&mut text, "mdMx", "m", last.md_m, 3);
        number(&mut text, "magDeclUsed", "dega", last.reference.declination_deg, 4);
    }
    number(&mut text, "gridCorUsed", "dega", run.convergence_deg.unwrap_or(0.0), 4);
    number(&mut text, "aziVertSect", "dega", run.vertical_section_deg, 4);
    let north = if run.convergence_deg.is_some() { "grid north" } else { "true north" };
    element(&mut text, "aziRef", None, north);
    for (k, station) in run.stations.iter().enumerate() {
        push(&mut text, format_args!("<trajectoryStation uid=\"{}\">\n", k + 1));
        one(&mut text, run, station);
        text.push_str("</trajectoryStation>\n");
    }
    text.push_str("</trajectory>\n</trajectorys>\n");
    text
}

fn one(text: &mut String, run: &SurveyedRun, s: &SurveyedStation) {
    let number = |text: &mut String, name: &str, unit: &str, value: f64, decimals: usize| {
        element(text, name, Some(unit), &format!("{value:.decimals$}"));
    };
    let [north, east, tvd] = s.position_m;
    element(text, "typeTrajStation", None, if s.readings.is_some() { "MD INCL and AZI" } else { "unknown" });
    element(text, "typeSurveyTool", None, "magnetic MWD");
    element(text, "calcAlgorithm", None, "minimum curvature");
    number(text, "md", "m", s.md_m, 3);
    number(text, "tvd", "m", tvd, 3);
    number(text, "incl", "dega", s.inclination_deg, 4);
    number(text, "azi", "dega", s.azimuth_deg, 4);
    if let Some(toolface) = s.gravity_toolface_deg {
        number(text, "gtf", "dega", toolface, 2);
    }
    number(text, "dispNs", "m", north, 3);
    number(text, "dispEw", "m", east, 3);
    number(text, "vertSect", "m", s.vertical_section_m, 3);
    number(text, "dls", "dega/m", s.dogleg_deg_30m / 30.0, 6);
    element(text, "sagCorUsed", None, if s.sag_deg == 0.0 { "false" } else { "true" });
    element(text, "axialMagInterferenceCorUsed", None, if s.corrected == "axial" { "true" } else { "false" });
    element(text, "MSACorUsed", None, if s.corrected == "multi-station" { "true" } else { "false" });
    number(text, "gravTotalFieldReference", "m/s2", s.reference.gravity_m_s2, 5);
    number(text, "magTotalFieldReference", "nT", 1e3 * s.reference.field_ut, 1);
    number(text, "magDipAngleReference", "dega", s.reference.dip_deg, 4);
    element(text, "magModelUsed", None, &run.provenance.model);
    element(text, "magModelValid", None, &run.provenance.date);
    element(text, "statusTrajStation", None, if s.doubted { "rejected" } else { "open" });
    if let Some([force, field]) = s.readings {
        text.push_str("<rawData>\n");
        // Gravity, down: the accelerometer reads the opposite.
        for (name, value) in [("gravAxialRaw", -force[2]), ("gravTran1Raw", -force[0]), ("gravTran2Raw", -force[1])] {
            number(text, name, "m/s2", value, 5);
        }
        for (name, value) in [("magAxialRaw", field[2]), ("magTran1Raw", field[0]), ("magTran2Raw", field[1])] {
            number(text, name, "nT", 1e3 * value, 1);
        }
        text.push_str("</rawData>\n");
    }
    if let Some([gravity, field, dip]) = s.off_reference {
        text.push_str("<valid>\n");
        number(text, "magTotalFieldCalc", "nT", 1e3 * (field + s.reference.field_ut), 1);
        number(text, "magDipAngleCalc", "dega", dip + s.reference.dip_deg, 4);
        number(text, "gravTotalFieldCalc", "m/s2", gravity + s.reference.gravity_m_s2, 5);
        text.push_str("</valid>\n");
    }
    text.push_str("<matrixCov>\n");
    let c = &s.covariance_m2;
    for (name, value) in [
        ("varianceNN", c[0][0]),
        ("varianceNE", c[0][1]),
        ("varianceNVert", c[0][2]),
        ("varianceEE", c[1][1]),
        ("varianceEVert", c[1][2]),
        ("varianceVertVert", c[2][2]),
    ] {
        number(text, name, "m2", value, 5);
    }
    text.push_str("</matrixCov>\n");
}
