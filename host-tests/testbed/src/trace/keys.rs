//! The header of a trace: `# key = value` lines above the header row.

use chrono::NaiveDate;
use meerkat_mwd::config::{FullScale, Motion};
use nalgebra::{Quaternion, UnitQuaternion};

use super::error::{Fault, quoted};
use crate::trace::motion;

/// Keys of the header; `None` if a key is absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keys {
    /// Earth frame of the reference attitude.
    pub earth_frame: EarthFrame,
    /// Meaning of the body axes.
    pub body_frame: BodyFrame,
    /// Magnetic declination, degrees east of true north.
    pub magnetic_declination_deg: Option<f64>,
    /// Local gravity, m/s^2.
    pub gravity_m_s2: Option<f64>,
    /// Total magnetic field, microtesla.
    pub magnetic_field_ut: Option<f64>,
    /// Magnetic dip, degrees below the horizontal.
    pub dip_deg: Option<f64>,
    /// Geodetic latitude, degrees north.
    pub latitude_deg: Option<f64>,
    /// Full scale of the gyro, rad/s.
    pub gyro_full_scale_rad_s: Option<f64>,
    /// Full scale of the accelerometer, m/s^2.
    pub accel_full_scale_m_s2: Option<f64>,
    /// Full scale of the magnetometer, microtesla.
    pub mag_full_scale_ut: Option<f64>,
    /// Delay of the gyro, seconds: how long before its sample's time a reading was true.
    pub gyro_delay_s: Option<f64>,
    /// Kind of motion: by hand or by a drill string.
    pub motion: Option<Motion>,
    /// True if the reference counts from true north, not from magnetic north.
    pub reference_north: bool,
    /// The gyro's true matrix P at the start, row-major; only a simulator knows it.
    pub true_gyro_p: Option<[f64; 9]>,
    /// Serial number of the probe, or another name of it.
    pub serial: Option<String>,
    /// Day of the recording.
    pub date: Option<NaiveDate>,
    /// Where the recording comes from.
    pub source: Option<String>,
    /// Licence of the recording.
    pub licence: Option<String>,
    /// Changes since it was recorded.
    pub changes: Option<String>,
}

/// Earth frame of the reference attitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EarthFrame {
    /// North, east, down.
    #[default]
    Ned,
    /// East, north, up.
    Enu,
    /// North, west, up.
    Nwu,
}

impl EarthFrame {
    /// Rotation from this frame to north, east, down.
    #[must_use]
    pub fn to_ned(self) -> UnitQuaternion<f64> {
        match self {
            Self::Ned => UnitQuaternion::identity(),
            // North and east change places and down is minus up: half a turn about the bisector of north and
            // east.
            Self::Enu => {
                let half = std::f64::consts::FRAC_1_SQRT_2;
                UnitQuaternion::new_unchecked(Quaternion::new(0.0, half, half, 0.0))
            }
            // Half a turn about north.
            Self::Nwu => UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0)),
        }
    }
}

/// Meaning of the body axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BodyFrame {
    /// Tool axes: z down-hole, x the highside at toolface 0.
    Tool,
    /// Sensor axes without a meaning: tool angles refer to the sensor's own z axis.
    #[default]
    Sensor,
}

/// Outcome of reading one `key = value`.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum KeyOutcome {
    Taken,
    Unknown,
}

/// A day of the form `2026-03-31`; years have four digits.
fn day(text: &str) -> Option<NaiveDate> {
    (text.len() == 10).then(|| NaiveDate::parse_from_str(text, "%Y-%m-%d").ok()).flatten()
}

impl Keys {
    /// Kind of motion: the key, else by the body frame, since whoever names tool axes has a tool.
    #[must_use]
    pub fn motion(&self) -> Motion {
        self.motion.unwrap_or(match self.body_frame {
            BodyFrame::Sensor => Motion::Hand,
            BodyFrame::Tool => Motion::DrillString,
        })
    }

    /// Sets one key; false for one that no trace has.
    ///
    /// # Errors
    /// A value that this key cannot have.
    pub fn assign(&mut self, key: &str, value: &str) -> Result<bool, Fault> {
        self.set(key, value).map(|outcome| outcome == KeyOutcome::Taken)
    }

