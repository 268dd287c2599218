//! Progress in writing the filter's parts.

use super::granules::Place;

/// Parts on their way into the flash.
#[derive(Clone, Copy)]
pub(super) struct WritingLearnt {
    /// Number of the model that is to follow.
    pub number: u32,
    /// Update that the first part's numbers are of; those of another one do not belong to it.
    pub update: Option<u32>,
    pub part: u8,
    /// Place of the part in the buffer, its granules, and those that are programmed.
    pub place: Place,
    pub granules: u16,
    pub done: u16,
}
