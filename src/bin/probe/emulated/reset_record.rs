//! A few words of RAM that the start-up code leaves alone: what the reset-cause register and the sensors' own clock are on a board.

use crate::application::board::ResetCause;

/// Says that the words are ours and not what happened to be there when power came.
const MAGIC: u32 = 0x6d77_6431;
const RUNNING: u32 = 0;
const WATCHDOG: u32 = 1;

struct Record {
    magic: u32,
    cause: u32,
    resets: u32,
    powered_rounds: u32,
}

#[allow(unsafe_code)]
// SAFETY: the section exists and is not initialised; all that is read from it are words, any of which is valid.
#[unsafe(link_section = ".uninit.reset_record")]
static mut RECORD: Record = Record { magic: 0, cause: 0, resets: 0, powered_rounds: 0 };

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
            // SAFETY: the offset is that of a field of the record the pointer came from.
            pub fn $name(record: *mut Record) -> *mut u32 {
                unsafe { &raw mut (*record).$name }
            }
        };
    }
    field!(magic);
    field!(cause);
    field!(resets);
    field!(powered_rounds);
}

/// Why the chip started; from then on a start is one without a known cause, until one is noted.
pub fn start() -> ResetCause {
    if words::read(words::magic) != MAGIC {
        words::write(words::magic, MAGIC);
        words::write(words::resets, 0);
        words::write(words::powered_rounds, 0);
        words::write(words::cause, RUNNING);
        return ResetCause::Power;
    }
    words::write(words::resets, resets().wrapping_add(1));
    let cause = words::read(words::cause);
    words::write(words::cause, RUNNING);
    if cause == WATCHDOG { ResetCause::Watchdog } else { ResetCause::Software }
}

/// The next start is the watchdog's.
pub fn note_watchdog() {
    words::write(words::cause, WATCHDOG);
}

/// Starts since power came.
pub fn resets() -> u32 {
    words::read(words::resets)
}

/// One more round of the sample clock; only its exception calls this.
pub fn count_powered_round() {
    words::write(words::powered_rounds, powered_rounds().wrapping_add(1));
}

/// Rounds of the sample clock since power came.
pub fn powered_rounds() -> u32 {
    words::read(words::powered_rounds)
}
