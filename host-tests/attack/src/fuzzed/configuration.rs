//! A configuration that somebody has written.

use super::samples::finite;
use arbitrary::{Arbitrary, Unstructured};
use meerkat_mwd::{
    Config, Probe, Sample,
    config::{Earth, FullScale, Latency, SurveyConfig},
};
use serde::Deserialize;
use std::sync::LazyLock;
use toml::{Table, Value};

/// Samples that are flown with one.
const SAMPLES: u64 = 49;

/// A file.
#[derive(Arbitrary, Debug)]
enum File<'b> {
    /// Any text.
    Text(#[arbitrary(with = rest)] &'b [u8]),
    /// The defaults, with some fields changed. Of mutated text next to nothing is still a configuration.
    Changed(Vec<Change>),
}

/// A field by its place among all, and what becomes of it.
#[derive(Arbitrary, Debug)]
struct Change {
    place: u8,
    to: To,
}

/// Change to a field.
#[derive(Arbitrary, Debug)]
enum To {
    Number(f32),
    /// Its number times a power of two, of the exponent's sixteenths.
    Times(i8),
    Negative,
    Integer(i64),
    Switch(bool),
    Word(u8),
    Nothing,
    UnknownField,
}

fn rest<'b>(bytes: &mut Unstructured<'b>) -> arbitrary::Result<&'b [u8]> {
    bytes.bytes(bytes.len())
}

/// Words that name a motion or a search, and one that does not.
const WORDS: [&str; 5] = ["hand", "drill_string", "lm", "pso", "nothing"];

/// The defaults with every optional field, and the path of each number, switch and word in them.
static WHOLE: LazyLock<(Table, Vec<Vec<Step>>)> = LazyLock::new(|| {
    let defaults = Config::default();
    let whole = Config {
        full_scale: FullScale { gyro_rad_s: Some(35.0), accel_m_s2: Some(157.0), mag_ut: Some(800.0) },
        latency: Latency { gyro_s: Some(0.001), accel_s: Some(0.002), mag_s: Some(0.004) },
        earth: Earth {
            magnetic_field_ut: Some(49.0),
            dip_rad: Some(1.1),
            declination_rad: Some(0.05),
            latitude_rad: Some(0.8),
            ..defaults.earth
        },
        survey: SurveyConfig { grid_convergence_rad: Some(0.02), ..defaults.survey },
        ..defaults
    };
    let table = Table::try_from(whole).unwrap_or_default();
    let mut paths = Vec::new();
    leaves(&Value::Table(table.clone()), &mut Vec::new(), &mut paths);
    (table, paths)
});

/// A step down to a field.
#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Index(usize),
}

fn leaves(value: &Value, path: &mut Vec<Step>, paths: &mut Vec<Vec<Step>>) {
    let below: Vec<(Step, &Value)> = match value {
        Value::Table(table) => table.iter().map(|(key, value)| (Step::Key(key.clone()), value)).collect(),
        Value::Array(values) => values.iter().enumerate().map(|(k, value)| (Step::Index(k), value)).collect(),
        _ => return paths.push(path.clone()),
    };
    for (step, value) in below {
        path.push(step);
        leaves(value, path, paths);
        path.pop();
    }
}

/// Number of fields that can be changed.
#[must_use]
pub fn places() -> usize {
    WHOLE.1.len()
}

impl Change {
    fn apply(&self, table: &mut Table) {
        let paths = &WHOLE.1;
        let Some(path) = paths.get(usize::from(self.place) % paths.len().max(1)) else { return };
        let Some((Step::Key(first), path)) = path.split_first() else { return };
        if path.is_empty() && matches!(self.to, To::Nothing) {
            table.remove(first);
            return;
        }
        let Some(mut at) = table.get_mut(first) else { return };
        for (k, step) in path.iter().enumerate() {
            let is_last = k + 1 == path.len();
            at = match (at, step) {
                (Value::Table(table), Step::Key(key)) if is_last && matches!(self.to, To::Nothing) => {
                    table.remove(key);
                    return;
                }
                (Value::Table(table), Step::Key(_)) if is_last && matches!(self.to, To::UnknownField) => {
                    table.insert("unknown".to_owned(), Value::Boolean(true));
                    return;
                }
                (Value::Array(values), Step::Index(k)) if is_last && matches!(self.to, To::Nothing) => {
                    if *k < values.len() {
                        values.remove(*k);
                    }
                    return;
                }
                (Value::Table(table), Step::Key(key)) => match table.get_mut(key) {
                    Some(below) => below,
                    None => return,
                },
                (Value::Array(values), Step::Index(k)) => match values.get_mut(*k) {
                    Some(below) => below,
                    None => return,
                },
                _ => return,
            };
        }
        *at = self.to.of(at);
    }
}

impl To {
    fn of(&self, before: &Value) -> Value {
        let times = |factor: f32| match before {
            Value::Float(number) => Value::Float(number * f64::from(factor)),
            Value::Integer(number) => Value::Integer((*number as f32 * factor) as i64),
            other => other.clone(),
        };
        match *self {
            Self::Number(number) => Value::Float(number.into()),
            Self::Times(exponent) => times(libm::exp2f(f32::from(exponent) / 16.0)),
            Self::Negative => times(-1.0),
            Self::Integer(number) => Value::Integer(number),
            Self::Switch(is_on) => Value::Boolean(is_on),
            Self::Word(which) => Value::String(WORDS[usize::from(which) % WORDS.len()].to_owned()),
            Self::Nothing | Self::UnknownField => before.clone(),
        }
    }
}

/// A configuration. One that is accepted can be flown with, and all that is said is finite.
///
/// # Panics
/// It cannot, or is not.
pub fn configuration(bytes: &[u8]) {
    let config = match File::arbitrary(&mut Unstructured::new(bytes)) {
        Ok(File::Text(text)) => toml::from_str::<Config>(&String::from_utf8_lossy(text)),
        Ok(File::Changed(changes)) => {
            let mut table = WHOLE.0.clone();
            changes.iter().for_each(|change| change.apply(&mut table));
            Config::deserialize(Value::Table(table))
        }
        Err(_) => return,
    };
    let Ok(config) = config else { return };
    let mut probe = Box::new(Probe::new());
    assert_eq!(config.validate().is_ok(), probe.configure(&config).is_ok());
    for k in 1..=SAMPLES {
        let t_us = k * u64::from(config.sample_period_us);
        let sample = Sample { t_us, accel_m_s2: [0.1, 0.2, -9.8], mag_ut: [20.0, 3.0, 40.0], ..Sample::default() };
        if let Some(output) = probe.push(&sample) {
            finite(&output);
        }
        probe.poll(probe.poll_budget());
    }
}
