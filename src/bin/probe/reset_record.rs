//! A few words of RAM that the start-up code leaves alone: why a program asked for its reset.

use meerkat_mwd::telemetry::ResetReason;

/// Mark that the words were written by this program, and are not random content from power-up.
const MAGIC: u32 = 0x6d77_6431;

/// Why a program asks for a reset.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Asked {
    Nobody = 0,
    #[cfg(feature = "board-emulated")]
    Watchdog = 1,
    #[cfg(not(feature = "board-emulated"))]
    Fault = 2,
}

struct Record {
    magic: u32,
    asked: u32,
    resets: u32,
    watchdog_resets: u32,
    #[cfg(feature = "board-emulated")]
    powered_rounds: u32,
}

// SAFETY: the section exists and is not initialised; all that is read from it are words, any of which is valid.
#[allow(unsafe_code)]
#[unsafe(link_section = ".uninit.reset_record")]
static mut RECORD: Record = Record {
    magic: 0,
    asked: 0,
    resets: 0,
    watchdog_resets: 0,
    #[cfg(feature = "board-emulated")]
    powered_rounds: 0,
};

#[allow(unsafe_code)]
mod words {
    use super::{RECORD, Record};

    pub fn read(field: impl FnOnce(*mut Record) -> *mut u32) -> u32 {
        // SAFETY: the pointer is to an aligned word of a static; one core, and words are read and written whole.
        unsafe { field(&raw mut RECORD).read_volatile() }
    }

    pub fn write(field: impl FnOnce(*mut Record) -> *mut u32, value: u32) {
        // SAFETY: as above.
        unsafe { field(&raw mut RECORD).write_volatile(value) }
    }

    macro_rules! field {
        ($name:ident) => {
            pub fn $name(record: *mut Record) -> *mut u32 {
                // SAFETY: the offset is that of a field of the record that the pointer came from.
                unsafe { &raw mut (*record).$name }
            }
        };
    }
    field!(magic);
    field!(asked);
    field!(resets);
    field!(watchdog_resets);
    #[cfg(feature = "board-emulated")]
    field!(powered_rounds);
}

/// Takes the reason that a program noted before this start; `None` if power came since, or no program noted one. It
/// is then forgotten. `has_power_come`: by the chip's own flags, for its memory may outlast a short loss.
pub fn start(has_power_come: bool) -> Option<ResetReason> {
    if has_power_come || words::read(words::magic) != MAGIC {
        words::write(words::magic, MAGIC);
        words::write(words::resets, 0);
        words::write(words::watchdog_resets, 0);
        #[cfg(feature = "board-emulated")]
        words::write(words::powered_rounds, 0);
        words::write(words::asked, Asked::Nobody as u32);
        return None;
    }
    words::write(words::resets, resets().wrapping_add(1));
    let asked = words::read(words::asked);
    words::write(words::asked, Asked::Nobody as u32);
    #[cfg(feature = "board-emulated")]
    if asked == Asked::Watchdog as u32 {
        count_watchdog_reset();
        return Some(ResetReason::Watchdog);
    }
    #[cfg(not(feature = "board-emulated"))]
    if asked == Asked::Fault as u32 {
        return Some(ResetReason::Fault);
    }
    None
}

/// Asks for a reset.
pub fn reset(why: Asked) -> ! {
    words::write(words::asked, why as u32);
    cortex_m::peripheral::SCB::sys_reset()
}

/// Resets since power came.
pub fn resets() -> u32 {
    words::read(words::resets)
}

/// Resets by the watchdog since power came.
pub fn watchdog_resets() -> u32 {
    words::read(words::watchdog_resets)
}

/// Counts a reset by the watchdog.
pub fn count_watchdog_reset() {
    words::write(words::watchdog_resets, watchdog_resets().wrapping_add(1));
}

/// Counts a round of the sample clock; only its exception calls this.
#[cfg(feature = "board-emulated")]
pub fn count_powered_round() {
    words::write(words::powered_rounds, powered_rounds().wrapping_add(1));
}

/// Rounds of the sample clock since power came: the emulated sensors' place in their recording.
#[cfg(feature = "board-emulated")]
pub fn powered_rounds() -> u32 {
    words::read(words::powered_rounds)
}
