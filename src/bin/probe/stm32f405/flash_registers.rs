//! The flash's registers on the chip.

use super::flash::{self, Registers};
use crate::sample_clock::systick;
use stm32f4xx_hal::pac::FLASH;

pub type ModelFlash = flash::ModelFlash<FLASH>;
pub type FactoryFlash = flash::FactoryFlash<FLASH>;

/// Returns the registers once more, for the other of the two regions. Both are called by the main loop alone, and each
/// call leaves the flash locked.
pub fn again() -> FLASH {
    // SAFETY: no call of one region interrupts a call of the other.
    #[allow(unsafe_code)]
    unsafe {
        FLASH::steal()
    }
}

impl Registers for FLASH {
    fn control(&self) -> u32 {
        self.cr().read().bits()
    }

    fn set_control(&mut self, bits: u32) {
        // SAFETY: the driver sets bits that the register has, and never erases a sector with code.
        #[allow(unsafe_code)]
        self.cr().write(|w| unsafe { w.bits(bits) });
    }

    fn set_key(&mut self, key: u32) {
        // SAFETY: the register takes any word.
        #[allow(unsafe_code)]
        self.keyr().write(|w| unsafe { w.bits(key) });
    }

    fn status(&self) -> u32 {
        self.sr().read().bits()
    }

    fn clear_status(&mut self, bits: u32) {
        // SAFETY: a one clears an error, or does nothing.
        #[allow(unsafe_code)]
        self.sr().write(|w| unsafe { w.bits(bits) });
    }

    fn load(&self, address: usize) -> u8 {
        // SAFETY: the driver stays within the flash, which is always readable; volatile, for it changes behind the
        // compiler's back.
        #[allow(unsafe_code)]
        unsafe {
            (address as *const u8).read_volatile()
        }
    }

    fn store(&mut self, address: usize, word: u32) {
        // SAFETY: the address is an aligned word of the models' or the factory's sectors, in which there is no code;
        // the flash is unlocked for programming.
        #[allow(unsafe_code)]
        unsafe {
            (address as *mut u32).write_volatile(word);
        }
    }

    fn across_a_stall<R>(&mut self, erase: impl FnOnce(&mut Self) -> R) -> R {
        systick::across_a_stall(|| erase(self))
    }

    fn forget_cached(&mut self) {
        if self.acr().read().dcen().bit_is_set() {
            self.acr().modify(|_, w| w.dcen().clear_bit());
            self.acr().modify(|_, w| w.dcrst().set_bit());
            self.acr().modify(|_, w| w.dcrst().clear_bit());
            self.acr().modify(|_, w| w.dcen().set_bit());
        }
    }
}
