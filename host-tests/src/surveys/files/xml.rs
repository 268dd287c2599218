//! XML text.

use super::push;

/// Appends an element with an optional unit.
pub(super) fn element(text: &mut String, name: &str, unit: Option<&str>, value: &str) {
    let value = escaped(value);
    match unit {
        Some(unit) => push(text, format_args!("<{name} uom=\"{unit}\">{value}</{name}>\n")),
        None => push(text, format_args!("<{name}>{value}</{name}>\n")),
    }
}

/// Text between tags or in an attribute.
pub(super) fn escaped(text: &str) -> String {
    let valid = text.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\t'));
    valid.fold(String::new(), |mut escaped, c| {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c => escaped.push(c),
        }
        escaped
    })
}
