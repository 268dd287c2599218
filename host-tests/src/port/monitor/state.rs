use meerkat_mwd::{
    attitude::AttitudeFlags,
    diagnosis::DiagnosisReport,
    identification::Decision,
    magnet::HardIronInterval,
    survey::{DrillingDynamics, SurveyReport},
    telemetry::{AttitudeFrame, Boot, Health, Identification, LinkCounters, Message},
};

/// The latest of everything that a probe said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// What it runs with.
    pub boot: Option<Boot>,
    /// Angles, and when.
    pub attitude: Option<AttitudeFrame>,
    /// Survey.
    pub survey: Option<SurveyReport>,
    /// Shaking.
    pub dynamics: Option<DrillingDynamics>,
    /// What came of the last window.
    pub identification: Option<Identification>,
    /// When the model that flies was accepted, microseconds; `None`: none was since anything was heard.
    pub model_since_us: Option<u64>,
    /// Effects and verdict.
    pub diagnosis: Option<DiagnosisReport>,
    /// A magnet.
    pub hard_iron: Option<HardIronInterval>,
    /// Counters.
    pub health: Option<Health>,
    /// The latest time that anything was valid at, microseconds.
    pub t_us: u64,
    /// Raw samples that came.
    pub samples: u64,
    /// Frames of another version.
    pub not_understood: u64,
    /// What became of the frames.
    pub link: LinkCounters,
}

impl State {
    /// Takes what came next.
    pub fn take(&mut self, message: Message) {
        let t_us = match message {
            Message::Boot(boot) => {
                // Another run: nothing of the last one is true any more.
                *self = Self { boot: Some(boot), not_understood: self.not_understood, ..Self::default() };
                0
            }
            Message::Attitude(attitude) => self.take_attitude(attitude),
            Message::Output(output) => self.take_attitude(AttitudeFrame::of(&output)),
            Message::Sample(raw) => {
                self.samples += 1;
                raw.sample.t_us
            }
            Message::Survey(survey) => {
                self.survey = Some(survey);
                survey.survey.t_end_us
            }
            Message::Dynamics(dynamics) => {
                self.dynamics = Some(dynamics);
                dynamics.t_end_us
            }
            Message::Identification(identification) => {
                let report = &identification.report;
                if report.decision == Decision::Accepted {
                    self.model_since_us = report.t_effect_us;
                }
                let t_us = report.t_end_us;
                self.identification = Some(identification);
                t_us
            }
            Message::Diagnosis(diagnosis) => {
                self.diagnosis = Some(diagnosis);
                diagnosis.t_end_us
            }
            Message::HardIron(interval) => {
                self.hard_iron = Some(interval);
                interval.from_us
            }
            Message::Health(health) => {
                self.health = Some(health);
                self.model_since_us = health.model_since_us.or(self.model_since_us);
                health.t_us
            }
            _ => 0,
        };
        self.t_us = self.t_us.max(t_us);
    }

    fn take_attitude(&mut self, attitude: AttitudeFrame) -> u64 {
        self.attitude = Some(attitude);
        attitude.t_us
    }

    /// How long the model has flown, seconds.
    #[must_use]
    pub fn model_age_s(&self) -> Option<f64> {
        self.model_since_us.map(|since| self.t_us.saturating_sub(since) as f64 * 1e-6)
    }
}

/// What a reader has to know of an attitude, in words.
#[must_use]
pub fn flags_text(flags: AttitudeFlags) -> String {
    let names = [
        (AttitudeFlags::GYRO_HELD, "no gyro reading"),
        (AttitudeFlags::GYRO_CLIPPED, "gyro at full scale"),
        (AttitudeFlags::ACCEL_UNUSED, "accelerometer not used"),
        (AttitudeFlags::MAG_UNUSED, "magnetometer not used"),
        (AttitudeFlags::NO_HEADING, "no heading"),
        (AttitudeFlags::NEAR_VERTICAL, "near vertical"),
        (AttitudeFlags::AFTER_GAP, "after a gap"),
        (AttitudeFlags::FAULT, "fault"),
        (AttitudeFlags::FROZEN_SENSOR, "frozen sensor"),
    ];
    let set: Vec<&str> = names.iter().filter(|(flag, _)| flags.contains(*flag)).map(|(_, name)| *name).collect();
    set.join(", ")
}
