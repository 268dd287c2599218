//! Comma-separated tables.

use super::push;
use crate::surveys::surveyed::SurveyedRun;

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

/// Everything of a station in one row; an empty cell where there is no number.
#[must_use]
pub fn full(run: &SurveyedRun) -> String {
    let north = if run.convergence_deg.is_some() { "grid" } else { "true" };
    let mut text = format!(
        "# well = {}\n# north = {north}\n# reference = {} of {} {}\n\
         md_m,inclination_deg,sigma_inclination_deg,magnetic_azimuth_deg,sigma_magnetic_azimuth_deg,azimuth_deg,\
         sigma_azimuth_deg,gravity_toolface_deg,measured_inclination_deg,measured_azimuth_deg,corrected,doubted,sag_deg,\
         axial_interference_ut,sigma_axial_interference_ut,axial_no_go,off_gravity_m_s2,off_field_ut,off_dip_deg,\
         reference_gravity_m_s2,reference_field_ut,reference_dip_deg,declination_deg,north_m,east_m,tvd_m,\
         dogleg_deg_30m,vertical_section_m,sigma_major_m,sigma_minor_m,ellipse_azimuth_deg,sigma_tvd_m\n",
        run.well, run.provenance.model, run.provenance.date, run.provenance.place
    );
    let cell = |x: Option<f64>, decimals: usize| x.map_or_else(String::new, |x| format!("{x:.decimals$}"));
    for s in &run.stations {
        let [north, east, tvd] = s.position_m;
        let [major, minor, azimuth] = s.ellipse;
        let cells = [
            format!("{:.3}", s.md_m),
            format!("{:.4}", s.inclination_deg),
            cell(s.sigma_inclination_deg, 4),
            format!("{:.4}", s.magnetic_azimuth_deg),
            cell(s.sigma_magnetic_azimuth_deg, 4),
            format!("{:.4}", s.azimuth_deg),
            cell(s.sigma_azimuth_deg, 4),
            cell(s.gravity_toolface_deg, 2),
            format!("{:.4}", s.measured_deg[0]),
            format!("{:.4}", s.measured_deg[1]),
            s.corrected.to_owned(),
            u8::from(s.doubted).to_string(),
            format!("{:.4}", s.sag_deg),
            cell(s.axial_interference_ut.map(|x| x[0]), 4),
            cell(s.axial_interference_ut.map(|x| x[1]), 4),
            s.axial_no_go.map_or_else(String::new, |no_go| u8::from(no_go).to_string()),
            cell(s.off_reference.map(|x| x[0]), 5),
            cell(s.off_reference.map(|x| x[1]), 4),
            cell(s.off_reference.map(|x| x[2]), 4),
            format!("{:.5}", s.reference.gravity_m_s2),
            format!("{:.4}", s.reference.field_ut),
            format!("{:.4}", s.reference.dip_deg),
            format!("{:.4}", s.reference.declination_deg),
            format!("{north:.3}"),
            format!("{east:.3}"),
            format!("{tvd:.3}"),
            format!("{:.4}", s.dogleg_deg_30m),
            format!("{:.3}", s.vertical_section_m),
            format!("{major:.3}"),
            format!("{minor:.3}"),
            format!("{azimuth:.2}"),
            format!("{:.3}", libm::sqrt(s.covariance_m2[2][2])),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
