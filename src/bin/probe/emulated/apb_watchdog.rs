//! The MPS2's watchdog, a CMSDK APB watchdog, which the loader starts: an image that never gets as far as to feed it is
//! reset, whatever it does instead.

/// Load, control, clearing of the interrupt, lock (Arm Cortex-M System Design Kit TRM, DDI 0479, section 4.5).
const LOAD: *mut u32 = 0x4000_8000 as *mut u32;
const CONTROL: *mut u32 = 0x4000_8008 as *mut u32;
const INTCLR: *mut u32 = 0x4000_800C as *mut u32;
const LOCK: *mut u32 = 0x4000_8C00 as *mut u32;
const UNLOCKED: u32 = 0x1ACC_E551;
const INTERRUPT_AND_RESET: u32 = 0b11;
/// Two seconds at 25 MHz: the counter runs out once for the interrupt and once more for the reset.
const TICKS: u32 = 25_000_000;

/// Starts it. Whoever comes later cannot stop it, because it is locked.
#[allow(dead_code)] // The program only feeds it.
pub fn start() {
    write(LOCK, UNLOCKED);
    write(LOAD, TICKS);
    write(CONTROL, INTERRUPT_AND_RESET);
    write(LOCK, 0);
}

/// Restarts its time.
#[allow(dead_code)] // The loader does not feed it.
pub fn feed() {
    write(LOCK, UNLOCKED);
    write(INTCLR, 1);
    write(LOCK, 0);
}

#[allow(unsafe_code)]
fn write(register: *mut u32, value: u32) {
    // SAFETY: the callers pass registers of the watchdog, which take any word.
    unsafe { register.write_volatile(value) }
}
