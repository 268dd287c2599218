//! Progress in writing the filter's parts.

use super::programming::Programming;

/// Parts on their way into the flash.
#[derive(Clone, Copy)]
pub(super) struct WritingLearnt {
    /// Number of the model that is to follow.
    pub number: u32,
    /// Estimator's update from which the first part was written; numbers of another update do not fit to it.
    pub update: Option<u32>,
    pub part: u8,
    /// Part in the buffer.
    pub record: Programming,
}
