//! Fields of a JSON result, against those that `docs/json.md` names.

use std::{collections::BTreeSet, fs, path::Path};

use serde_json::Value;

/// Fields whose members have names of their own: parameters of an effect or of a sensor, fields of the configuration.
const NAMED: [&str; 7] = [
    "diagnosis.effects[].parameters",
    "diagnosis.effects[].sigma",
    "configuration",
    "accel.parameters",
    "accel.sigma",
    "mag.parameters",
    "mag.sigma",
];

/// Lists of objects: an empty one says nothing of their fields.
const OBJECTS: [&str; 4] = ["identification.windows", "diagnosis.effects", "diagnosis.remainder.goes_with", "surveys"];

/// Adds the paths of all fields of `value`, which stands at `path`.
pub fn fields(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) if NAMED.contains(&path) => {
            assert!(!members.is_empty(), "{path}");
            found.insert(format!("{path}.*"));
        }
        Value::Object(members) => {
            for (name, member) in members {
                let separator = if path.is_empty() { "" } else { "." };
                fields(member, &format!("{path}{separator}{name}"), found);
            }
        }
        Value::Array(elements) if elements.iter().any(Value::is_object) => {
            elements.iter().for_each(|element| fields(element, &format!("{path}[]"), found));
        }
        Value::Array(elements) if elements.is_empty() && OBJECTS.contains(&path) => {}
        _ => {
            found.insert(path.to_owned());
        }
    }
}

/// Fields that a part of the page names.
fn documented(part: &str) -> BTreeSet<String> {
    let rows = part.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
    rows.map(|(field, _)| field.to_owned()).collect()
}

/// Part of `docs/json.md` behind one of its headings.
pub fn part(heading: &str) -> BTreeSet<String> {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/json.md")).unwrap();
    let headed = |part: &&str| part.lines().next() == Some(heading);
    let parts = page.strip_prefix("# ").unwrap().split("\n# ");
    documented(parts.into_iter().find(headed).unwrap_or_else(|| panic!("no heading {heading}")))
}
