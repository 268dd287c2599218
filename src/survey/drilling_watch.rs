//! Watch of the drilling between surveys: vibration, shocks and whirl, their dose, and the toolface while sliding.

use super::{
    DrillingDynamics, SlidingToolface, SurveyInput, SurveyNews, Surveys, VibrationDose, dynamics::DynamicsInterval,
    sliding_toolface::SlidingMean,
};

/// Intervals of dynamics from one report of the dose to the next: five minutes by default.
const DOSE_INTERVALS: u8 = 10;

/// Watch of the drilling, with its latest results.
pub(super) struct DrillingWatch {
    dynamics: DynamicsInterval,
    sliding: SlidingMean,
    pub dose: VibrationDose,
    /// Intervals since the dose was reported.
    intervals: u8,
    pub last_dynamics: Option<DrillingDynamics>,
    pub last_toolface: Option<SlidingToolface>,
}

impl DrillingWatch {
    pub const fn new() -> Self {
        Self {
            dynamics: DynamicsInterval::new(),
            sliding: SlidingMean::new(),
            dose: VibrationDose::NONE,
            intervals: 0,
            last_dynamics: None,
            last_toolface: None,
        }
    }

    /// Starts anew; the dose stays.
    pub fn restart(&mut self) {
        *self = Self { dose: self.dose, ..Self::new() };
    }

    /// Takes a sample that the surveys have taken.
    pub fn push(&mut self, input: &SurveyInput, surveys: &Surveys) -> SurveyNews {
        let mut news = SurveyNews::empty();
        let Some((earth, config)) = surveys.settings() else { return news };
        if let Some(interval) = self.dynamics.push(input, earth, &config.dynamics, config.rotating_rad_s) {
            self.dose.add(&interval);
            self.last_dynamics = Some(interval);
            news.insert(SurveyNews::DYNAMICS);
            self.intervals += 1;
            if self.intervals >= DOSE_INTERVALS {
                self.intervals = 0;
                news.insert(SurveyNews::DOSE);
            }
        }
        // A mean completes only while the tool does not rotate, so that this continuous survey is of a sliding tool.
        if self.sliding.push(input, surveys.is_rotating(), surveys.toolface())
            && let Some(survey) = surveys.continuous()
            && let Some(toolface) = self.sliding.take(&survey, (earth.declination_rad.unwrap_or(0.0), config))
        {
            self.last_toolface = Some(toolface);
            news.insert(SurveyNews::TOOLFACE);
        }
        news
    }
}
