//! A run's settings from the text of their file. Numbers that cannot be are told by their names before anything is
//! computed with them.

use super::{
    sag::Sag,
    settings::{ReferenceSettings, RunSettings, one_line},
};
use crate::earth::{field_at_depth::within_half_a_turn, grid::Grid, reference_field::day};
use meerkat_mwd::config::SurveyConfig;
use testbed::failure::Failure;

/// Total field, nanotesla: it is within 22,000 and 67,000 at the surface (World Magnetic Model 2025), and rock and
/// depth change it by less than what is left to these bounds.
pub(crate) const FIELDS_NT: [f64; 2] = [15_000.0, 80_000.0];
/// Gravity, m/s^2: 9.78 to 9.83 at the surface, and 0.01 more at 12 km of depth.
const GRAVITIES_M_S2: [f64; 2] = [9.7, 9.9];
/// Furthest central meridian of a place, degrees: maps of a whole country, as Norway's in zone 33, reach 16.
const FURTHEST_DEG: f64 = 20.0;

impl RunSettings {
    /// Reads the text of a settings file.
    ///
    /// # Errors
    /// Description of what cannot be used, and why.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let settings: Self =
            toml::from_str(text).map_err(|error| Failure::BadInput(error.to_string().trim_end().replace('\n', " ")))?;
        one_line("well", &settings.well)?;
        checked(&settings).map_err(Failure::BadInput)?;
        Ok(settings)
    }
}

/// Refuses settings with a number that cannot be: the first one, with what it may be.
fn checked(run: &RunSettings) -> Result<(), String> {
    for (name, value, [least, most]) in [
        ("latitude_deg", run.latitude_deg, [-90.0, 90.0]),
        ("longitude_deg", run.longitude_deg, [-720.0, 720.0]),
        ("zero_height_m", Some(run.zero_height_m), [-12_000.0, 10_000.0]),
        ("surface_height_m", run.surface_height_m, [-12_000.0, 10_000.0]),
        ("rock_kg_m3", Some(run.rock_kg_m3), [0.0, 10_000.0]),
        ("vertical_section_deg", run.vertical_section_deg, [-360.0, 360.0]),
    ] {
        within(name, value, [least, most])?;
    }
    for value in run.start_m.into_iter().flatten() {
        within("start_m", Some(value), [-1e7, 1e7])?;
    }
    if let Some(date) = &run.date {
        is_day("date", date)?;
    }
    reference(&run.reference)?;
    errors(run)?;
    grid(run)?;
    run.sag.as_ref().map_or(Ok(()), sag)
}

fn within(name: &str, value: Option<f64>, [least, most]: [f64; 2]) -> Result<(), String> {
    match value {
        // A value that is no number is in no range.
        Some(value) if !(least..=most).contains(&value) => {
            Err(format!("{name} = {value}: must be from {least} to {most}"))
        }
        _ => Ok(()),
    }
}

fn is_day(name: &str, text: &str) -> Result<(), String> {
    day(text).map(|_| ()).map_err(|why| format!("{name} = {text:?}: {why}"))
}

fn reference(settings: &ReferenceSettings) -> Result<(), String> {
    let ReferenceSettings::Fixed { date, field_nt, dip_deg, declination_deg, gravity_m_s2, .. } = settings else {
        return Ok(());
    };
    is_day("reference.date", date)?;
    within("reference.field_nt", Some(*field_nt), FIELDS_NT)?;
    within("reference.dip_deg", Some(*dip_deg), [-90.0, 90.0])?;
    within("reference.declination_deg", Some(*declination_deg), [-180.0, 180.0])?;
    within("reference.gravity_m_s2", *gravity_m_s2, GRAVITIES_M_S2)
}

/// Every number of an error model is a size.
fn errors(run: &RunSettings) -> Result<(), String> {
    let sized = SurveyConfig { errors: run.errors, ..SurveyConfig::default() }.validate();
    sized.map_err(|error| format!("{}: must be {}", error.field.trim_start_matches("survey."), error.must_be))?;
    let analysis = toml::Table::try_from(run.multi_station).map_err(|error| error.to_string())?;
    for (name, value) in &analysis {
        if value.as_float().is_some_and(|value| !value.is_finite() || value <= 0.0) {
            return Err(format!("multi_station.{name} = {value}: must be finite and above 0"));
        }
    }
    Ok(())
}

