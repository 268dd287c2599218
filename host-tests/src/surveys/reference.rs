//! Reference gravity and field at a station, with what it came from.

use std::fs;

use serde::Serialize;
use world_magnetic_model::time::Date;

use super::{
    cells,
    settings::{ReferenceSettings, RunSettings, one_line},
    settings_file::FIELDS_NT,
};
use crate::earth::{
    coefficient_file::CoefficientFile,
    field_at_depth::{field_at, within_half_a_turn},
    gravity_at_depth::gravity_m_s2,
    reference_field::day,
};
use testbed::failure::Failure;

/// Days between the model's date and the survey's from which on a warning is given: the declination drifts by up to
/// a quarter of a degree a year, so a month is a twentieth of the reference's own error (DEC, 0.36 deg).
const OLD_DAYS: i64 = 30;
/// First and last day of the World Magnetic Model of 2025.
const WMM2025: [&str; 2] = ["2025-01-01", "2029-12-31"];

/// Reference at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReferenceAt {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f64,
    /// Total field, microtesla.
    pub field_ut: f64,
    /// Dip below the horizon, degrees.
    pub dip_deg: f64,
    /// Declination east of true north, degrees.
    pub declination_deg: f64,
}

/// Origin of a reference, kept with every station.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Provenance {
    /// Name of the model or of the file.
    pub model: String,
    /// Day that it was evaluated for.
    pub date: String,
    /// Where: latitude and longitude, as text; empty for stated values.
    pub place: String,
}

/// Reference of a run.
#[derive(Debug)]
pub struct Reference {
    source: Source,
    provenance: Provenance,
    settings: RunSettings,
    /// Doubts about the reference, a sentence each.
    pub warnings: Vec<String>,
}

#[derive(Debug)]
enum Source {
    Wmm(Date),
    Coefficients(CoefficientFile, Date),
    Fixed {
        field: [f64; 3],
        gravity_m_s2: Option<f64>,
    },
    /// True vertical depth, then field, dip and declination.
    Table(Vec<[f64; 4]>),
}

impl Reference {
    /// The reference that a run's settings ask for.
    ///
    /// # Errors
    /// Place or date is missing or not in the model, or a file cannot be used.
    pub fn of(settings: &RunSettings) -> Result<Self, Failure> {
        let survey_day = settings.date.as_deref().map(|text| parsed(text, "date")).transpose()?;
        let place = place(settings);
        let (source, model, date) = match &settings.reference {
            ReferenceSettings::Wmm => {
                let date = evaluated_on(survey_day, place.as_ref())?;
                let [first, last] = [parsed(WMM2025[0], "")?, parsed(WMM2025[1], "")?];
                let model = if date >= first && date <= last { "WMM2025" } else { "WMM2020" };
                (Source::Wmm(date), model.to_owned(), date.to_string())
            }
            ReferenceSettings::Coefficients { path } => {
                let date = evaluated_on(survey_day, place.as_ref())?;
                let model = CoefficientFile::read(path)?;
                let name = model.name.clone();
                (Source::Coefficients(model, date), name, date.to_string())
            }
            ReferenceSettings::Fixed { name, date, field_nt, dip_deg, declination_deg, gravity_m_s2 } => {
                parsed(date, "reference.date")?;
                let field = [field_nt * 1e-3, *dip_deg, *declination_deg];
                (Source::Fixed { field, gravity_m_s2: *gravity_m_s2 }, name.clone(), date.clone())
            }
            ReferenceSettings::File { path } => {
                let bad = |why: String| Failure::BadInput(format!("{}: {why}", path.display()));
                let text = fs::read_to_string(path).map_err(|error| Failure::unread(path, &error))?;
                let (rows, name, date) = table(&text).map_err(bad)?;
                (Source::Table(rows), name, date)
            }
        };
        one_line("name of the reference", &model)?;
        let mut warnings = Vec::new();
        let model_day = parsed(&date, "date")?;
        match survey_day {
            None => warnings.push(format!("the surveys have no date; {model} is of {date}")),
            Some(day) => {
                let days = (day - model_day).whole_days().abs();
                if days > OLD_DAYS {
                    warnings.push(format!("{model} is of {date}, {days} days from the surveys of {day}"));
                }
            }
        }
        if place.is_none() && !matches!(source, Source::Fixed { gravity_m_s2: Some(_), .. }) {
            return Err(missing("latitude_deg and longitude_deg, or reference.gravity_m_s2"));
        }
        let provenance = Provenance { model, date, place: place.unwrap_or_default() };
        Ok(Self { source, provenance, settings: settings.clone(), warnings })
    }

    /// Origin of this reference.
    #[must_use]
    pub const fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Convergence of the run's grid, degrees; `None` without a grid.
    ///
    /// # Errors
    /// A map's grid without a place.
    pub fn convergence_deg(&self) -> Result<Option<f64>, Failure> {
        use crate::earth::grid::Grid;
        match (self.settings.grid, self.settings.latitude_deg, self.settings.longitude_deg) {
            (None, ..) => Ok(None),
            (Some(Grid::ConvergenceDeg(degrees)), ..) => Ok(Some(degrees)),
            (Some(grid), Some(latitude), Some(longitude)) => Ok(Some(grid.convergence_deg(latitude, longitude))),
            _ => Err(missing("latitude_deg and longitude_deg, for the grid")),
        }
    }

