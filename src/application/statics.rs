//! Buffers of the application.

use super::{Burst, Commands, Line, Memory};
use crate::{Probe, survey::Surveyor};

/// Buffers of the application, in static RAM.
pub struct Statics<'a, F> {
    /// Samples to attitudes and models.
    pub probe: &'a mut Probe,
    /// Attitudes to surveys.
    pub surveyor: &'a mut Surveyor,
    /// Recorder of the second with the worst vibration.
    pub burst: &'a mut Burst,
    /// Line that sends messages to the host.
    pub line: &'a mut Line,
    /// Receiver of the host's commands.
    pub commands: &'a mut Commands,
    /// Stored models; `None` if no flash can be used: the probe flies without.
    pub memory: Option<&'a mut Memory<F>>,
}