    /// Sets one key.
    pub(super) fn set(&mut self, key: &str, value: &str) -> Result<KeyOutcome, Fault> {
        let bad = |must_be| Fault::BadKey { assignment: format!("{key} = {}", quoted(value)), must_be };
        let number = |ok: fn(f64) -> bool, must_be| match value.parse::<f64>() {
            Ok(x) if x.is_finite() && ok(x) => Ok(Some(x)),
            _ => Err(bad(must_be)),
        };
        let positive = || number(|x| x > 0.0, "a positive number");
        let quarter_turn = || number(|x| x.abs() <= 90.0, "a number from -90 to 90");
        match key {
            "earth_frame" => {
                self.earth_frame = match value.to_ascii_uppercase().as_str() {
                    "NED" => EarthFrame::Ned,
                    "ENU" => EarthFrame::Enu,
                    "NWU" => EarthFrame::Nwu,
                    _ => return Err(bad("NED, ENU or NWU")),
                };
            }
            "body_frame" => {
                self.body_frame = match value.to_ascii_lowercase().as_str() {
                    "tool" => BodyFrame::Tool,
                    "sensor" => BodyFrame::Sensor,
                    _ => return Err(bad("tool or sensor")),
                };
            }
            "motion" => self.motion = Some(motion::named(value).ok_or_else(|| bad("hand or drill_string"))?),
            "reference_north" => {
                self.reference_north = value.to_ascii_lowercase().parse().map_err(|_| bad("true or false"))?;
            }
            "magnetic_declination_deg" => {
                self.magnetic_declination_deg = number(|x| x.abs() <= 180.0, "a number from -180 to 180")?;
            }
            "gravity_m_s2" => self.gravity_m_s2 = positive()?,
            "magnetic_field_ut" => self.magnetic_field_ut = positive()?,
            "dip_deg" => self.dip_deg = quarter_turn()?,
            "latitude_deg" => self.latitude_deg = quarter_turn()?,
            "gyro_full_scale_rad_s" => self.gyro_full_scale_rad_s = positive()?,
            "accel_full_scale_m_s2" => self.accel_full_scale_m_s2 = positive()?,
            "mag_full_scale_ut" => self.mag_full_scale_ut = positive()?,
            "gyro_delay_s" => self.gyro_delay_s = number(|x| (0.0..=0.1).contains(&x), "a number from 0 to 0.1")?,
            "true_gyro_p" => {
                let read: Vec<f64> = value.split_whitespace().filter_map(|x| x.parse().ok()).collect();
                let nine = <[f64; 9]>::try_from(read).ok().filter(|p| p.iter().all(|x| x.is_finite()));
                self.true_gyro_p = Some(nine.ok_or_else(|| bad("nine numbers, row by row"))?);
            }
            "serial" => self.serial = Some(value.to_owned()),
            "date" => self.date = Some(day(value).ok_or_else(|| bad("a day as YYYY-MM-DD"))?),
            "source" => self.source = Some(value.to_owned()),
            "licence" => self.licence = Some(value.to_owned()),
            "changes" => self.changes = Some(value.to_owned()),
            _ => return Ok(KeyOutcome::Unknown),
        }
        Ok(KeyOutcome::Taken)
    }

    /// Keys that differ from their defaults, as header lines.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        // A line break in a text would begin a row.
        let text =
            |text: &Option<String>| text.as_ref().map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "));
        let number = |x: Option<f64>| x.map(|x| x.to_string());
        let earth = match self.earth_frame {
            EarthFrame::Ned => "NED",
            EarthFrame::Enu => "ENU",
            EarthFrame::Nwu => "NWU",
        };
        let body = match self.body_frame {
            BodyFrame::Tool => "tool",
            BodyFrame::Sensor => "sensor",
        };
        let all = [
            ("source", text(&self.source)),
            ("licence", text(&self.licence)),
            ("changes", text(&self.changes)),
            ("serial", text(&self.serial)),
            ("date", self.date.map(|date| date.to_string())),
            ("earth_frame", Some(earth.to_owned())),
            ("body_frame", Some(body.to_owned())),
            ("motion", self.motion.map(|motion| motion::name(motion).to_owned())),
            ("reference_north", self.reference_north.then(|| "true".to_owned())),
            ("magnetic_declination_deg", number(self.magnetic_declination_deg)),
            ("gravity_m_s2", number(self.gravity_m_s2)),
            ("magnetic_field_ut", number(self.magnetic_field_ut)),
            ("dip_deg", number(self.dip_deg)),
            ("latitude_deg", number(self.latitude_deg)),
            ("gyro_full_scale_rad_s", number(self.gyro_full_scale_rad_s)),
            ("accel_full_scale_m_s2", number(self.accel_full_scale_m_s2)),
            ("mag_full_scale_ut", number(self.mag_full_scale_ut)),
            ("gyro_delay_s", number(self.gyro_delay_s)),
            ("true_gyro_p", self.true_gyro_p.map(|p| p.map(|x| x.to_string()).join(" "))),
        ];
        all.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// The full scales as the pipeline takes them.
    #[must_use]
    pub fn full_scale(&self) -> FullScale {
        let single = |x: Option<f64>| x.map(|x| x as f32);
        FullScale {
            gyro_rad_s: single(self.gyro_full_scale_rad_s),
            accel_m_s2: single(self.accel_full_scale_m_s2),
            mag_ut: single(self.mag_full_scale_ut),
        }
    }
}
