use super::window_fit::WindowFit;
use crate::diagnosis::Diagnosis;
use core::mem::ManuallyDrop;

/// The memory of a fit and that of a diagnosis, which never run at the same time, in one place.
///
/// With a tag of its own, so that nothing to do is all zeros; as wide as what it stands before is aligned, for with padding after it a
/// variant is written by way of the stack.
#[expect(clippy::large_enum_variant, reason = "the variants share static memory")]
#[repr(u64)]
pub(super) enum Work {
    Nothing,
    // Nothing in either has to be dropped; with drop glue an assignment goes by way of the stack.
    Fit(ManuallyDrop<WindowFit>),
    Diagnosis(ManuallyDrop<Diagnosis>),
}

impl Work {
    // Constants of all zeros, so that they are written where they belong: the values would go by way of the stack.

    #[inline(never)]
    pub fn begin_fit(&mut self) {
        const FIT: ManuallyDrop<WindowFit> = ManuallyDrop::new(WindowFit::zero());
        if !matches!(self, Self::Fit(_)) {
            *self = Self::Fit(FIT);
        }
    }

    #[inline(never)]
    pub fn begin_diagnosis(&mut self) {
        const DIAGNOSIS: ManuallyDrop<Diagnosis> = ManuallyDrop::new(Diagnosis::zero());
        if !matches!(self, Self::Diagnosis(_)) {
            *self = Self::Diagnosis(DIAGNOSIS);
        }
    }
}