    /// Reference at a true vertical depth, metres below depth zero.
    ///
    /// # Errors
    /// A depth outside the model or the table.
    pub fn at(&self, tvd_m: f64) -> Result<ReferenceAt, Failure> {
        let run = &self.settings;
        let height = run.zero_height_m - tvd_m;
        let surface = run.surface_height_m.unwrap_or(run.zero_height_m);
        let normal = run.latitude_deg.map(|latitude| gravity_m_s2(latitude, height, surface, run.rock_kg_m3));
        let ([field_ut, dip_deg, declination_deg], gravity) = match &self.source {
            Source::Wmm(date) => {
                let [latitude, longitude] = [run.latitude_deg, run.longitude_deg].map(Option::unwrap_or_default);
                let field = field_at(latitude, longitude, height, *date)?;
                let degrees = |rad: f32| f64::from(rad).to_degrees();
                ([f64::from(field.total_ut), degrees(field.dip_rad), degrees(field.declination_rad)], normal)
            }
            Source::Coefficients(model, date) => {
                let [latitude, longitude] = [run.latitude_deg, run.longitude_deg].map(Option::unwrap_or_default);
                let field = model.field_at(latitude, longitude, height, *date)?;
                ([field.total_nt() * 1e-3, field.dip_deg(), field.declination_deg()], normal)
            }
            Source::Fixed { field, gravity_m_s2 } => (*field, gravity_m_s2.or(normal)),
            Source::Table(rows) => (interpolated(rows, tvd_m).map_err(|why| self.told(&why))?, normal),
        };
        let gravity_m_s2 = gravity.ok_or_else(|| missing("latitude_deg, for gravity"))?;
        Ok(ReferenceAt { gravity_m_s2, field_ut, dip_deg, declination_deg })
    }

    fn told(&self, why: &str) -> Failure {
        Failure::BadInput(format!("reference table {}: {why}", self.provenance.model))
    }
}

fn missing(what: &str) -> Failure {
    Failure::BadInput(format!("the run's settings, --run RUN.toml, lack {what}"))
}

/// Day for which a global model is evaluated: it takes a place and a date.
fn evaluated_on(survey_day: Option<Date>, place: Option<&String>) -> Result<Date, Failure> {
    let date = survey_day.ok_or_else(|| missing("date = \"YYYY-MM-DD\""))?;
    if place.is_none() {
        return Err(missing("latitude_deg and longitude_deg"));
    }
    Ok(date)
}

fn parsed(text: &str, field: &str) -> Result<Date, Failure> {
    day(text).map_err(|why| Failure::BadInput(format!("{field}: {why}")))
}

fn place(settings: &RunSettings) -> Option<String> {
    let (latitude, longitude) = (settings.latitude_deg?, within_half_a_turn(settings.longitude_deg?));
    // To a millionth of a degree, 0.1 m: no turns' remainders, as 2.1000000000000227.
    let [latitude, longitude] = [latitude, longitude].map(|degrees| libm::round(1e6 * degrees) / 1e6);
    Some(format!("{latitude} N {longitude} E"))
}

/// Rows of a reference table, its name and its date.
fn table(text: &str) -> Result<(Vec<[f64; 4]>, String, String), String> {
    let text = cells::unmarked(text);
    let key = |key: &str| cells::stated(text, key).map(str::to_owned);
    let name = key("name").ok_or("lacks a line # name = ..")?;
    let date = key("date").ok_or("lacks a line # date = YYYY-MM-DD")?;
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let column =
        |name: &str| header.iter().position(|column| column == name).ok_or_else(|| format!("lacks the column {name}"));
    let read = ["tvd_m", "field_nt", "dip_deg", "declination_deg"];
    let [depth, field, dip, declination] = read;
    let columns = [column(depth)?, column(field)?, column(dip)?, column(declination)?];
    let written: Vec<String> = header.iter().map(str::to_owned).collect();
    cells::each_once(&header, &written, read)?;
    let mut rows: Vec<[f64; 4]> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| cells::unread(&error))?;
        let line = cells::line(&record);
        let mut row = [0.0; 4];
        for (value, &column) in row.iter_mut().zip(&columns) {
            *value = cells::number(&header, &record, column)?;
        }
        let [least, most] = FIELDS_NT;
        if !(least..=most).contains(&row[1]) {
            return Err(format!("line {line}: field_nt = {}: must be from {least} to {most} nanotesla", row[1]));
        }
        for (name, value, most) in [("dip_deg", row[2], 90.0), ("declination_deg", row[3], 180.0)] {
            if value.abs() > most {
                return Err(format!("line {line}: {name} = {value}: must be from -{most} to {most}"));
            }
        }
        row[1] *= 1e-3;
        if rows.last().is_some_and(|last| row[0] <= last[0]) {
            return Err(format!("line {line}: tvd_m does not increase: sort the rows by it, each depth once"));
        }
        rows.push(row);
    }
    if rows.is_empty() { Err("has no rows".to_owned()) } else { Ok((rows, name, date)) }
}

