//! Surveys.
mod north;
mod quality;
mod record;
mod sensor_errors;
mod six_axis;
mod uncertain;

pub use quality::{Check, Checked, Grade, Quality};
pub use record::{Survey, SurveyKind, ToolfaceKind};
pub use uncertain::Uncertain;
