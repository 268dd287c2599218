//! Faults that no stage comes back from: noted for the next start, then reset.

use crate::reset_record::{Asked, reset};
use core::{
    panic::PanicInfo,
    sync::atomic::{AtomicBool, Ordering},
};
use cortex_m_rt::{ExceptionFrame, exception};
// The logger.
use defmt_rtt as _;

/// True after the first fault: the logger may be what failed, and asked again it would fail again without end.
static HAS_FAILED: AtomicBool = AtomicBool::new(false);

fn may_log() -> bool {
    !HAS_FAILED.swap(true, Ordering::Relaxed)
}

// Inlined into its callers, the handler leaves the panic's text, which it does not print, unmade, and `core::fmt` not
// linked: 2.3 KiB less. (The compiler holds that the attribute does nothing.)
#[allow(unused_attributes)]
#[inline(always)]
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    if let Some(location) = info.location().filter(|_| may_log()) {
        defmt::error!("panic at {=str}:{=u32}", location.file(), location.line());
    }
    reset(Asked::Fault)
}

// SAFETY: it only reports and resets; it returns to no faulted code.
#[allow(unsafe_code)]
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    if may_log() {
        defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    }
    reset(Asked::Fault)
}

/// Resets a program that cannot start, for the reason `why`.
pub fn stop(why: &'static str) -> ! {
    defmt::error!("{=str}", why);
    reset(Asked::Fault)
}
