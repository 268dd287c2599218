//! Surveys: stationary, rotating and continuous ones behind one call a sample.

use super::{
    StationaryState, Survey, SurveyInput, SurveyReport, continuous::Continuous, record::ToolfaceSwitch,
    rotating::RotatingSurvey, stationary::StationarySurvey,
};
use crate::{
    config::{ConfigError, Earth, SurveyConfig},
    time_step::is_another_clock,
};

bitflags::bitflags! {
    /// Results that a sample completed; they stay with [`Surveys`] or the [`Surveyor`](super::Surveyor) until the next
    /// ones.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct SurveyNews: u8 {
        /// A stationary survey: [`Surveys::stationary`].
        const STATIONARY = 1;
        /// A rotating survey: [`Surveys::rotating`].
        const ROTATING = 1 << 1;
        /// A window of drilling dynamics: [`Surveyor::dynamics`](super::Surveyor::dynamics).
        const DYNAMICS = 1 << 2;
        /// A toolface while sliding: [`Surveyor::sliding_toolface`](super::Surveyor::sliding_toolface).
        const TOOLFACE = 1 << 3;
        /// The dose, after every tenth window: [`Surveyor::dose`](super::Surveyor::dose).
        const DOSE = 1 << 4;
    }
}

/// Meaning of a sample's time.
pub(super) enum Step {
    /// The sample is not taken.
    Refused,
    /// The clock has gone back for good: all surveys began anew, and the sample is not taken.
    Afresh,
    /// Seconds since the sample before.
    Forward(f32),
}

/// Computes surveys alone, in 1.8 KB, for a microcontroller with little memory; a [`Surveyor`](super::Surveyor) watches
/// the drilling, too. It owns its buffers; nothing allocates and nothing can panic.
pub struct Surveys {
    settings: Option<(Earth, SurveyConfig)>,
    last_us: Option<u64>,
    continuous: Continuous,
    continuous_toolface: ToolfaceSwitch,
    stationary: StationarySurvey,
    stationary_toolface: ToolfaceSwitch,
    rotating: RotatingSurvey,
    rotating_toolface: ToolfaceSwitch,
    last_stationary: Option<SurveyReport>,
    last_rotating: Option<SurveyReport>,
}

impl Surveys {
    /// Returns a `Surveys` without a configuration, which takes no surveys.
    #[must_use]
    pub const fn new() -> Self {
        let toolface = ToolfaceSwitch::new();
        Self {
            settings: None,
            last_us: None,
            continuous: Continuous::new(),
            continuous_toolface: toolface,
            stationary: StationarySurvey::new(),
            stationary_toolface: toolface,
            rotating: RotatingSurvey::new(),
            rotating_toolface: toolface,
            last_stationary: None,
            last_rotating: None,
        }
    }

    /// Checks a configuration and starts anew from it. `earth` is the probe's: its declination says whether
    /// the attitudes count from true or from magnetic north.
    ///
    /// # Errors
    /// Names the field that cannot be used; the surveys then stay as they were.
    pub fn configure(&mut self, earth: &Earth, config: &SurveyConfig) -> Result<(), ConfigError> {
        earth.validate()?;
        config.validate()?;
        *self = Self { settings: Some((*earth, *config)), ..Self::new() };
        Ok(())
    }

    /// Starts anew with the present configuration: no survey, and no evidence of rest.
    pub fn restart(&mut self) {
        *self = Self { settings: self.settings, ..Self::new() };
    }

    /// Configuration in use; `None` before one.
    #[must_use]
    pub fn config(&self) -> Option<&SurveyConfig> {
        self.settings.as_ref().map(|(_, config)| config)
    }

    /// Takes one sample. Nothing happens before a configuration, nor with a sample whose time does not increase. A
    /// sample more than ten seconds before the last one starts all anew: the clock has gone back for good.
    // Not inlined, for the reason given at `Surveyor::push`.
    #[inline(never)]
    pub fn push(&mut self, input: &SurveyInput) -> SurveyNews {
        match self.follow(input.t_us) {
            Step::Forward(step_s) => self.take(&input.sanitised(), step_s),
            Step::Refused | Step::Afresh => SurveyNews::empty(),
        }
    }

    /// Takes the time of a sample.
    pub(super) fn follow(&mut self, t_us: u64) -> Step {
        if self.settings.is_none() {
            return Step::Refused;
        }
        if let Some(last) = self.last_us
            && t_us <= last
        {
            if is_another_clock(last, t_us) {
                self.restart();
                return Step::Afresh;
            }
            return Step::Refused;
        }
        let step_us = self.last_us.map_or(0, |last| t_us.saturating_sub(last));
        self.last_us = Some(t_us);
        Step::Forward(step_us as f32 * 1e-6)
    }

    /// Takes a sanitised sample, `step_s` seconds after the one before.
    pub(super) fn take(&mut self, input: &SurveyInput, step_s: f32) -> SurveyNews {
        let mut news = SurveyNews::empty();
        let Some((earth, config)) = &self.settings else { return news };
        if let Some(attitude) = &input.attitude {
            self.continuous_toolface.update(attitude.inclination_rad, config);
        }
        self.continuous.push(input, step_s);
        if let Some(mut report) = self.stationary.push(input, &mut self.stationary_toolface, (earth, config)) {
            report.quality.mounted(input.mounting_wrong);
            self.last_stationary = Some(report);
            news.insert(SurveyNews::STATIONARY);
        }
        if let Some(mut report) = self.rotating.push(input, &mut self.rotating_toolface, (earth, config)) {
            report.quality.mounted(input.mounting_wrong);
            self.last_rotating = Some(report);
            news.insert(SurveyNews::ROTATING);
        }
        news
    }

    /// Earth and configuration in use; `None` before them.
    pub(super) const fn settings(&self) -> Option<&(Earth, SurveyConfig)> {
        self.settings.as_ref()
    }

    /// Toolface that applies to the continuous survey.
    pub(super) const fn toolface(&self) -> ToolfaceSwitch {
        self.continuous_toolface
    }

    /// Survey at the last sample, from the attitude filter; azimuth from magnetic, true and grid north.
    /// `None` without an attitude.
    #[must_use]
    pub fn continuous(&self) -> Option<Survey> {
        let (earth, config) = self.settings.as_ref()?;
        self.continuous.survey(self.continuous_toolface, self.rotating.is_rotating(), (earth, config))
    }

    /// Latest stationary survey, latched.
    #[must_use]
    pub const fn stationary(&self) -> Option<&SurveyReport> {
        self.last_stationary.as_ref()
    }

    /// Latest rotating survey.
    #[must_use]
    pub const fn rotating(&self) -> Option<&SurveyReport> {
        self.last_rotating.as_ref()
    }

    /// Stage of the stationary survey.
    #[must_use]
    pub const fn state(&self) -> StationaryState {
        self.stationary.state()
    }

    /// Returns true if the tool is known to stand still at `now_us`, in the samples' clock: gyro and accelerometer gave
    /// valid readings at rest less than a second ago. In every other case, also without samples, it may be drilling.
    #[must_use]
    pub fn stands_still(&self, now_us: u64) -> bool {
        self.stationary.stands_still(now_us)
    }

    /// Returns true if the tool turns about its axis.
    #[must_use]
    pub const fn is_rotating(&self) -> bool {
        self.rotating.is_rotating()
    }
}

impl Default for Surveys {
    fn default() -> Self {
        Self::new()
    }
}
