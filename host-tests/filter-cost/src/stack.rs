//! Stack use of a piece of work: the free stack is painted, and words that are no longer paint were used.

use cortex_m::register::msp;

/// Painted bytes: more than any filter here uses.
const PAINTED_BYTES: u32 = 8 * 1024;
/// Bytes of stack that painting itself may use.
const OWN_BYTES: u32 = 128;
const PAINT: u32 = 0xcccc_cccc;

/// Bytes of stack that `work` uses, with everything it calls.
#[inline(never)]
pub fn depth(work: impl FnOnce()) -> u32 {
    let top = msp::read();
    paint();
    work();
    top - deepest(top)
}

#[inline(never)]
fn paint() {
    let end = msp::read() - OWN_BYTES;
    for word in (end - PAINTED_BYTES..end).step_by(4) {
        // SAFETY: below the stack pointer nothing lives (no interrupt is enabled), and the chip's RAM reaches
        // further down than this.
        #[allow(unsafe_code)]
        unsafe {
            (word as *mut u32).write_volatile(PAINT);
        }
    }
}

/// The lowest word that is no longer paint.
fn deepest(top: u32) -> u32 {
    let mut words = (msp::read() - PAINTED_BYTES + 1024..top).step_by(4);
    words
        .find(|word| {
            // SAFETY: as above, and aligned; reading does no harm anywhere in RAM.
            #[allow(unsafe_code)]
            unsafe {
                (*word as *const u32).read_volatile() != PAINT
            }
        })
        .unwrap_or(top)
}
