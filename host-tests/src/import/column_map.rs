//! The map of an import: which columns in which units are which sensor. Printed, saved beside the trace as
//! TOML, and given back by `--map`, where each line that stands there wins over the guess.

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};

use super::delimited::Dialect;
use testbed::failure::Failure;

/// A map, whole or in part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnMap {
    /// Separator and decimal sign of text files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dialect: Option<Dialect>,
    /// Keys of the trace's header, such as `body_frame = "tool"`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub keys: BTreeMap<String, toml::Value>,
    /// The gyroscope.
    pub gyro: Part,
    /// The accelerometer.
    pub accel: Part,
    /// The magnetometer.
    #[serde(skip_serializing_if = "Part::is_empty")]
    pub mag: Part,
    /// The thermometer.
    #[serde(skip_serializing_if = "Part::is_empty")]
    pub temperature: Part,
    /// A reference attitude.
    #[serde(skip_serializing_if = "Part::is_empty")]
    pub reference: Part,
}

/// Where the readings of one sensor are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Part {
    /// File without its ending, topic or variable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Columns of the body's x, y and z axes; a minus before a name turns its sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<String>>,
    /// Unit of these columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Units in one count of these columns, for readings that are raw counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Column of the time stamps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Unit of the time stamps, `s`, `ms`, `us`, `ns`, or `clock` for times of day.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// Rate of rows without time stamps, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Added to every time stamp, seconds: for files whose clocks start apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_offset_s: Option<f64>,
}

impl Part {
    /// Returns true if the map says nothing of this sensor.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl ColumnMap {
    /// Reads a map.
    ///
    /// # Errors
    /// The file, and what in it cannot be used.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
        let text = std::fs::read_to_string(path).map_err(|error| Failure::unread(path, &error))?;
        toml::from_str(&text).map_err(|error| bad(error.to_string().trim_end().to_owned()))
    }

    /// The map as a file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        format!("# Columns, units and clocks of an import; change a line and give the file back by --map.\n{text}")
    }
}
