//! The log, in defmt's encoding, by semihosting into `log.bin`: the standard output is for what the program prints at
//! its end.

use core::cell::UnsafeCell;
use critical_section::RestoreState;
use defmt::{Encoder, Logger, global_logger};
use semihosting::{
    fs::{File, OpenOptions},
    io::{Seek, SeekFrom, Write},
};

#[global_logger]
struct Log;

struct State {
    encoder: Encoder,
    file: Option<File>,
    interrupts: RestoreState,
}

struct Shared(UnsafeCell<State>);

// SAFETY: one core, and its interrupts are masked from `acquire` to `release`, between which alone the state is
// touched.
#[allow(unsafe_code)]
unsafe impl Sync for Shared {}

static SHARED: Shared =
    Shared(UnsafeCell::new(State { encoder: Encoder::new(), file: None, interrupts: RestoreState::invalid() }));

/// Opens the file at its end: the log from before a reset stays. (QEMU takes no notice of a mode that appends.)
fn open() -> Option<File> {
    let mut file = OpenOptions::new().write(true).append(true).create(true).open(c"log.bin").ok()?;
    file.seek(SeekFrom::End(0)).ok()?;
    Some(file)
}

impl State {
    fn write(file: &mut Option<File>, bytes: &[u8]) {
        // A log that cannot be written is dropped: the probe flies on.
        let _ = file.as_mut().map(|file| file.write_all(bytes));
    }
}

// SAFETY: each is called in the order that the trait asks of the macros, with interrupts masked since `acquire`;
// nothing here logs.
#[allow(unsafe_code)]
unsafe impl Logger for Log {
    fn acquire() {
        // SAFETY: released in `release`; nobody else holds the state, for interrupts are masked and nothing that logs
        // is inside a log.
        let state = unsafe {
            let interrupts = critical_section::acquire();
            let state = &mut *SHARED.0.get();
            state.interrupts = interrupts;
            state
        };
        if state.file.is_none() {
            state.file = open();
        }
        let State { encoder, file, .. } = state;
        encoder.start_frame(|bytes| State::write(file, bytes));
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: between `acquire` and here the state is this context's alone.
        unsafe {
            let State { encoder, file, interrupts } = &mut *SHARED.0.get();
            encoder.end_frame(|bytes| State::write(file, bytes));
            critical_section::release(*interrupts);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: as above.
        let State { encoder, file, .. } = unsafe { &mut *SHARED.0.get() };
        encoder.write(bytes, |bytes| State::write(file, bytes));
    }
}
