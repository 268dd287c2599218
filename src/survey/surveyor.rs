//! Surveyor: surveys of every kind, and the watch of the drilling, behind one call a sample.

use super::{
    DrillingDynamics, SlidingToolface, StationaryState, Survey, SurveyInput, SurveyNews, SurveyReport, Surveys,
    VibrationDose, drilling_watch::DrillingWatch, surveys::Step,
};
use crate::config::{ConfigError, Earth, SurveyConfig};

/// Computes surveys of every kind from a probe's samples. It owns its buffers; nothing allocates and nothing can panic.
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
    surveys: Surveys,
    drilling: DrillingWatch,
}

impl Surveyor {
    /// Returns a surveyor without a configuration, which takes no surveys; as a static it takes 2.3 KiB of RAM and as
    /// much flash, but no flash if it is written to uninitialised memory.
    #[must_use]
    pub const fn new() -> Self {
        Self { surveys: Surveys::new(), drilling: DrillingWatch::new() }
    }

    /// Checks a configuration and starts anew from it. `earth` is the probe's: its declination says whether
    /// the attitudes count from true or from magnetic north. The dose stays.
    ///
    /// # Errors
    /// Names the field that cannot be used; the surveyor then stays as it was.
    pub fn configure(&mut self, earth: &Earth, config: &SurveyConfig) -> Result<(), ConfigError> {
        self.surveys.configure(earth, config)?;
        self.drilling.restart();
        Ok(())
    }

    /// Starts anew with the present configuration: no survey, and no evidence of rest. The dose stays.
    pub fn restart(&mut self) {
        self.surveys.restart();
        self.drilling.restart();
    }

    /// Configuration in use; `None` before one.
    #[must_use]
    pub fn config(&self) -> Option<&SurveyConfig> {
        self.surveys.config()
    }

    /// Takes one sample. Nothing happens before a configuration, nor with a sample whose time does not increase. A
    /// sample more than ten seconds before the last one starts all anew: the clock has gone back for good.
    // Not inlined: its stack frame would else lie under that of the work between samples.
    #[inline(never)]
    pub fn push(&mut self, input: &SurveyInput) -> SurveyNews {
        match self.surveys.follow(input.t_us) {
            Step::Forward(step_s) => {
                let input = input.sanitised();
                let news = self.surveys.take(&input, step_s);
                news | self.drilling.push(&input, &self.surveys)
            }
            Step::Afresh => {
                self.drilling.restart();
                SurveyNews::empty()
            }
            Step::Refused => SurveyNews::empty(),
        }
    }

    /// Survey at the last sample, from the attitude filter; azimuth from magnetic, true and grid north.
    /// `None` without an attitude.
    #[must_use]
    pub fn continuous(&self) -> Option<Survey> {
        self.surveys.continuous()
    }

    /// Latest stationary survey, latched.
    #[must_use]
    pub const fn stationary(&self) -> Option<&SurveyReport> {
        self.surveys.stationary()
    }

    /// Latest rotating survey.
    #[must_use]
    pub const fn rotating(&self) -> Option<&SurveyReport> {
        self.surveys.rotating()
    }

    /// Latest window of drilling dynamics.
    #[must_use]
    pub const fn dynamics(&self) -> Option<&DrillingDynamics> {
        self.drilling.last_dynamics.as_ref()
    }

    /// Latest toolface while sliding: one every five seconds in which the tool does not rotate.
    #[must_use]
    pub const fn sliding_toolface(&self) -> Option<&SlidingToolface> {
        self.drilling.last_toolface.as_ref()
    }

    /// Vibration and shocks since the start, added to the resumed dose if any; it grows with each window. A new
    /// configuration does not reset it.
    #[must_use]
    pub const fn dose(&self) -> &VibrationDose {
        &self.drilling.dose
    }

    /// Sets the dose that was stored before a loss of power, to which windows are then added.
    pub const fn resume_dose(&mut self, dose: VibrationDose) {
        self.drilling.dose = dose;
    }

    /// Stage of the stationary survey.
    #[must_use]
    pub const fn state(&self) -> StationaryState {
        self.surveys.state()
    }

    /// Returns true if the tool is known to stand still at `now_us`, in the samples' clock: gyro and accelerometer gave
    /// valid readings at rest less than a second ago. In every other case, also without samples, it may be drilling.
    #[must_use]
    pub fn stands_still(&self, now_us: u64) -> bool {
        self.surveys.stands_still(now_us)
    }

    /// Returns true if the tool turns about its axis.
    #[must_use]
    pub const fn is_rotating(&self) -> bool {
        self.surveys.is_rotating()
    }
}

impl Default for Surveyor {
    fn default() -> Self {
        Self::new()
    }
}