/// Field, dip and declination between a table's rows; a table of one row holds everywhere.
fn interpolated(rows: &[[f64; 4]], tvd_m: f64) -> Result<[f64; 3], String> {
    if let [[_, field, dip, declination]] = rows {
        return Ok([*field, *dip, *declination]);
    }
    let inside = rows.windows(2).find_map(|pair| match pair {
        [a, b] if tvd_m >= a[0] && tvd_m <= b[0] => {
            let share = (tvd_m - a[0]) / (b[0] - a[0]);
            Some([1, 2, 3].map(|k: usize| a[k] + share * (b[k] - a[k])))
        }
        _ => None,
    });
    inside.ok_or_else(|| {
        let [first, last] = [rows.first(), rows.last()].map(|row| row.map_or(0.0, |row| row[0]));
        format!(
            "reaches from {first:.1} to {last:.1} m of true vertical depth, and a station is at {tvd_m:.1} m: it needs a row beyond"
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn run(text: &str) -> RunSettings {
        RunSettings::parse(text).unwrap()
    }

    const PLACE: &str = "latitude_deg = 60.0\nlongitude_deg = 358.0\ndate = \"2026-06-01\"\n";

    #[test]
    fn the_model_is_taken_at_depth_and_told() {
        let reference = Reference::of(&run(PLACE)).unwrap();
        let (top, bottom) = (reference.at(0.0).unwrap(), reference.at(5_000.0).unwrap());
        assert!((bottom.field_ut - top.field_ut - 0.115).abs() < 0.02, "{top:?} {bottom:?}");
        // 0.85e-6 1/s^2 over 5 km.
        assert!((bottom.gravity_m_s2 - top.gravity_m_s2 - 0.004_23).abs() < 1e-4);
        let Provenance { model, date, place } = reference.provenance().clone();
        assert_eq!((model.as_str(), date.as_str(), place.as_str()), ("WMM2025", "2026-06-01", "60 N -2 E"));
        assert!(reference.warnings.is_empty());
        let old = Reference::of(&run(&PLACE.replace("2026", "2023"))).unwrap();
        assert_eq!(old.provenance().model, "WMM2020");
    }

    #[test]
    fn coefficients_are_taken_at_depth_and_told() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/earth/coefficient_file/WMM2025.COF");
        let from_file = format!("{PLACE}[reference]\nmodel = \"coefficients\"\npath = '{path}'\n");
        let (file, wmm) = (Reference::of(&run(&from_file)).unwrap(), Reference::of(&run(PLACE)).unwrap());
        assert_eq!(file.provenance().model, "WMM-2025");
        let (a, b) = (file.at(6_000.0).unwrap(), wmm.at(6_000.0).unwrap());
        assert!((a.field_ut - b.field_ut).abs() < 3e-4 && (a.dip_deg - b.dip_deg).abs() < 5e-4, "{a:?} {b:?}");
        assert!((a.declination_deg - b.declination_deg).abs() < 1e-3);
        assert!(Reference::of(&run(&from_file.replace("2026", "2035"))).unwrap().at(0.0).is_err());
        assert!(Reference::of(&run(&from_file.replace("latitude_deg = 60.0\n", ""))).is_err());
    }

    #[test]
    fn stated_values_of_another_date_are_taken_with_a_warning() {
        let fixed = "[reference]\nmodel = \"fixed\"\nname = \"IFR1\"\ndate = \"2026-01-01\"\nfield_nt = 50100\n\
                     dip_deg = 72.1\ndeclination_deg = -0.5\n";
        let reference = Reference::of(&run(&format!("{PLACE}{fixed}"))).unwrap();
        assert!(reference.warnings.iter().any(|warning| warning.contains("151 days")), "{:?}", reference.warnings);
        assert!((reference.at(3_000.0).unwrap().field_ut - 50.1).abs() < 1e-12);
        // Without a place there is no gravity.
        assert!(Reference::of(&run(fixed)).is_err());
    }

    #[test]
    fn a_table_is_interpolated_and_not_continued() {
        let text = "# name = IFR2 block 12\n# date = 2026-05-20\ntvd_m,field_nt,dip_deg,declination_deg\n\
                    0,50000,72,-1\n1000,50020,72.1,-0.9\n";
        let (rows, name, date) = table(text).unwrap();
        assert_eq!((name.as_str(), date.as_str()), ("IFR2 block 12", "2026-05-20"));
        let [field, dip, declination] = interpolated(&rows, 250.0).unwrap();
        assert!((field - 50.005).abs() < 1e-9 && (dip - 72.025).abs() < 1e-9 && (declination + 0.975).abs() < 1e-9);
        assert!(interpolated(&rows, 1_000.1).is_err());
        for bad in ["", "tvd_m,field_nt\n", &text.replace("1000,", "0,"), &text.replace("72.1", "x")] {
            assert!(table(bad).is_err(), "{bad}");
        }
    }
}
