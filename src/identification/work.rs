use super::window_fit::WindowFit;
use crate::diagnosis::Diagnosis;
use core::mem::ManuallyDrop;

/// The memory of a fit and that of a diagnosis, which never run at the same time, in one place.
///
/// With a tag of its own, so that nothing to do is all zeros.
#[expect(clippy::large_enum_variant, reason = "the variants share static memory")]
#[repr(u8)]
pub(super) enum Work {
    Nothing,
    // Nothing in either has to be dropped; with drop glue an assignment goes by way of the stack.
    Fit(ManuallyDrop<WindowFit>),
    Diagnosis(ManuallyDrop<Diagnosis>),
}

impl Work {
    // Functions of their own, so that the all-zero values are written where they belong and never stand on the stack.

    #[inline(never)]
    pub fn begin_fit(&mut self) {
        if !matches!(self, Self::Fit(_)) {
            *self = Self::Fit(ManuallyDrop::new(WindowFit::zero()));
        }
    }

    #[inline(never)]
    pub fn begin_diagnosis(&mut self) {
        if !matches!(self, Self::Diagnosis(_)) {
            *self = Self::Diagnosis(ManuallyDrop::new(Diagnosis::zero()));
        }
    }
}
