//! Device as RTIC requires it: its interrupts, and the number of bits of a priority. A vendor's chip has such a crate.

/// Bits of a priority of the MPS2's processor.
pub const NVIC_PRIO_BITS: u8 = 3;

/// The one interrupt that is used: RTIC runs its software tasks in it.
#[derive(Clone, Copy)]
#[allow(non_camel_case_types, clippy::upper_case_acronyms)]
pub enum Interrupt {
    UART0_RX = 0,
}

/// The name that RTIC looks for.
pub use self::Interrupt as interrupt;

// SAFETY: the number is that of its place in the vector table.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn UART0_RX();
}

/// The vector table behind the exceptions.
// SAFETY: the place and the name are those that cortex-m-rt asks for.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [unsafe extern "C" fn(); 1] = [UART0_RX];
