//! The chip's side: reset, and the run of a tier over the samples of a file, by semihosting.

use crate::{Digest, RECORD, STATION, Tier, analysed_run, by_hand, digest_of, unpack, unpack_station};
// Its critical section, where a processor has no atomic exchange.
#[cfg(target_arch = "arm")]
use cortex_m as _;
use meerkat_mwd::survey::multi_station::MultiStation;
use semihosting::{eprintln, fs::File, io::Read, println, process};

/// Value painted into a word of the stack: a word that still holds it is unused.
const PAINT: u32 = 0xA5A5_5A5A;
/// Stack below the caller that is not painted, words.
const IN_USE: usize = 64;

#[allow(unsafe_code)]
unsafe extern "C" {
    static mut _data_start: u32;
    static _data_end: u32;
    static _data_image: u32;
    static mut _stack_end: u32;
    static _stack_top: u32;
    /// The image's program.
    fn tier() -> !;
}

/// After the stack pointer, which the linker script writes: reset, and the same for all faults.
#[cfg(target_arch = "arm")]
#[used]
// SAFETY: the linker script has the place for it, and nothing else goes there.
#[allow(unsafe_code)]
#[unsafe(link_section = ".vectors")]
static VECTORS: [unsafe extern "C" fn() -> !; 6] = [reset, fault, fault, fault, fault, fault];

/// A RISC-V has no stack pointer after reset. No machine runs this image yet: it is linked, and held to its memory.
#[cfg(target_arch = "riscv32")]
#[allow(unsafe_code)]
mod start {
    core::arch::global_asm!(".section .vectors, \"ax\"", ".global _start", "_start:", "la sp, _stack_top", "j reset");
}

/// The stack pointer.
#[allow(unsafe_code)]
fn stack_pointer() -> *mut u32 {
    let pointer: *mut u32;
    // SAFETY: it reads a register.
    #[cfg(target_arch = "arm")]
    unsafe {
        core::arch::asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack));
    }
    // SAFETY: the same.
    #[cfg(target_arch = "riscv32")]
    unsafe {
        core::arch::asm!("mv {}, sp", out(reg) pointer, options(nomem, nostack));
    }
    pointer
}

// SAFETY: the name is nobody else's.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
unsafe extern "C" fn reset() -> ! {
    // CPACR, full access to CP10 and CP11 (Armv7-M ARM, B3.2.20). SAFETY: one write to a register of the core, before
    // anything else runs.
    #[cfg(target_abi = "eabihf")]
    unsafe {
        (0xE000_ED88 as *mut u32).write_volatile(0xF << 20);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
    // SAFETY: the linker script says from where to where initial values go.
    unsafe {
        let (mut to, mut from) = (&raw mut _data_start, &raw const _data_image);
        while to.cast_const() < &raw const _data_end {
            to.write_volatile(from.read_volatile());
            (to, from) = (to.add(1), from.add(1));
        }
    }
    // SAFETY: from the end of the statics to below this frame nobody has a word. The emulator's RAM is zero at the
    // start, so that .bss needs no clearing.
    unsafe {
        let mut word = &raw mut _stack_end;
        let end = stack_pointer().wrapping_sub(IN_USE);
        while word < end {
            word.write_volatile(PAINT);
            word = word.add(1);
        }
        tier()
    }
}

// SAFETY: it ends the program.
#[cfg(target_arch = "arm")]
#[allow(unsafe_code)]
unsafe extern "C" fn fault() -> ! {
    eprintln!("a fault");
    process::exit(1)
}

/// Bytes of stack that were used at any time.
#[allow(unsafe_code)]
fn stack_used() -> usize {
    // SAFETY: addresses of the linker script; reading a word of RAM harms nothing.
    unsafe {
        let mut word = &raw const _stack_end;
        let top = &raw const _stack_top;
        while word < top && word.read_volatile() == PAINT {
            word = word.add(1);
        }
        top.byte_offset_from_unsigned(word)
    }
}

/// Flies the samples of `samples.bin`: the sample period in microseconds (4 bytes), then the samples.
pub fn run(tier: &mut impl Tier) -> ! {
    let Ok(mut file) = File::open(c"samples.bin") else { fail("samples.bin cannot be opened") };
    let mut period = [0; 4];
    if !fill(&mut file, &mut period) || !configure(tier, u32::from_le_bytes(period)) {
        fail("no sample period that can be used");
    }
    let (mut digest, mut record, mut number) = (Digest::default(), [0; RECORD], 0_u32);
    while fill(&mut file, &mut record) {
        push(tier, &record, &mut digest);
        number += 1;
    }
    println!("{number} {} {} {}", digest.number(), tier.results(), stack_used());
    process::exit(0)
}

/// Analyses the stations of `stations.bin`, and says how many count, a digest, and the stack.
pub fn run_stations(stations: &mut MultiStation) -> ! {
    let Ok(mut file) = File::open(c"stations.bin") else { fail("stations.bin cannot be opened") };
    let mut record = [0; STATION];
    while fill(&mut file, &mut record) {
        if stations.push(unpack_station(&record)).is_err() {
            fail("a station cannot be used");
        }
    }
    let Some(report) = analysed_run(stations) else { fail("no analysis") };
    let digest = digest_of(&report, stations.stations());
    println!("{} {digest} {} {}", stations.stations().len(), report.counted, stack_used());
    process::exit(0)
}

/// Apart from the loop, whose frame lies under all work.
#[inline(never)]
fn configure(tier: &mut impl Tier, period_us: u32) -> bool {
    tier.configure(&by_hand(period_us))
}

/// As [`configure`].
#[inline(never)]
fn push(tier: &mut impl Tier, record: &[u8; RECORD], digest: &mut Digest) {
    if let Some(output) = tier.push(&unpack(record)) {
        digest.take(&output);
    }
}

/// Reads until the buffer is full; false at the end of the file.
fn fill(file: &mut File, buffer: &mut [u8]) -> bool {
    let mut rest = buffer;
    while !rest.is_empty() {
        match file.read(rest) {
            Ok(read) if read > 0 => rest = rest.get_mut(read..).unwrap_or_default(),
            _ => return false,
        }
    }
    true
}

fn fail(why: &str) -> ! {
    eprintln!("{why}");
    process::exit(1)
}
