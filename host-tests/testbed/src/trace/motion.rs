//! Names of the kinds of motion.

use meerkat_mwd::config::Motion;

const NAMES: [(&str, Motion); 2] = [("hand", Motion::Hand), ("drill_string", Motion::DrillString)];

/// Name of a kind of motion, as in traces and reports.
#[must_use]
pub fn name(motion: Motion) -> &'static str {
    NAMES.into_iter().find(|(_, named)| *named == motion).map_or("unknown", |(name, _)| name)
}

/// The kind of motion with this name.
#[must_use]
pub fn named(name: &str) -> Option<Motion> {
    NAMES.into_iter().find(|(known, _)| *known == name.to_ascii_lowercase()).map(|(_, motion)| motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_read_as_it_is_written() {
        for (text, motion) in NAMES {
            assert_eq!((named(text), name(motion)), (Some(motion), text));
        }
        assert_eq!(named("robot"), None);
    }
}
