//! Course of the filter since it last began: all that is forgotten when it begins anew, in one value.

use super::{
    alignment::Alignment, consistency::Consistency, disagreement::Disagreements, neighbours::Neighbours,
    pointing::Pointing, real::Real,
};

/// State since the filter began, beside what it has learnt.
pub(super) struct Course<T> {
    /// Unit of the field: its norm at the start, microtesla; 0: no field yet.
    pub field_unit: T,
    /// True if the node's states are aligned; `has_begun`: if they ever were.
    pub is_aligned: bool,
    pub has_begun: bool,
    pub alignment: Alignment<T>,
    pub neighbours: Neighbours<T>,
    pub pointing: Pointing<T>,
    /// Time at which the effects were last weighed, or of the first increment; `None` before it.
    pub weighed_us: Option<u64>,
    pub motion_s: T,
    /// Seconds in which the rotation of the probe was unknown, until the attitude is aligned anew.
    pub gap_s: T,
    /// Seconds since the globals last walked.
    pub unwalked_s: T,
    pub disagreements: Disagreements<T>,
    pub consistency: Consistency<T>,
    /// True if the hard iron is to be forgotten at the end of the node: it has changed.
    pub iron_has_changed: bool,
}

impl<T: Real> Course<T> {
    pub const fn zero() -> Self {
        Self {
            field_unit: T::ZERO,
            is_aligned: false,
            has_begun: false,
            alignment: Alignment::zero(),
            neighbours: Neighbours::none(),
            pointing: Pointing::zero(),
            weighed_us: None,
            motion_s: T::ZERO,
            gap_s: T::ZERO,
            unwalked_s: T::ZERO,
            disagreements: Disagreements::zero(),
            consistency: Consistency::zero(),
            iron_has_changed: false,
        }
    }

    /// Begins anew.
    pub fn begin(&mut self) {
        *self = Self::zero();
        self.alignment.start();
    }
}