fn grid(run: &RunSettings) -> Result<(), String> {
    let (name, meridian) = match run.grid {
        None => return Ok(()),
        Some(Grid::ConvergenceDeg(degrees)) => return within("grid.convergence_deg", Some(degrees), [-180.0, 180.0]),
        Some(Grid::UtmZone(zone)) => {
            within("grid.utm_zone", Some(f64::from(zone)), [1.0, 60.0])?;
            ("grid.utm_zone", 6.0 * f64::from(zone) - 183.0)
        }
        Some(Grid::CentralMeridianDeg(meridian)) => ("grid.central_meridian_deg", meridian),
        Some(Grid::Lambert { central_meridian_deg, parallels_deg: [first, second] }) => {
            for parallel in [first, second] {
                within("grid.lambert.parallels_deg", Some(parallel), [-89.0, 89.0])?;
            }
            ("grid.lambert.central_meridian_deg", central_meridian_deg)
        }
    };
    within(name, Some(meridian), [-360.0, 360.0])?;
    let Some(longitude) = run.longitude_deg.map(within_half_a_turn) else { return Ok(()) };
    let off = within_half_a_turn(longitude - meridian).abs();
    if off > FURTHEST_DEG {
        let zone = (libm::floor((longitude + 180.0) / 6.0) as i32).rem_euclid(60) + 1;
        return Err(format!(
            "{name}: its central meridian, {meridian} deg, is {off:.1} deg from longitude_deg; Universal Transverse Mercator has \
             zone {zone} there, and where a map does reach so far grid.convergence_deg states its convergence"
        ));
    }
    Ok(())
}

fn sag(sag: &Sag) -> Result<(), String> {
    match *sag {
        Sag::Stated { level_deg } => within("sag.level_deg", Some(level_deg), [-10.0, 10.0]),
        Sag::Beam { span_m, from_lower_support_m, outer_m, inner_m, mud_kg_m3, young_pa, steel_kg_m3 } => {
            // A beam between two supports says nothing of a tool beyond them.
            within("sag.span_m", Some(span_m), [0.1, 100.0])?;
            within("sag.from_lower_support_m", Some(from_lower_support_m), [0.0, span_m])?;
            within("sag.outer_m", Some(outer_m), [0.01, 1.0])?;
            within("sag.inner_m", Some(inner_m), [0.0, 0.99 * outer_m])?;
            within("sag.mud_kg_m3", Some(mud_kg_m3), [0.0, 4_000.0])?;
            within("sag.young_pa", Some(young_pa), [1e9, 1e12])?;
            within("sag.steel_kg_m3", Some(steel_kg_m3), [1_000.0, 20_000.0])
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const PLACE: &str = "latitude_deg = 57.8\nlongitude_deg = 362.1\ndate = \"2026-06-01\"\n";
    const FIXED: &str = "[reference]\nmodel = \"fixed\"\nname = \"IFR\"\ndate = \"2026-06-01\"\nfield_nt = 50800\n\
                         dip_deg = 71.3\ndeclination_deg = 1.5\n";
    /// A Lambert map whose central meridian is 1.9 deg from the place.
    const NEAR: &str = "grid = { lambert = { central_meridian_deg = 4.0, parallels_deg = [49.0, 77.0] } }";
    const BEAM: &str =
        "[sag]\nmodel = \"beam\"\nspan_m = 18.0\nfrom_lower_support_m = 14.0\nouter_m = 0.17\ninner_m = 0.08\n";

    #[test]
    fn a_number_that_cannot_be_is_named_with_its_bounds() {
        let text = |grid: &str| format!("{PLACE}{grid}\n{FIXED}{BEAM}");
        // Zone 33 is used for maps of all of Norway.
        for grid in
            ["", "grid = { utm_zone = 31 }", "grid = { utm_zone = 33 }", "grid = { convergence_deg = -0.8 }", NEAR]
        {
            RunSettings::parse(&text(grid)).unwrap();
        }
        for (grid, told) in [
            ("grid = { utm_zone = 91 }", "grid.utm_zone = 91: must be from 1 to 60"),
            ("grid = { utm_zone = 1 }", "has zone 31 there"),
            ("grid = { central_meridian_deg = 93.0 }", "90.9 deg from longitude_deg"),
            (
                "grid = { lambert = { central_meridian_deg = 100.0, parallels_deg = [49.0, 77.0] } }",
                "grid.lambert.central_meridian_deg: its central meridian, 100 deg, is 97.9 deg from longitude_deg",
            ),
            ("grid = { convergence_deg = nan }", "grid.convergence_deg = NaN"),
            ("start_m = [0.0, inf, 0.0]", "start_m = inf"),
        ] {
            let error = RunSettings::parse(&text(grid)).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
        for (from, to, told) in [
            ("57.8", "157.8", "latitude_deg = 157.8: must be from -90 to 90"),
            ("2026-06-01", "1/6/2026", "date = \"1/6/2026\": must be YYYY-MM-DD"),
            ("50800", "50.8", "reference.field_nt = 50.8: must be from 15000 to 80000"),
            ("71.3", "171.3", "reference.dip_deg = 171.3"),
            ("14.0", "19.0", "sag.from_lower_support_m = 19: must be from 0 to 18"),
            ("0.08", "0.27", "sag.inner_m = 0.27: must be from 0 to 0.1"),
        ] {
            let error = RunSettings::parse(&text("").replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
