//! PX4's ULog: the topics of raw sensors as tables.

use std::{collections::BTreeMap, path::Path};

use px4_ulog::full_parser::{Completeness, ParsedData, SomeVec, read_file};

use super::table::{Column, Contents, Table};

/// First bytes of such a file.
pub const MAGIC: &[u8] = b"ULog\x01\x12\x35";

/// Topics with readings of sensors, those in the vehicle's axes first.
const TOPICS: [&str; 7] = [
    "sensor_combined",
    "vehicle_magnetometer",
    "vehicle_angular_velocity",
    "vehicle_acceleration",
    "sensor_gyro",
    "sensor_accel",
    "sensor_mag",
];

/// Reads the topics of sensors.
///
/// # Errors
/// Description of what is wrong with the file.
pub fn read(path: &Path) -> Result<Contents, String> {
    let data = read_file(&path.to_string_lossy()).map_err(|error| format!("the ULog cannot be read: {error}"))?;
    let tables: Vec<Table> = TOPICS.iter().flat_map(|topic| tables(&data, topic)).collect();
    if tables.is_empty() {
        let mut there: Vec<&str> = data.messages.keys().map(String::as_str).collect();
        there.sort_unstable();
        return Err(format!("the ULog has no topic of a sensor ({}); it has {}", TOPICS.join(", "), there.join(", ")));
    }
    let lost = match &data.completeness {
        Completeness::Complete => None,
        Completeness::Truncated => Some("the ULog is cut off: what stands before is read".to_owned()),
        Completeness::MalformedRecord(why) => Some(format!("the ULog is damaged: what stands before is read ({why})")),
    };
    Ok(Contents { lost: lost.into_iter().collect(), ..Contents::whole(tables) })
}

fn tables(data: &ParsedData, topic: &str) -> Vec<Table> {
    let instances = data.messages.get(topic).into_iter().flatten();
    let instances: BTreeMap<String, _> = instances.map(|(id, fields)| (format!("{id:?}"), fields)).collect();
    let named = instances.values().enumerate().map(|(index, fields)| {
        let fields: BTreeMap<_, _> = fields.iter().collect();
        let columns = fields.into_iter().filter_map(|(name, values)| {
            // The format's clock; a slow topic's step alone would look like nanoseconds.
            let name = if name == "timestamp" { "timestamp [us]" } else { name.as_str() };
            Some(Column::of(name, numbers(values)?))
        });
        let name = if index == 0 { topic.to_owned() } else { format!("{topic} {}", index + 1) };
        Table { name, columns: columns.collect(), keys: Vec::new() }
    });
    named.collect()
}

fn numbers(values: &SomeVec) -> Option<Vec<f64>> {
    fn of<T: Copy + Into<f64>>(values: &[T]) -> Vec<f64> {
        values.iter().map(|value| (*value).into()).collect()
    }
    Some(match values {
        SomeVec::Float(values) => of(values),
        SomeVec::Double(values) => of(values),
        SomeVec::Int8(values) => of(values),
        SomeVec::UInt8(values) => of(values),
        SomeVec::Int16(values) => of(values),
        SomeVec::UInt16(values) => of(values),
        SomeVec::Int32(values) => of(values),
        SomeVec::UInt32(values) => of(values),
        SomeVec::Int64(values) => values.iter().map(|value| *value as f64).collect(),
        SomeVec::UInt64(values) => values.iter().map(|value| *value as f64).collect(),
        SomeVec::Bool(_) | SomeVec::Char(_) => return None,
    })
}
