//! The `--surveys` file.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use meerkat_mwd::survey::{Checked, Grade, Survey, SurveyKind, SurveyReport, ToolfaceKind, Uncertain};

use crate::report::attitude_csv::write_cell;
use testbed::{console, failure::Failure, trace::seconds};

const HEADER: &str = "t_start_s,t_end_s,kind,inclination_deg,sigma_inclination_deg,magnetic_azimuth_deg,sigma_magnetic_azimuth_deg,\
                      true_azimuth_deg,sigma_true_azimuth_deg,grid_azimuth_deg,sigma_grid_azimuth_deg,gravity_toolface_deg,\
                      sigma_gravity_toolface_deg,magnetic_toolface_deg,sigma_magnetic_toolface_deg,toolface,gravity_m_s2,\
                      sigma_gravity_m_s2,field_ut,sigma_field_ut,dip_deg,sigma_dip_deg,temperature_c,rotating,grade,reason";

/// Writes one row a survey: span, angles, totals and their 1-sigma, which toolface applies, grade, and the
/// check that decided it; empty cells where there is no number.
///
/// # Errors
/// When the file cannot be written.
pub fn write_surveys_csv(surveys: &[SurveyReport], path: &Path) -> Result<(), Failure> {
    let write = || -> io::Result<()> {
        let mut file = BufWriter::new(console::create(path)?);
        write_rows(surveys, &mut file)?;
        file.flush()
    };
    write().map_err(|error| Failure::output(path, &error))
}

/// The same as text.
#[must_use]
pub fn surveys_csv(surveys: &[SurveyReport]) -> String {
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = write_rows(surveys, &mut text);
    String::from_utf8_lossy(&text).into_owned()
}

fn write_rows(surveys: &[SurveyReport], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")?;
    for SurveyReport { survey, quality, .. } in surveys {
        let Survey { t_start_us, t_end_us, .. } = *survey;
        write!(out, "{},{},{}", seconds(t_start_us), seconds(t_end_us), kind(survey.kind))?;
        let angles = [
            Some(survey.inclination_rad),
            survey.magnetic_azimuth_rad,
            survey.true_azimuth_rad,
            survey.grid_azimuth_rad,
            survey.gravity_toolface_rad,
            survey.magnetic_toolface_rad,
        ];
        for angle in angles {
            write_uncertain(out, angle.map(degrees))?;
        }
        write!(out, ",{}", if survey.toolface_kind == ToolfaceKind::Gravity { "gravity" } else { "magnetic" })?;
        for total in [survey.gravity_m_s2, survey.field_ut, survey.dip_rad.map(degrees)] {
            write_uncertain(out, total)?;
        }
        write_cell(out, survey.temperature_c.unwrap_or(f32::NAN))?;
        let reason = if quality.grade == Grade::Good { "" } else { reason(quality.reason.checked) };
        writeln!(out, ",{},{},{reason}", u8::from(survey.rotating), grade(quality.grade))?;
    }
    Ok(())
}

fn write_uncertain(out: &mut impl Write, x: Option<Uncertain>) -> io::Result<()> {
    let Uncertain { value, sigma } = x.unwrap_or(Uncertain { value: f32::NAN, sigma: f32::NAN });
    write_cell(out, value)?;
    write_cell(out, sigma)
}

fn degrees(x: Uncertain) -> Uncertain {
    Uncertain { value: x.value.to_degrees(), sigma: x.sigma.to_degrees() }
}

fn kind(kind: SurveyKind) -> &'static str {
    match kind {
        SurveyKind::Stationary => "stationary",
        SurveyKind::Rotating => "rotating",
        _ => "continuous",
    }
}

pub(crate) fn grade(grade: Grade) -> &'static str {
    match grade {
        Grade::Good => "good",
        Grade::Doubtful => "doubtful",
        _ => "bad",
    }
}

pub(crate) fn reason(checked: Checked) -> &'static str {
    match checked {
        Checked::Gravity => "gravity",
        Checked::Field => "field",
        Checked::Mounting => "mounting",
        _ => "dip",
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use testbed::{
        flight::{configuration::of_trace, started, surveys},
        simulate::{Hole, Scenario, simulate},
    };

    #[test]
    fn a_rest_and_a_drilled_minute_give_rows_whose_angles_are_the_holes() {
        let hole = Hole { inclination_deg: 45.0, azimuth_deg: 60.0, ..Hole::default() };
        let (trace, _) = simulate(&Scenario { duration_s: 90.0, rest_s: 30.0, hole, ..Scenario::default() }, 3);
        let taken = surveys(started(&of_trace(&trace), None, None).unwrap(), &trace).unwrap();
        let mut text = Vec::new();
        write_rows(&taken, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        let of = |kind: &str| rows.iter().filter(|row| row[2] == kind).collect::<Vec<_>>();
        let (stationary, rotating) = (of("stationary"), of("rotating"));
        assert!(!stationary.is_empty() && !rotating.is_empty(), "{text}");
        for row in stationary {
            let (inclination, azimuth): (f64, f64) = (row[3].parse().unwrap(), row[5].parse().unwrap());
            assert!((inclination - 45.0).abs() < 0.2 && (azimuth - 60.0).abs() < 1.0, "{row:?}");
            assert!(row[7].is_empty() && row[9].is_empty(), "no declination is known: {row:?}");
        }
        for row in rotating {
            assert!(row[11].is_empty() && row[13].is_empty() && row[23] == "1", "no toolface while rotating: {row:?}");
        }
    }
}
