//! Settings of a run: place, date, reference, grid, corrections. A TOML file.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use meerkat_mwd::{config::SurveyErrors, survey::multi_station::MultiStationSettings};
use serde::{Deserialize, Serialize};

use super::{sag::Sag, tool_codes::FieldClass};
use crate::earth::{gravity_at_depth::ROCK_KG_M3, grid::Grid};
use testbed::failure::Failure;

/// Settings of a run's surveys. Depths count from a zero (rotary table) at `zero_height_m`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunSettings {
    /// Name of the well.
    pub well: String,
    /// Geodetic latitude, degrees north.
    pub latitude_deg: Option<f64>,
    /// Longitude, degrees east, any convention: 358 is -2.
    pub longitude_deg: Option<f64>,
    /// Height of depth zero above the WGS 84 ellipsoid, metres.
    pub zero_height_m: f64,
    /// Height of the ground, or of the sea, above the ellipsoid, metres; where absent, depth zero's.
    pub surface_height_m: Option<f64>,
    /// Density between the surface and the tool, kg/m^3.
    pub rock_kg_m3: f64,
    /// Day of the surveys, YYYY-MM-DD.
    pub date: Option<String>,
    /// Reference of gravity and field.
    pub reference: ReferenceSettings,
    /// Map's grid; where absent, azimuths count from true north.
    pub grid: Option<Grid>,
    /// Correction of azimuths.
    pub correction: Correction,
    /// Sag of the bottom-hole assembly; where absent, none is corrected.
    pub sag: Option<Sag>,
    /// Azimuth of the vertical section, degrees from the north of positions; where absent, that of the last station.
    pub vertical_section_deg: Option<f64>,
    /// Position of the first station: north, east, true vertical depth, metres; where absent, straight below depth zero
    /// at its measured depth.
    pub start_m: Option<[f64; 3]>,
    /// Errors of sensors and reference. Those of the sensors scale the tool code's terms, too.
    pub errors: SurveyErrors,
    /// Class of the reference field, which chooses the tool code; where absent, in-field referencing (`ifr1`) for a
    /// file by depth and low resolution (`lrgm`) for all others.
    pub field_class: Option<FieldClass>,
    /// Factors of the tool code's terms, by their names.
    pub term_factors: BTreeMap<String, f64>,
    /// Multi-station analysis.
    pub multi_station: MultiStationSettings,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self {
            well: "well".to_owned(),
            latitude_deg: None,
            longitude_deg: None,
            zero_height_m: 0.0,
            surface_height_m: None,
            rock_kg_m3: ROCK_KG_M3,
            date: None,
            reference: ReferenceSettings::default(),
            grid: None,
            correction: Correction::default(),
            sag: None,
            vertical_section_deg: None,
            start_m: None,
            errors: SurveyErrors::default(),
            field_class: None,
            term_factors: BTreeMap::new(),
            multi_station: MultiStationSettings::default(),
        }
    }
}

/// Where the reference comes from.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(tag = "model", rename_all = "snake_case", deny_unknown_fields)]
pub enum ReferenceSettings {
    /// The World Magnetic Model at each station's depth, on the run's date.
    #[default]
    Wmm,
    /// A model of spherical harmonics at each station's depth, on the run's date, from a file of coefficients such as
    /// `WMMHR.COF`.
    Coefficients {
        /// The file; a relative path counts from the folder of the settings' file.
        path: PathBuf,
    },
    /// Stated values, the same at every station.
    Fixed {
        /// Name of their source.
        name: String,
        /// Day for which they hold, YYYY-MM-DD.
        date: String,
        /// Total field, nanotesla.
        field_nt: f64,
        /// Dip below the horizon, degrees.
        dip_deg: f64,
        /// Declination east of true north, degrees.
        declination_deg: f64,
        /// Gravity, m/s^2; where absent, normal gravity at each station's depth.
        gravity_m_s2: Option<f64>,
    },
    /// A table by true vertical depth, as in-field referencing gives: columns `tvd_m,field_nt,dip_deg,declination_deg`,
    /// lines `# name = ..` and `# date = YYYY-MM-DD` before them.
    File {
        /// The table; a relative path counts from the folder of the settings' file.
        path: PathBuf,
    },
}

/// Correction of azimuths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Not at all
    None,
    /// By the multi-station analysis, where it is accepted
    #[default]
    MultiStation,
    /// By the short-collar correction, outside of its no-go zone
    Axial,
}

impl RunSettings {
    /// Class of the reference field.
    #[must_use]
    pub fn field_class(&self) -> FieldClass {
        self.field_class.unwrap_or(match self.reference {
            ReferenceSettings::File { .. } => FieldClass::Ifr1,
            _ => FieldClass::Lrgm,
        })
    }

    /// The settings of a file in `folder`, from which paths in it count.
    #[must_use]
    pub fn of_folder(mut self, folder: &Path) -> Self {
        if let ReferenceSettings::Coefficients { path } | ReferenceSettings::File { path } = &mut self.reference {
            *path = folder.join(&*path);
        }
        self
    }
}

/// Refuses a name that would break the lines of a file, or that XML cannot hold.
///
/// # Errors
/// The text has a line break, a tab or another control character.
pub(super) fn one_line(field: &str, text: &str) -> Result<(), Failure> {
    if text.chars().any(char::is_control) {
        return Err(Failure::BadInput(format!("{field}: {text:?} has a line break or another control character")));
    }
    Ok(())
}
