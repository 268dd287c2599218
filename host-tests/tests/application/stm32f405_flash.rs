//! The STM32F405's flash, at the worst of its data sheet, under the firmware's own driver.

#[allow(dead_code)] // The factory's region is not started here.
#[path = "../../../src/bin/probe/stm32f405/flash.rs"]
pub mod driver;

use driver::Registers;
use std::{cell::RefCell, rc::Rc};

/// The models' sectors, from sector 1 on.
const FIRST: usize = 0x0800_4000;
const SECTOR: usize = 16 * 1024;
const SECTORS: usize = 3;

/// Longest time to program a word, microseconds (DS8626, flash memory programming).
const WORD_US: u64 = 100;
/// Longest time to erase 16 KiB by the parallelism of 8, 16, 32 bits, microseconds (the same).
const ERASE_US: [u64; 3] = [800_000, 600_000, 500_000];

/// Registers and content.
pub struct Flash {
    bytes: Vec<u8>,
    control: u32,
    keys: Vec<u32>,
    errors: u32,
    /// Time that it has kept the processor waiting.
    pub now_us: u64,
    /// Parallelism of each erasure and of each word, bits.
    pub erased_by: Vec<u32>,
    pub programmed_by: Vec<u32>,
}

/// The flash for the driver, and the same for the test.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Flash>>);

impl Shared {
    /// Erased and locked.
    pub fn new() -> Self {
        Self(Rc::new(RefCell::new(Flash {
            bytes: vec![0xFF; SECTORS * SECTOR],
            control: 1 << 31,
            keys: vec![],
            errors: 0,
            now_us: 0,
            erased_by: vec![],
            programmed_by: vec![],
        })))
    }
}

impl Flash {
    const fn is_locked(&self) -> bool {
        self.control >> 31 == 1
    }

    /// Field PSIZE of the control register (RM0090 section 3.9.5): 8, 16 or 32 bits.
    const fn parallelism(&self) -> usize {
        (self.control >> 8 & 0b11) as usize
    }
}

impl Registers for Shared {
    fn control(&self) -> u32 {
        self.0.borrow().control
    }

    fn set_control(&mut self, bits: u32) {
        let mut flash = self.0.borrow_mut();
        assert!(!flash.is_locked(), "a locked register is written");
        // The start clears itself when the sector is erased.
        flash.control = bits & !(1 << 16);
        if bits >> 16 & 1 == 1 {
            assert_eq!(bits & 0b111, 0b010, "erases a sector, and programs nothing");
            let (sector, parallelism) = ((bits >> 3 & 0b1_1111) as usize, flash.parallelism());
            assert!((1..=SECTORS).contains(&sector), "sector {sector} is none of the models'");
            flash.bytes[(sector - 1) * SECTOR..][..SECTOR].fill(0xFF);
            flash.now_us += ERASE_US[parallelism];
            flash.erased_by.push(8 << parallelism);
        }
    }

    fn set_key(&mut self, key: u32) {
        let mut flash = self.0.borrow_mut();
        flash.keys.push(key);
        if flash.keys.ends_with(&[0x4567_0123, 0xCDEF_89AB]) {
            flash.control &= !(1 << 31);
        }
    }

    fn status(&self) -> u32 {
        self.0.borrow().errors
    }

    fn clear_status(&mut self, bits: u32) {
        self.0.borrow_mut().errors &= !bits;
    }

    fn load(&self, address: usize) -> u8 {
        self.0.borrow().bytes[address - FIRST]
    }

    fn store(&mut self, address: usize, word: u32) {
        let mut flash = self.0.borrow_mut();
        assert!(!flash.is_locked() && address.is_multiple_of(4));
        let parallelism = flash.parallelism();
        flash.programmed_by.push(8 << parallelism);
        if flash.control & 0b11 != 0b01 || parallelism != 2 {
            // Errors of sequence and of parallelism: a word was written, and none was to be programmed.
            flash.errors |= 1 << 7 | 1 << 6;
            return;
        }
        flash.now_us += WORD_US;
        for (byte, new) in flash.bytes[address - FIRST..][..4].iter_mut().zip(word.to_le_bytes()) {
            *byte &= new;
        }
    }

    fn forget_cached(&mut self) {}
}
