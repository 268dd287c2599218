//! Depth of the stack: the start-up code paints it, and memory without paint has been used.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::STACK_PAINT_VALUE;

#[allow(unsafe_code)]
mod symbols {
    // SAFETY: the linker script of `cortex-m-rt` defines both; only their addresses mean anything.
    unsafe extern "C" {
        /// The top of the stack, one past its highest byte.
        pub safe static _stack_start: u32;
        /// The end of the stack's memory: the lowest word it may use. Below it are static data, or nothing at all.
        pub safe static _stack_end: u32;
    }
}

/// Bytes at the end of the stack's memory that nothing may touch.
const GUARD: usize = 128;

/// Where the guard begins: a region has to be at a multiple of its size.
fn guard_start() -> usize {
    (&raw const symbols::_stack_end as usize).next_multiple_of(GUARD)
}

/// Makes an overflow of the stack a fault, before it overwrites memory below. Region 0 of the memory protection unit:
/// no access (Armv7-M reference manual, section B3.5).
pub fn guard(unit: &cortex_m::peripheral::MPU) {
    const NO_ACCESS_NO_EXECUTION: u32 = 1 << 28;
    const SIZE: u32 = GUARD.ilog2() - 1;
    const ENABLE: u32 = 1;
    const DEFAULT_MAP_FOR_THE_REST: u32 = 1 << 2;
    // SAFETY: only the last bytes of the stack's memory are closed, and nothing is there yet.
    #[allow(unsafe_code)]
    unsafe {
        unit.rnr.write(0);
        unit.rbar.write(guard_start() as u32);
        unit.rasr.write(NO_ACCESS_NO_EXECUTION | SIZE << 1 | ENABLE);
        unit.ctrl.write(DEFAULT_MAP_FOR_THE_REST | ENABLE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Words of paint in succession below which nothing was used: more than any function leaves untouched in its frame.
const UNUSED_WORDS: u32 = 1024;

/// Bytes of stack: the most used so far, and those that there are. If both are equal, the stack has reached the
/// guard. Only what lies below the mark of the call before is looked at: a whole stack takes milliseconds.
pub fn high_water_mark() -> [u32; 2] {
    static USED_BYTES: AtomicU32 = AtomicU32::new(0);
    let top = &raw const symbols::_stack_start as u32;
    let end = (guard_start() + GUARD) as u32;
    let mut deepest = top.saturating_sub(USED_BYTES.load(Ordering::Relaxed));
    let mut address = deepest;
    while address > end && deepest - address < UNUSED_WORDS * 4 {
        address -= 4;
        if !is_paint(address as *const u32) {
            deepest = address;
        }
    }
    USED_BYTES.store(top.saturating_sub(deepest), Ordering::Relaxed);
    [top.saturating_sub(deepest), top.saturating_sub(end)]
}

#[allow(unsafe_code)]
fn is_paint(word: *const u32) -> bool {
    // SAFETY: the caller stays, word by aligned word, in the stack's own RAM, which is always readable; a volatile
    // read tells the compiler nothing about the memory that it manages there.
    unsafe { word.read_volatile() == STACK_PAINT_VALUE }
}
