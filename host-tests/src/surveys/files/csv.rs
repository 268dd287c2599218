//! Comma-separated tables.

use csv::WriterBuilder;

use super::push;
use crate::surveys::run::{SurveyedRun, SurveyedStation};

/// Depth, inclination and azimuth from the north of positions: what `welleng.survey.Survey(md, inc, azi)` takes, and
/// what nearly every planning program imports.
#[must_use]
pub fn plain(run: &SurveyedRun) -> String {
    let mut text = "md,inc,azi\n".to_owned();
    for s in &run.stations {
        push(&mut text, format_args!("{:.3},{:.4},{:.4}\n", s.md_m, s.inclination_deg, s.azimuth_deg));
    }
    text
}

/// A column of the full table: name and cell, which is empty where there is no number.
type Column = (&'static str, fn(&SurveyedStation) -> String);

const COLUMNS: [Column; 35] = [
    ("md_m", |s| format!("{:.3}", s.md_m)),
    ("inclination_deg", |s| format!("{:.4}", s.inclination_deg)),
    ("sigma_inclination_deg", |s| cell(s.sigma_inclination_deg, 4)),
    ("magnetic_azimuth_deg", |s| format!("{:.4}", s.magnetic_azimuth_deg)),
    ("sigma_magnetic_azimuth_deg", |s| cell(s.sigma_magnetic_azimuth_deg, 4)),
    ("azimuth_deg", |s| format!("{:.4}", s.azimuth_deg)),
    ("sigma_azimuth_deg", |s| cell(s.sigma_azimuth_deg, 4)),
    ("gravity_toolface_deg", |s| cell(s.gravity_toolface_deg, 2)),
    ("measured_inclination_deg", |s| format!("{:.4}", s.measured_deg[0])),
    ("measured_azimuth_deg", |s| format!("{:.4}", s.measured_deg[1])),
    ("corrected", |s| s.corrected.to_owned()),
    ("doubted", |s| u8::from(s.doubted).to_string()),
    ("sag_deg", |s| format!("{:.4}", s.sag_deg)),
    ("axial_interference_ut", |s| cell(s.axial_interference_ut.map(|x| x[0]), 4)),
    ("sigma_axial_interference_ut", |s| cell(s.axial_interference_ut.map(|x| x[1]), 4)),
    ("axial_no_go", |s| s.axial_no_go.map_or_else(String::new, |no_go| u8::from(no_go).to_string())),
    ("off_gravity_m_s2", |s| cell(s.off_reference.map(|x| x[0]), 5)),
    ("off_field_ut", |s| cell(s.off_reference.map(|x| x[1]), 4)),
    ("off_dip_deg", |s| cell(s.off_reference.map(|x| x[2]), 4)),
    ("reference_model", |s| s.reference_model.clone()),
    ("reference_date", |s| s.reference_date.clone()),
    ("reference_gravity_m_s2", |s| format!("{:.5}", s.reference.gravity_m_s2)),
    ("reference_field_ut", |s| format!("{:.4}", s.reference.field_ut)),
    ("reference_dip_deg", |s| format!("{:.4}", s.reference.dip_deg)),
    ("declination_deg", |s| format!("{:.4}", s.reference.declination_deg)),
    ("convergence_deg", |s| cell(s.convergence_deg, 4)),
    ("north_m", |s| format!("{:.3}", s.position_m[0])),
    ("east_m", |s| format!("{:.3}", s.position_m[1])),
    ("tvd_m", |s| format!("{:.3}", s.position_m[2])),
    ("dogleg_deg_30m", |s| format!("{:.4}", s.dogleg_deg_30m)),
    ("vertical_section_m", |s| format!("{:.3}", s.vertical_section_m)),
    ("sigma_major_m", |s| format!("{:.3}", s.ellipse[0])),
    ("sigma_minor_m", |s| format!("{:.3}", s.ellipse[1])),
    ("ellipse_azimuth_deg", |s| format!("{:.2}", s.ellipse[2])),
    ("sigma_tvd_m", |s| format!("{:.3}", libm::sqrt(s.covariance_m2[2][2]))),
];

fn cell(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(String::new, |x| format!("{x:.decimals$}"))
}

/// Everything of a station in one row.
#[must_use]
pub fn full(run: &SurveyedRun) -> String {
    let north = if run.convergence_deg.is_some() { "grid" } else { "true" };
    let provenance = &run.provenance;
    let mut text = format!(
        "# well = {}\n# north = {north}\n# reference = {} of {} {}\n# sag = {}\n",
        run.well,
        provenance.model,
        provenance.date,
        provenance.place,
        run.sag_told()
    );
    if let Some(first) = run.stations.first().filter(|first| first.md_m > 0.0) {
        text += &format!("# covariances count from = the first station, at {:.2} m\n", first.md_m);
    }
    let mut table = WriterBuilder::new().from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = table.write_record(COLUMNS.map(|(name, _)| name));
    for station in &run.stations {
        let _ = table.write_record(COLUMNS.map(|(_, cell)| cell(station)));
    }
    text += &String::from_utf8_lossy(&table.into_inner().unwrap_or_default());
    text
}
