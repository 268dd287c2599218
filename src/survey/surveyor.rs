//! Surveyor: all kinds of surveys behind one call a sample.

use super::{
    DrillingDynamics, SlidingToolface, StationaryState, Survey, SurveyInput, SurveyReport, VibrationDose,
    continuous::Continuous, dynamics::DynamicsWindow, record::ToolfaceSwitch, rotating::RotatingSurvey,
    sliding_toolface::SlidingMean, stationary::StationarySurvey,
};
use crate::config::{ConfigError, Earth, SurveyConfig};

bitflags::bitflags! {
    /// Results that a sample completed; they stay with the [`Surveyor`] until the next ones.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct SurveyNews: u8 {
        /// A stationary survey: [`Surveyor::stationary`].
        const STATIONARY = 1;
        /// A rotating survey: [`Surveyor::rotating`].
        const ROTATING = 1 << 1;
        /// A window of drilling dynamics: [`Surveyor::dynamics`].
        const DYNAMICS = 1 << 2;
        /// A toolface while sliding: [`Surveyor::sliding_toolface`].
        const TOOLFACE = 1 << 3;
    }
}

/// Step back in time that is the clock's and not a sample's, microseconds: the probe believes none that is longer
/// without another one.
const CLOCK_WENT_BACK_US: u64 = 10_000_000;

/// Taker of surveys of every kind from a probe's samples. It owns its buffers; nothing allocates and nothing
/// can panic.
///
/// Once a sample:
/// ```
/// # use meerkat_mwd::{Config, survey::{SurveyInput, SurveyNews, Surveyor}};
/// # let (input, config) = (SurveyInput::default(), Config::default());
/// let mut surveyor = Surveyor::new();
/// surveyor.configure(&config.earth, &config.survey)?;
/// if surveyor.push(&input).contains(SurveyNews::STATIONARY) {
///     // surveyor.stationary() has it, with its quality and the six-axis means
/// }
/// # Ok::<(), meerkat_mwd::config::ConfigError>(())
/// ```
pub struct Surveyor {
    settings: Option<(Earth, SurveyConfig)>,
    last_us: Option<u64>,
    continuous: Continuous,
    continuous_toolface: ToolfaceSwitch,
    stationary: StationarySurvey,
    stationary_toolface: ToolfaceSwitch,
    rotating: RotatingSurvey,
    rotating_toolface: ToolfaceSwitch,
    dynamics: DynamicsWindow,
    sliding: SlidingMean,
    dose: VibrationDose,
    last_stationary: Option<SurveyReport>,
    last_rotating: Option<SurveyReport>,
    last_dynamics: Option<DrillingDynamics>,
    last_toolface: Option<SlidingToolface>,
}

impl Surveyor {
    /// Returns a surveyor without a configuration, which takes no surveys; as a static it takes 2.3 KiB of RAM
    /// and as much flash.
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
            dynamics: DynamicsWindow::new(),
            sliding: SlidingMean::new(),
            dose: VibrationDose::NONE,
            last_stationary: None,
            last_rotating: None,
            last_dynamics: None,
            last_toolface: None,
        }
    }

    /// Checks a configuration and starts anew from it. `earth` is the probe's: its declination says whether
    /// the attitudes count from true or from magnetic north.
    ///
    /// # Errors
    /// Names the field that cannot be used; the surveyor then stays as it was.
    pub fn configure(&mut self, earth: &Earth, config: &SurveyConfig) -> Result<(), ConfigError> {
        config.validate()?;
        *self = Self { settings: Some((*earth, *config)), ..Self::new() };
        Ok(())
    }

    /// Starts anew with the present configuration: no survey, and no evidence of rest. The dose stays.
    pub fn restart(&mut self) {
        *self = Self { settings: self.settings, dose: self.dose, ..Self::new() };
    }

    /// Configuration in use; `None` before one.
    #[must_use]
    pub fn config(&self) -> Option<&SurveyConfig> {
        self.settings.as_ref().map(|(_, config)| config)
    }

    /// Takes one sample. Nothing happens before a configuration, nor with a sample whose time does not
    /// increase. A sample that is more than ten seconds old begins anew: the clock has gone back for good.
    pub fn push(&mut self, input: &SurveyInput) -> SurveyNews {
        let mut news = SurveyNews::empty();
        let Some((earth, config)) = &self.settings else { return news };
        if let Some(last) = self.last_us
            && input.t_us <= last
        {
            if last - input.t_us > CLOCK_WENT_BACK_US {
                self.restart();
            }
            return news;
        }
        let input = input.sanitised();
        let step_us = self.last_us.map_or(0, |last| input.t_us.saturating_sub(last));
        self.last_us = Some(input.t_us);
        if let Some(attitude) = &input.attitude {
            self.continuous_toolface.update(attitude.inclination_rad, config);
        }
        self.continuous.push(&input, step_us as f32 * 1e-6);
        if let Some(report) = self.stationary.push(&input, &mut self.stationary_toolface, (earth, config)) {
            self.last_stationary = Some(report);
            news.insert(SurveyNews::STATIONARY);
        }
        if let Some(report) = self.rotating.push(&input, &mut self.rotating_toolface, (earth, config)) {
            self.last_rotating = Some(report);
            news.insert(SurveyNews::ROTATING);
        }
        if let Some(window) = self.dynamics.push(&input, earth, &config.dynamics, config.rotating_rad_s) {
            self.dose.add(&window);
            self.last_dynamics = Some(window);
            news.insert(SurveyNews::DYNAMICS);
        }
        if self.sliding.push(&input, self.rotating.is_rotating(), self.continuous_toolface)
            && let Some(survey) = self.continuous.survey(self.continuous_toolface, false, (earth, config))
            && let Some(toolface) = self.sliding.take(&survey, (earth.declination_rad.unwrap_or(0.0), config))
        {
            self.last_toolface = Some(toolface);
            news.insert(SurveyNews::TOOLFACE);
        }
        news
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

    /// Latest window of drilling dynamics.
    #[must_use]
    pub const fn dynamics(&self) -> Option<&DrillingDynamics> {
        self.last_dynamics.as_ref()
    }

    /// Latest toolface while sliding: one every five seconds in which the tool does not rotate.
    #[must_use]
    pub const fn sliding_toolface(&self) -> Option<&SlidingToolface> {
        self.last_toolface.as_ref()
    }

    /// Vibration and shocks since the configuration, window by window.
    #[must_use]
    pub const fn dose(&self) -> &VibrationDose {
        &self.dose
    }

    /// Goes on from a dose that was kept over a loss of power.
    pub const fn resume_dose(&mut self, dose: VibrationDose) {
        self.dose = dose;
    }

    /// Stage of the stationary survey.
    #[must_use]
    pub const fn state(&self) -> StationaryState {
        self.stationary.state()
    }

    /// Returns true if the tool is known to stand still at `now_us`, in the samples' clock: gyro and accelerometer both
    /// read, are sound and rest, less than a second ago. Everything else, silence too, may be drilling.
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

impl Default for Surveyor {
    fn default() -> Self {
        Self::new()
    }
}
