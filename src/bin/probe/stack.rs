//! Depth of the stack: the start-up code paints it, and memory without paint has been used.

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

/// Bytes of stack: the most used so far, and those that there are. If both are equal, the stack has reached the
/// guard.
pub fn high_water_mark() -> [u32; 2] {
    let top = &raw const symbols::_stack_start;
    let mut deepest = (guard_start() + GUARD) as *const u32;
    let size_bytes = (top as u32).saturating_sub(deepest as u32);
    while deepest < top && is_paint(deepest) {
        deepest = deepest.wrapping_add(1);
    }
    let used_bytes = (top as u32).saturating_sub(deepest as u32);
    [used_bytes, size_bytes]
}

#[allow(unsafe_code)]
fn is_paint(word: *const u32) -> bool {
    // SAFETY: the caller stays, word by aligned word, in the stack's own RAM, which is always readable; a volatile
    // read tells the compiler nothing about the memory that it manages there.
    unsafe { word.read_volatile() == STACK_PAINT_VALUE }
}
