//! The chip's side: reset, choice, copy, jump.

#[path = "../../../src/bin/probe/emulated/apb_watchdog.rs"]
mod apb_watchdog;
#[path = "../../../src/bin/probe/emulated/images.rs"]
mod images;

use cortex_m::peripheral::SCB;
use images::{Images, REGION};
use meerkat_mwd::storage::{ImageSlots, Start};
use semihosting::{eprintln, process};

/// Where the program is linked, and the bytes that it may take.
const PROGRAM: usize = 0x0001_0000;
const PROGRAM_BYTES: usize = REGION / 2;
/// RAM of the program, in which its stack begins.
const RAM: core::ops::RangeInclusive<usize> = 0x2000_0000..=0x2030_0000;

/// After the stack pointer, which the linker script writes: reset, and the same for all faults.
#[used]
// SAFETY: the linker script has the place for it, and nothing else goes there.
#[allow(unsafe_code)]
#[unsafe(link_section = ".vectors")]
static VECTORS: [unsafe extern "C" fn() -> !; 6] = [reset, fault, fault, fault, fault, fault];

// SAFETY: the name is nobody else's.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
unsafe extern "C" fn reset() -> ! {
    // CPACR, full access to CP10 and CP11 (Armv7-M ARM, B3.2.20). SAFETY: one write to a register of the core, before
    // anything else runs.
    unsafe {
        (0xE000_ED88 as *mut u32).write_volatile(0xF << 20);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    load()
}

// SAFETY: it ends the program.
#[allow(unsafe_code)]
unsafe extern "C" fn fault() -> ! {
    fail("a fault of the loader")
}

#[inline(never)]
fn load() -> ! {
    let Some(images) = Images::open() else { fail("images.bin cannot be opened") };
    let Ok(mut slots) = ImageSlots::new(images) else { fail("images.bin is not of two slots") };
    let Some(start) = slots.choose() else { fail("there is no whole image") };
    let slot = start.slot();
    let address = slots.address(slot);
    let image = slots.flash_mut().mapped(address);
    let image = image.get(..PROGRAM_BYTES).unwrap_or(image);
    if !is_program(image) {
        match start {
            // It counts as tried, and the next start takes the other one.
            Start::Trial(_) => SCB::sys_reset(),
            _ => fail("the image is no program"),
        }
    }
    images::start(slot);
    apb_watchdog::start();
    // SAFETY: the loader's own code and data are elsewhere, and what is copied has a vector table.
    #[allow(unsafe_code)]
    unsafe {
        core::ptr::copy_nonoverlapping(image.as_ptr(), PROGRAM as *mut u8, image.len());
        (*SCB::PTR).vtor.write(PROGRAM as u32);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        cortex_m::asm::bootload(PROGRAM as *const u32)
    }
}

/// Returns true if a stack pointer into RAM and an entry into the image stand at its beginning.
fn is_program(image: &[u8]) -> bool {
    let word =
        |at: usize| image.get(at..).and_then(|bytes| bytes.first_chunk()).map(|bytes| u32::from_le_bytes(*bytes));
    let (Some(stack), Some(entry)) = (word(0), word(4)) else { return false };
    RAM.contains(&(stack as usize))
        && stack.is_multiple_of(8)
        && entry % 2 == 1
        && (PROGRAM..PROGRAM + PROGRAM_BYTES).contains(&(entry as usize))
}

fn fail(why: &str) -> ! {
    eprintln!("{why}");
    process::exit(1)
}
