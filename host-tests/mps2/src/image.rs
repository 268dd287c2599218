//! Start of the image: what runs after reset.

use crate::{lsm303dlhc::Magnetometer, sbcon::BitBangedI2c};
use semihosting::{eprintln, println, process};

/// After the stack pointer, which the linker script writes: reset, and the same for NMI and hard fault.
#[used]
// SAFETY: the linker script has the place for it, and nothing else goes there.
#[allow(unsafe_code)]
#[unsafe(link_section = ".vectors")]
static VECTORS: [unsafe extern "C" fn() -> !; 3] = [reset, fault, fault];

// SAFETY: the name is nobody else's.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
unsafe extern "C" fn reset() -> ! {
    // The compiler may move words through the floating-point unit: CPACR, full access to CP10 and CP11
    // (Armv7-M ARM, B3.2.20). SAFETY: one write to a register of the core, before anything else runs.
    unsafe { (0xE000_ED88 as *mut u32).write_volatile(0xF << 20) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    match measure() {
        Ok(()) => process::exit(0),
        Err(error) => {
            eprintln!("magnetometer: {error:?}");
            process::exit(1)
        }
    }
}

// SAFETY: it ends the program.
#[allow(unsafe_code)]
unsafe extern "C" fn fault() -> ! {
    eprintln!("magnetometer: fault");
    process::exit(1)
}

fn measure() -> Result<(), crate::sbcon::I2cError> {
    let mut magnetometer = Magnetometer::new(BitBangedI2c::take());
    let [a, b, c] = magnetometer.identification()?;
    println!("identification {a:02x} {b:02x} {c:02x}");
    magnetometer.start()?;
    let [x, y, z] = magnetometer.field_nt()?;
    println!("field {x} {y} {z}");
    // No part answers at another address: the bus reports so.
    println!("nobody {:?}", magnetometer.nobody_answers());
    Ok(())
}
