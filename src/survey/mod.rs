//! Surveys: the tool's direction at a station, while rotating and at every sample; their quality; drilling
//! dynamics.
//!
//! A [`Surveyor`] takes one [`SurveyInput`] a sample; [`Surveys`] does without drilling dynamics. Gravity and field
//! come calibrated and in tool axes. The sigmas are those of the ISCWSA MWD error model
//! ([`crate::config::SurveyErrors`]), plus the noise that the averages themselves show.

mod axial;
mod burst;
mod continuous;
mod drilling_watch;
mod dynamics;
mod input;
mod means;
pub mod multi_station;
mod north;
mod quality;
mod record;
mod report;
mod rotating;
mod sensor_errors;
pub mod severity;
mod six_axis;
mod sliding_toolface;
mod station_axes;
mod stationary;
mod surveyor;
mod surveys;
mod turn;
mod uncertain;
mod whirl;

pub use axial::AxialCorrection;
pub use burst::{BurstRecorder, BurstSample};
pub use dynamics::{DrillingDynamics, Rotation, SHOCK_LEVELS};
pub use input::SurveyInput;
pub use quality::{Check, Checked, Grade, Quality};
pub use record::{Survey, SurveyKind, ToolfaceKind};
pub use report::{SixAxisAverages, SurveyReport};
pub use severity::VibrationDose;
pub use sliding_toolface::{SLIDING_TOOLFACE_US, SlidingToolface};
pub use stationary::StationaryState;
pub use surveyor::Surveyor;
pub use surveys::{SurveyNews, Surveys};
pub use uncertain::Uncertain;
pub use whirl::{Whirl, WhirlKind};
