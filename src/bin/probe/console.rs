//! Console of the emulated boards, through semihosting, and their exit. Words and whole numbers only: `core::fmt`
//! would take four kilobytes of flash for these few lines.

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::{
    io::{self, Write},
    process,
};

/// A part of a line.
pub enum Word<'a> {
    Text(&'a str),
    Number(u64),
}

/// Prints a line to the standard output.
pub fn print(words: &[Word<'_>]) {
    if let Ok(mut out) = io::stdout() {
        write(&mut out, words);
    }
}

/// Prints a line to the standard error, with the program's name.
pub fn complain(words: &[Word<'_>]) {
    if let Ok(mut out) = io::stderr() {
        // A line that cannot be written is dropped.
        let _ = out.write(b"probe: ");
        write(&mut out, words);
    }
}

#[inline(never)]
fn write(out: &mut impl Write, words: &[Word<'_>]) {
    for word in words {
        let mut digits = [0; 20];
        let bytes = match word {
            Word::Text(text) => text.as_bytes(),
            Word::Number(number) => in_digits(*number, &mut digits),
        };
        let _ = out.write(bytes);
    }
    let _ = out.write(b"\n");
}

/// A number's digits, at the end of `digits`.
fn in_digits(mut number: u64, digits: &mut [u8; 20]) -> &[u8] {
    let mut used = 0;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (number % 10) as u8;
        number /= 10;
        used += 1;
        if number == 0 {
            break;
        }
    }
    digits.split_at_checked(digits.len() - used).map_or(&[], |(_, written)| written)
}

// Inlined into its callers, the handler leaves the panic's text, which it does not print, unmade, and `core::fmt` not
// linked: 2.3 KiB less. (The compiler holds that the attribute does nothing.)
#[allow(unused_attributes)]
#[inline(always)]
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    if let Some(location) = info.location() {
        let line = Word::Number(location.line().into());
        complain(&[Word::Text("panic at "), Word::Text(location.file()), Word::Text(":"), line]);
    }
    process::exit(1)
}

// SAFETY: it only reports and ends the program; it returns to no faulted code.
#[allow(unsafe_code)]
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    complain(&[Word::Text("hard fault at "), Word::Number(frame.pc().into())]);
    process::exit(1)
}
