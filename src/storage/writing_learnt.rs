//! Progress in writing the filter's parts.

use super::granules::Place;

/// Parts on their way into the flash.
#[derive(Clone, Copy)]
pub(super) struct WritingLearnt {
    /// Number of the model that is to follow.
    pub number: u32,
    /// Estimator's update from which the first part was written; numbers of another update do not fit to it.
    pub update: Option<u32>,
    pub part: u8,
    /// Place of the part in the buffer, its number of granules, and how many of them are programmed.
    pub place: Place,
    pub granules: u16,
    pub done: u16,
}
