//! Messages of ROS 1 and ROS 2: their definition as text, and the numbers in their bytes.
//!
//! Sources: ROS wiki, msg and Serialization; OMG DDSI-RTPS 2.5, section 10 (CDR: values stand at multiples of
//! their own size).

use std::collections::BTreeMap;

/// Elements of a list that become columns; a longer one is skipped.
const LISTED: usize = 16;
/// Messages within messages.
const DEEPEST: usize = 16;

/// Layout of the bytes of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// ROS 1: one after the other.
    Packed,
    /// ROS 2.
    Cdr,
}

/// A field: how many of its type, and its name.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    kind: String,
    count: Count,
    name: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

/// The definition of a message with all that it refers to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    main: Vec<Field>,
    parts: BTreeMap<String, Vec<Field>>,
}

impl Definition {
    /// Reads a definition: the message's own fields, then each other one below a line `MSG: package/Name`.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let mut definition = Self::default();
        let mut part: Option<String> = None;
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() || line.starts_with("==") {
                continue;
            }
            if let Some(name) = line.strip_prefix("MSG:") {
                part = Some(short(name.trim()).to_owned());
                continue;
            }
            let Some(field) = field(line) else { continue };
            match &part {
                Some(name) => definition.parts.entry(name.clone()).or_default().push(field),
                None => definition.main.push(field),
            }
        }
        definition
    }

    /// All numbers of a message with their paths; `None` for bytes that do not fit the definition.
    #[must_use]
    pub fn numbers(&self, layout: Layout, bytes: &[u8]) -> Option<Vec<(String, f64)>> {
        let (bytes, is_little) = match layout {
            Layout::Packed => (bytes, true),
            // The first four bytes tell the order of the others.
            Layout::Cdr => (bytes.get(4..)?, bytes.get(1)? & 1 == 1),
        };
        let mut cursor = Cursor { bytes, at: 0, layout, is_little };
        let mut found = Vec::new();
        self.message(&self.main, "", &mut cursor, &mut found, 0)?;
        Some(found)
    }

    fn message(
        &self,
        fields: &[Field],
        path: &str,
        cursor: &mut Cursor,
        found: &mut Vec<(String, f64)>,
        depth: usize,
    ) -> Option<()> {
        for field in fields {
            let name = if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
            match field.count {
                Count::One => self.value(&field.kind, &name, cursor, found, depth)?,
                Count::Fixed(count) => self.list(count, field, &name, cursor, found, depth)?,
                Count::Any => {
                    let count = usize::try_from(cursor.number("uint32")? as u64).ok()?;
                    self.list(count, field, &name, cursor, found, depth)?;
                }
            }
        }
        Some(())
    }

    fn list(
        &self,
        count: usize,
        field: &Field,
        name: &str,
        cursor: &mut Cursor,
        found: &mut Vec<(String, f64)>,
        depth: usize,
    ) -> Option<()> {
        // Nothing is shorter than a byte: a damaged length must not be counted to its end.
        if count > cursor.bytes.len() {
            return None;
        }
        for index in 0..count {
            let kept = found.len();
            self.value(&field.kind, &format!("{name}[{index}]"), cursor, found, depth)?;
            if count > LISTED {
                found.truncate(kept);
            }
        }
        Some(())
    }

    fn value(
        &self,
        kind: &str,
        name: &str,
        cursor: &mut Cursor,
        found: &mut Vec<(String, f64)>,
        depth: usize,
    ) -> Option<()> {
        match kind {
            "string" => cursor.skip_text(1),
            "wstring" => cursor.skip_text(2),
            "time" | "duration" => {
                let whole = cursor.number(if kind == "time" { "uint32" } else { "int32" })?;
                found.push((format!("{name}.sec"), whole));
                found.push((format!("{name}.nanosec"), cursor.number("uint32")?));
                Some(())
            }
            _ => match cursor.number(kind) {
                Some(number) => {
                    found.push((name.to_owned(), number));
                    Some(())
                }
                None if size(kind).is_some() || depth > DEEPEST => None,
                None => {
                    let known = self.parts.get(short(kind));
                    let time = [self::field("int32 sec")?, self::field("uint32 nanosec")?];
                    // A definition may leave out those that every system has.
                    let fields = match known {
                        Some(fields) => fields.as_slice(),
                        None if matches!(short(kind), "Time" | "Duration") => &time,
                        None => return None,
                    };
                    self.message(fields, name, cursor, found, depth + 1)
                }
            },
        }
    }
}

