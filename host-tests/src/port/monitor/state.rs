use meerkat_mwd::{
    attitude::AttitudeFlags,
    diagnosis::DiagnosisReport,
    identification::Decision,
    magnet::HardIronInterval,
    survey::{BurstSample, DrillingDynamics, SlidingToolface, SurveyReport, VibrationDose},
    telemetry::{AttitudeFrame, Boot, BurstPart, Health, Identification, LinkCounters, Message},
};

/// The latest report of each kind that a probe has sent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Configuration and firmware, from the report of the start.
    pub boot: Option<Boot>,
    /// Latest angles, with their time.
    pub attitude: Option<AttitudeFrame>,
    /// Latest survey.
    pub survey: Option<SurveyReport>,
    /// Latest drilling dynamics: vibration and shocks.
    pub dynamics: Option<DrillingDynamics>,
    /// Latest mean toolface while sliding.
    pub toolface: Option<SlidingToolface>,
    /// Dose of vibration that the tool has taken.
    pub dose: Option<VibrationDose>,
    /// Raw samples around the worst second, as far as they have come in order.
    pub burst: Vec<BurstSample>,
    /// Number of samples of that burst, and its root mean square about its mean, m/s^2.
    pub burst_of: Option<(usize, f32)>,
    /// Result of the latest window.
    pub identification: Option<Identification>,
    /// Time at which the flown model was accepted, microseconds; `None` if not since listening began.
    pub model_since_us: Option<u64>,
    /// Latest diagnosis: effects and verdict.
    pub diagnosis: Option<DiagnosisReport>,
    /// Latest magnet that came or left.
    pub hard_iron: Option<HardIronInterval>,
    /// Latest counters of the probe.
    pub health: Option<Health>,
    /// Latest time of validity of anything, microseconds.
    pub t_us: u64,
    /// Number of raw samples received.
    pub samples: u64,
    /// Number of frames of another version.
    pub not_understood: u64,
    /// Counters of the decoder.
    pub link: LinkCounters,
}

impl State {
    /// Takes the next message.
    pub fn take(&mut self, message: Message) {
        let t_us = match message {
            Message::Boot(boot) => {
                // The probe has restarted: what it said before no longer holds.
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
            Message::Toolface(toolface) => {
                self.toolface = Some(toolface);
                toolface.t_end_us
            }
            Message::Dose(dose) => {
                self.dose = Some(dose);
                0
            }
            Message::Burst(part) => {
                self.take_part(&part);
                0
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

    /// Takes a part of the worst second. One that does not follow the parts before it came after a loss, and is not
    /// taken.
    fn take_part(&mut self, part: &BurstPart) {
        if part.first == 0 {
            self.burst.clear();
        }
        if self.burst.len() == usize::from(part.first) {
            self.burst.extend_from_slice(&part.samples);
            self.burst_of = Some((part.of.into(), part.rms_m_s2));
        }
    }

    fn take_attitude(&mut self, attitude: AttitudeFrame) -> u64 {
        self.attitude = Some(attitude);
        attitude.t_us
    }

    /// Time that the model has flown, seconds.
    #[must_use]
    pub fn model_age_s(&self) -> Option<f64> {
        self.model_since_us.map(|since| self.t_us.saturating_sub(since) as f64 * 1e-6)
    }
}

/// Flags of an attitude, in words.
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
