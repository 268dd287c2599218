//! Interface of a register-level model to a serial bus.

/// A part with 7-bit register addresses on a serial bus.
pub trait SerialPart {
    /// Begins a transaction: the chip is selected, or addressed, at `now_us`, microseconds.
    fn begin(&mut self, now_us: u64);

    /// Reads a register, with the side effects of that on the part.
    fn read(&mut self, address: u8) -> u8;

    /// Writes a register; one that cannot be written stays as it is.
    fn write(&mut self, address: u8, value: u8);

    /// Returns the address after this one within one transaction.
    fn following(&self, address: u8) -> u8;
}

/// Address pointer of a bus transaction.
///
/// ISM330DHCX and RM3100 share its protocol. SPI: the first byte is the register address with bit 7 set to read,
/// cleared to write, then data (ISM330DHCX DS13012, SPI interface; RM3100 manual section 4.4). I2C: the first byte
/// written is the address, and what follows is written or, after a repeated start, read (DS13012, I2C interface; RM3100
/// manual sections 4.5.1, 4.5.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Cursor {
    address: u8,
    addressed: bool,
    reads: bool,
}

impl Cursor {
    /// Creates the position of a transaction that has no address yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { address: 0, addressed: false, reads: false }
    }

    /// Shifts one byte out and one in, as SPI does.
    pub fn shift<P: SerialPart>(&mut self, part: &mut P, out: u8) -> u8 {
        if !self.addressed {
            *self = Self { address: out & 0x7F, addressed: true, reads: out & 0x80 != 0 };
            return 0;
        }
        let address = self.address;
        self.address = part.following(address) & 0x7F;
        if self.reads {
            part.read(address)
        } else {
            part.write(address, out);
            0
        }
    }

    /// Takes one byte written over I2C.
    pub fn receive<P: SerialPart>(&mut self, part: &mut P, byte: u8) {
        // Bit 7 of the sub-address has no meaning here: the direction is in the slave address.
        let out = if self.addressed { byte } else { byte & 0x7F };
        self.shift(part, out);
    }

    /// Returns one byte read over I2C.
    pub fn send<P: SerialPart>(&mut self, part: &mut P) -> u8 {
        let address = self.address;
        self.address = part.following(address) & 0x7F;
        part.read(address)
    }
}
