//! A part on its bus, with its clock, as a test plays it.

use embedded_hal::{i2c::I2c, spi::SpiDevice};
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, Ism330dhcx, OnI2c, OnSpi, Rm3100, SerialPart},
};
use std::cell::{Cell, RefCell};

pub struct Wired<P> {
    pub part: RefCell<P>,
    pub now_us: Cell<u64>,
}

impl Wired<Ism330dhcx> {
    pub fn ism330dhcx(conversions: Conversions) -> Self {
        Self { part: RefCell::new(Ism330dhcx::new(conversions)), now_us: Cell::new(0) }
    }

    pub fn play(&self, sample: &Sample) {
        self.now_us.set(sample.t_us);
        self.part.borrow_mut().play(sample);
    }
}

impl Wired<Rm3100> {
    pub fn rm3100(conversions: Conversions) -> Self {
        Self { part: RefCell::new(Rm3100::new(conversions)), now_us: Cell::new(0) }
    }

    pub fn play(&self, sample: &Sample) {
        self.now_us.set(sample.t_us);
        self.part.borrow_mut().play(sample);
    }
}

impl<P: SerialPart> Wired<P> {
    pub fn read<const N: usize>(&self, address: u8) -> [u8; N] {
        let mut bytes = [0; N];
        OnSpi::new(&self.part, &self.now_us)
            .transaction(&mut [
                embedded_hal::spi::Operation::Write(&[0x80 | address]),
                embedded_hal::spi::Operation::Read(&mut bytes),
            ])
            .unwrap();
        bytes
    }

    pub fn byte(&self, address: u8) -> u8 {
        self.read::<1>(address)[0]
    }

    pub fn write(&self, address: u8, bytes: &[u8]) {
        let sent: Vec<u8> = std::iter::once(address).chain(bytes.iter().copied()).collect();
        OnSpi::new(&self.part, &self.now_us).write(&sent).unwrap();
    }

    pub fn read_i2c<const N: usize>(&self, at: u8, address: u8) -> [u8; N] {
        let mut bytes = [0; N];
        OnI2c::new(&self.part, &self.now_us, at).write_read(at, &[address], &mut bytes).unwrap();
        bytes
    }
}

/// Three words, low byte first.
pub fn words(bytes: &[u8]) -> [i16; 3] {
    [0, 2, 4].map(|at| i16::from_le_bytes([bytes[at], bytes[at + 1]]))
}
