//! MCAP, the container of ROS 2 and others: each topic with numbers as a table. Messages in JSON and of ROS 1
//! and 2 are read.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{
    ros_message::{Definition, Layout},
    table::{Column, Contents, TOLD, Table, listed},
};

/// First bytes of such a file.
pub const MAGIC: &[u8] = mcap::MAGIC;

/// Names of the two parts of a time stamp in the encodings.
const STAMPS: [(&str, &str); 6] = [
    ("header.stamp.sec", "header.stamp.nanosec"),
    ("header.stamp.sec", "header.stamp.nsec"),
    ("header.stamp.secs", "header.stamp.nsecs"),
    ("timestamp.sec", "timestamp.nsec"),
    ("timestamp.sec", "timestamp.nanosec"),
    ("stamp.sec", "stamp.nanosec"),
];

/// Beyond this a double does not hold every nanosecond; of a date it holds a quarter of a microsecond.
const EXACT_NS: i64 = 1 << 53;

/// Messages of one topic.
#[derive(Default)]
struct Topic {
    /// Time of each message, nanoseconds: its own stamp, else that of its writing.
    stamps_ns: Vec<Option<i64>>,
    written_ns: Vec<i64>,
    columns: Vec<(String, Vec<f64>)>,
    place: BTreeMap<String, usize>,
}

/// Reads all topics.
///
/// # Errors
/// Description of what is wrong with the file, or that nothing in it can be read.
pub fn read(bytes: &[u8]) -> Result<Contents, String> {
    let failed = |error: mcap::McapError| format!("the MCAP cannot be read: {error}");
    // A recording that was cut off has no footer; what is there counts.
    let options = mcap::read::Options::IgnoreEndMagic | mcap::read::Options::ValidateChunkCrcs;
    let messages = mcap::MessageStream::new_with_options(bytes, options);
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut definitions: BTreeMap<u16, Definition> = BTreeMap::new();
    let mut unread: BTreeMap<String, String> = BTreeMap::new();
    let mut fault = None;
    for message in messages.map_err(failed)? {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                fault = Some(error);
                break;
            }
        };
        let channel = &message.channel;
        let schema = channel.schema.as_ref();
        let numbers = match channel.message_encoding.as_str() {
            "json" => serde_json::from_slice(&message.data).ok().map(|value| of_json(&value)),
            encoding @ ("cdr" | "ros1") => schema.and_then(|schema| {
                let definition = definitions
                    .entry(channel.id)
                    .or_insert_with(|| Definition::of(&String::from_utf8_lossy(&schema.data)));
                definition.numbers(if encoding == "cdr" { Layout::Cdr } else { Layout::Packed }, &message.data)
            }),
            _ => None,
        };
        let Some(numbers) = numbers else {
            unread.insert(channel.topic.clone(), channel.message_encoding.clone());
            continue;
        };
        let written_ns = i64::try_from(message.log_time).unwrap_or(i64::MAX);
        topics.entry(channel.topic.clone()).or_default().take(written_ns, numbers);
    }
    topics.retain(|_, topic| !topic.columns.is_empty());
    let unread: Vec<String> = unread.iter().map(|(topic, encoding)| format!("{topic} ({encoding})")).collect();
    let unread = listed(unread.iter().map(String::as_str), TOLD);
    if topics.is_empty() {
        return Err(fault.map_or_else(
            || format!("the MCAP has no topic in JSON or of ROS 1 or 2 with numbers; it has {unread}"),
            failed,
        ));
    }
    let lost = match fault {
        None if bytes.ends_with(MAGIC) => None,
        None | Some(mcap::McapError::UnexpectedEof) => {
            Some("the MCAP is cut off: what stands before is read".to_owned())
        }
        Some(error) => Some(format!("the MCAP is damaged: what stands behind is not read ({error})")),
    };
    let notes = (!unread.is_empty()).then(|| format!("messages that are not understood are left out: {unread}"));
    let first_ns = topics.values().flat_map(Topic::times_ns).min().unwrap_or(0);
    let start_ns = if first_ns > EXACT_NS { first_ns - first_ns.rem_euclid(1_000_000_000) } else { 0 };
    let tables = topics.into_iter().map(|(name, topic)| topic.table(name, start_ns)).collect();
    Ok(Contents { tables, lost: lost.into_iter().collect(), notes: notes.into_iter().collect() })
}

impl Topic {
    fn take(&mut self, written_ns: i64, numbers: Vec<(String, f64)>) {
        let rows = self.written_ns.len();
        let of = |name: &str| numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value);
        let stamp = STAMPS.iter().find_map(|(whole, part)| Some((of(whole)?, of(part)?)));
        // A stamp that nobody set is zero.
        let stamp_ns = stamp.map(|(whole, part)| whole as i64 * 1_000_000_000 + part as i64).filter(|ns| *ns > 0);
        self.written_ns.push(written_ns);
        self.stamps_ns.push(stamp_ns);
        for (name, value) in numbers {
            let next = self.columns.len();
            let place = *self.place.entry(name.clone()).or_insert(next);
            if place == next {
                self.columns.push((name, Vec::new()));
            }
            if let Some((_, values)) = self.columns.get_mut(place) {
                values.resize(rows, f64::NAN);
                values.push(value);
            }
        }
    }

    fn times_ns(&self) -> impl Iterator<Item = i64> {
        let stamped = self.stamps_ns.iter().filter(|stamp| stamp.is_some()).count();
        // The one or the other for all: two clocks in one column would be none.
        let all = 2 * stamped > self.stamps_ns.len();
        self.stamps_ns
            .iter()
            .zip(&self.written_ns)
            .filter_map(move |(stamp, written)| if all { *stamp } else { Some(*written) })
    }

    fn table(self, name: String, start_ns: i64) -> Table {
        let times: Vec<f64> = self.times_ns().map(|ns| (ns - start_ns) as f64).collect();
        let rows = self.written_ns.len();
        let is_whole = times.len() == rows;
        let is_time = |name: &str| STAMPS.iter().any(|(whole, part)| [*whole, *part].contains(&name));
        let kept = |values: Vec<f64>| -> Vec<f64> {
            let stamped = values.into_iter().zip(&self.stamps_ns);
            stamped.filter(|(_, stamp)| is_whole || stamp.is_some()).map(|(value, _)| value).collect()
        };
        let columns = self.columns.into_iter().filter(|(name, _)| !is_time(name)).map(|(name, mut values)| {
            values.resize(rows, f64::NAN);
            Column::of(&name, kept(values))
        });
        let columns = columns.collect::<Vec<_>>();
        let time = Column::of("timestamp [ns]", times);
        Table { name, columns: [vec![time], columns].concat(), keys: Vec::new() }
    }
}

/// All numbers of a JSON value with their paths.
fn of_json(value: &Value) -> Vec<(String, f64)> {
    fn add(value: &Value, path: &str, found: &mut Vec<(String, f64)>) {
        match value {
            Value::Number(number) => found.extend(number.as_f64().map(|number| (path.to_owned(), number))),
            Value::Bool(is) => found.push((path.to_owned(), f64::from(u8::from(*is)))),
            Value::Array(list) if list.len() <= 16 => {
                list.iter().enumerate().for_each(|(index, value)| add(value, &format!("{path}[{index}]"), found));
            }
            Value::Object(members) => members.iter().for_each(|(name, value)| {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                add(value, &path, found);
            }),
            _ => {}
        }
    }
    let mut found = Vec::new();
    add(value, "", &mut found);
    found
}