/// A type's name without its package.
fn short(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// A line of a definition; `None` for a constant.
fn field(line: &str) -> Option<Field> {
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    if name.contains('=') || words.next() == Some("=") {
        return None;
    }
    // A bounded text or list is counted as any other.
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, length)) => (kind, length.trim_end_matches(']').parse().map_or(Count::Any, Count::Fixed)),
    };
    let kind = kind.split("<=").next().unwrap_or(kind);
    Some(Field { kind: kind.to_owned(), count, name: name.to_owned() })
}

/// Bytes of a type of one number.
fn size(kind: &str) -> Option<usize> {
    Some(match kind {
        "bool" | "byte" | "char" | "int8" | "uint8" => 1,
        "int16" | "uint16" => 2,
        "int32" | "uint32" | "float32" => 4,
        "int64" | "uint64" | "float64" => 8,
        _ => return None,
    })
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    layout: Layout,
    is_little: bool,
}

impl Cursor<'_> {
    fn number(&mut self, kind: &str) -> Option<f64> {
        let size = size(kind)?;
        if self.layout == Layout::Cdr {
            self.at = self.at.next_multiple_of(size);
        }
        let read = self.bytes.get(self.at..self.at.checked_add(size)?)?;
        let mut word = [0; 8];
        for (place, byte) in word.iter_mut().enumerate().take(size) {
            *byte = read[if self.is_little { place } else { size - 1 - place }];
        }
        self.at += size;
        let unsigned = u64::from_le_bytes(word);
        Some(match kind {
            "float64" => f64::from_bits(unsigned),
            "float32" => f64::from(f32::from_bits(unsigned as u32)),
            "int8" => f64::from(unsigned as u8 as i8),
            "int16" => f64::from(unsigned as u16 as i16),
            "int32" => f64::from(unsigned as u32 as i32),
            "int64" => unsigned as i64 as f64,
            _ => unsigned as f64,
        })
    }

    fn skip_text(&mut self, width: usize) -> Option<()> {
        let length = (self.number("uint32")? as usize).checked_mul(width)?;
        self.at = self.at.checked_add(length)?;
        (self.at <= self.bytes.len()).then_some(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const IMU: &str = "# An IMU\nstd_msgs/Header header\nuint8 KIND=3\nVector3 rate # rad/s\nfloat64[3] covariance\nfloat32[] more\n\
                       ================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
                       ================\nMSG: geometry_msgs/Vector3\nfloat64 x 0\nfloat64 y\nfloat64 z\n";

    #[test]
    fn a_message_in_cdr_is_read_through_its_padding() {
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(7_i32.to_le_bytes());
        bytes.extend(500_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend(b"imu\0");
        // 16 bytes so far: the next multiple of eight is here.
        [1.0_f64, -2.0, 3.0, 0.1, 0.2, 0.3].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(2_u32.to_le_bytes());
        [8.0_f32, 9.0].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        let numbers = Definition::of(IMU).numbers(Layout::Cdr, &bytes).unwrap();
        let of = |name: &str| numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value);
        assert_eq!((of("header.stamp.sec"), of("header.stamp.nanosec")), (Some(7.0), Some(500.0)));
        assert_eq!((of("rate.y"), of("covariance[2]"), of("more[1]")), (Some(-2.0), Some(0.3), Some(9.0)));
        assert_eq!(numbers.len(), 10);
        for cut in 0..bytes.len() {
            assert_eq!(Definition::of(IMU).numbers(Layout::Cdr, &bytes[..cut]), None);
        }
        // A length beyond the message.
        let at = bytes.len() - 12;
        bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(Definition::of(IMU).numbers(Layout::Cdr, &bytes), None);
    }

    #[test]
    fn a_definition_that_holds_itself_ends() {
        let endless = Definition::of("Part part\n====\nMSG: a/Part\nPart part\n");
        assert_eq!(endless.numbers(Layout::Packed, &[0; 100]), None);
    }
}
