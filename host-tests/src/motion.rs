//! What moves the probe: its names, and who says so.

use meerkat_mwd::{Config, config::Motion};

use crate::trace::{BodyFrame, Keys, Trace};

const NAMES: [(&str, Motion); 2] = [("hand", Motion::Hand), ("drill_string", Motion::DrillString)];

/// The name in traces and reports.
#[must_use]
pub fn name(motion: Motion) -> &'static str {
    NAMES.into_iter().find(|(_, named)| *named == motion).map_or("unknown", |(name, _)| name)
}

/// The motion of this name.
#[must_use]
pub fn named(name: &str) -> Option<Motion> {
    NAMES.into_iter().find(|(known, _)| *known == name.to_ascii_lowercase()).map(|(_, motion)| motion)
}

/// What a trace says: its key, else its body frame, for who names tool axes has a tool.
#[must_use]
pub fn of_keys(keys: &Keys) -> Motion {
    keys.motion.unwrap_or(match keys.body_frame {
        BodyFrame::Sensor => Motion::Hand,
        BodyFrame::Tool => Motion::DrillString,
    })
}

/// Who says which motion flew.
#[must_use]
pub fn origin(trace: &Trace, config: &Config) -> &'static str {
    let keys = &trace.keys;
    match (keys.motion, keys.body_frame) {
        _ if config.identification.motion != of_keys(keys) => "configuration",
        (Some(_), _) => "key of the trace",
        (None, BodyFrame::Sensor) => "no key; body frame sensor",
        (None, BodyFrame::Tool) => "no key; body frame tool",
    }
}

/// Which motion flew, in one line.
#[must_use]
pub fn line(trace: &Trace, config: &Config) -> String {
    format!("motion: {} ({})", name(config.identification.motion), origin(trace, config))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::of_trace;

    fn line_of(motion: Option<Motion>, body_frame: BodyFrame) -> String {
        let trace = Trace { keys: Keys { motion, body_frame, ..Keys::default() }, ..Trace::default() };
        line(&trace, &of_trace(&trace))
    }

    #[test]
    fn the_key_wins_over_the_body_frame_and_the_configuration_over_both() {
        assert_eq!(line_of(None, BodyFrame::Sensor), "motion: hand (no key; body frame sensor)");
        assert_eq!(line_of(None, BodyFrame::Tool), "motion: drill_string (no key; body frame tool)");
        assert_eq!(line_of(Some(Motion::Hand), BodyFrame::Tool), "motion: hand (key of the trace)");
        let trace = Trace::default();
        let mut config = of_trace(&trace);
        config.identification.motion = Motion::DrillString;
        assert_eq!(line(&trace, &config), "motion: drill_string (configuration)");
    }

    #[test]
    fn a_name_is_read_as_it_is_written() {
        for (text, motion) in NAMES {
            assert_eq!((named(text), name(motion)), (Some(motion), text));
        }
        assert_eq!(named("robot"), None);
    }
}
