//! History of what a probe has said since listening began, as far as a page shows it over time.

use meerkat_mwd::{
    Config,
    attitude::Attitude,
    probe::Output,
    survey::{DrillingDynamics, SurveyReport},
    telemetry::{AttitudeFrame, Message},
};

use crate::report::html::live::Heard;
use testbed::flight::{Flight, Watched};

/// Most attitudes that are kept: of more, every second one of the older half goes.
const MOST_ATTITUDES: usize = 12_000;

/// Most windows, surveys and windows of dynamics that are kept, each: of more, the oldest goes.
const MOST: usize = 2_000;

/// Attitudes, windows, surveys and dynamics in the order in which they came.
#[derive(Clone, Debug, Default)]
pub struct History {
    config: Config,
    flight: Flight,
    watched: Watched,
    span_us: Option<[u64; 2]>,
}

impl History {
    /// Takes the next message.
    pub fn take(&mut self, message: &Message) {
        match message {
            // The probe has begun anew, and so has its time.
            Message::Boot(boot) => *self = Self { config: boot.config, ..Self::default() },
            Message::Attitude(frame) => self.take_output(output(frame)),
            Message::Output(output) => self.take_output(*output),
            Message::Survey(survey) => {
                self.reaches(survey.survey.t_end_us);
                kept::<SurveyReport>(&mut self.watched.surveys, *survey);
            }
            Message::Dynamics(dynamics) => {
                self.reaches(dynamics.t_end_us);
                kept::<DrillingDynamics>(&mut self.watched.dynamics, *dynamics);
            }
            Message::Identification(identification) => {
                self.reaches(identification.report.t_end_us);
                kept(&mut self.flight.reports, identification.report);
            }
            _ => {}
        }
    }

    /// Data of the history for a page, with the latest reports in lines.
    #[must_use]
    pub const fn heard<'a>(&'a self, lines: &'a [String]) -> Heard<'a> {
        Heard { config: &self.config, flight: &self.flight, watched: &self.watched, lines, span_us: self.span_us }
    }

    fn take_output(&mut self, output: Output) {
        self.reaches(output.t_us);
        let outputs = &mut self.flight.outputs;
        outputs.push(output);
        if outputs.len() > MOST_ATTITUDES {
            let mut place = 0;
            outputs.retain(|_| {
                place += 1;
                place > MOST_ATTITUDES / 2 || place % 2 == 1
            });
        }
    }

    fn reaches(&mut self, t_us: u64) {
        let [from_us, to_us] = self.span_us.unwrap_or([t_us, t_us]);
        self.span_us = Some([from_us.min(t_us), to_us.max(t_us)]);
    }
}

/// Appends what is new.
fn kept<T>(all: &mut Vec<T>, new: T) {
    if all.len() >= MOST {
        all.remove(0);
    }
    all.push(new);
}

/// The output that a compact frame was made from, as far as it is in it: the rate is not.
fn output(frame: &AttitudeFrame) -> Output {
    let attitude = frame.angles.map(|angles| {
        let [sigma_inclination_rad, sigma_azimuth_rad, sigma_toolface_rad] = angles.sigmas_rad();
        Attitude {
            q: [1.0, 0.0, 0.0, 0.0],
            inclination_rad: angles.inclination_rad(),
            azimuth_rad: angles.azimuth_rad(),
            gravity_toolface_rad: angles.gravity_toolface_rad(),
            magnetic_toolface_rad: angles.magnetic_toolface_rad(),
            sigma_inclination_rad,
            sigma_azimuth_rad,
            sigma_toolface_rad,
            flags: angles.flags(),
        }
    });
    Output { t_us: frame.t_us, rate_rad_s: [f32::NAN; 3], attitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_stays_small_and_keeps_its_begin_and_its_end() {
        let mut history = History::default();
        for t_us in 0..100_000 {
            history.take(&Message::Attitude(AttitudeFrame { t_us, angles: None }));
        }
        let outputs = &history.flight.outputs;
        assert!(outputs.len() <= MOST_ATTITUDES && outputs.last().is_some_and(|output| output.t_us == 99_999));
        assert!(outputs.first().is_some_and(|output| output.t_us < 1_000));
        assert_eq!(history.span_us, Some([0, 99_999]));
    }
}
