//! The kind of motion that a flight was configured for, and where it was stated.

use meerkat_mwd::{Config, config::Motion};

use testbed::trace::{BodyFrame, Trace, motion::name};

/// Where the kind of motion was stated.
#[must_use]
pub fn origin(trace: &Trace, config: &Config) -> &'static str {
    let keys = &trace.keys;
    match (keys.motion, keys.body_frame) {
        _ if config.identification.motion != keys.motion() => "configuration",
        (Some(_), _) => "key of the trace",
        (None, BodyFrame::Sensor) => "no key; body frame sensor",
        (None, BodyFrame::Tool) => "no key; body frame tool",
    }
}

/// The kind of motion and its origin in one line.
#[must_use]
pub fn line(trace: &Trace, config: &Config) -> String {
    format!("motion: {} ({})", name(config.identification.motion), origin(trace, config))
}

/// The same as a sentence, for a reader who does not know the keys.
#[must_use]
pub fn sentence(trace: &Trace, config: &Config) -> String {
    let taken = match config.identification.motion {
        Motion::Hand => "Taken as moved by hand",
        _ => "Taken as turned by a drill string",
    };
    let keys = &trace.keys;
    let why = match (keys.motion, keys.body_frame) {
        _ if config.identification.motion != keys.motion() => "as the configuration says",
        (Some(_), _) => "as the recording says",
        (None, BodyFrame::Sensor) => {
            "since the recording does not say, and its axes are those of a sensor, not of a tool"
        }
        (None, BodyFrame::Tool) => "since the recording's axes are a tool's",
    };
    format!("{taken}, {why}.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use testbed::flight::configuration::of_trace;
    use testbed::trace::Keys;

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
        assert_eq!(sentence(&trace, &config), "Taken as turned by a drill string, as the configuration says.");
    }
}
