//! The magnetometer of ST's LSM303DLHC (data sheet DocID018771, section 7.2), in the style of the drivers of
//! the library.

use embedded_hal::i2c::I2c;

/// Its only address (section 5.1.2).
const ADDRESS: u8 = 0x1E;
/// Registers (section 7.2, table 17).
const CRA_REG_M: u8 = 0x00;
const CRB_REG_M: u8 = 0x01;
const MR_REG_M: u8 = 0x02;
const OUT_X_H_M: u8 = 0x03;
const IRA_REG_M: u8 = 0x0A;
/// 1.3 gauss (CRB_REG_M, table 75): 1,100 LSB per gauss on x and y, 980 on z. A gauss is 100,000 nT.
const RANGE_1_3_GAUSS: u8 = 1 << 5;
const LSB_PER_GAUSS: [i32; 3] = [1_100, 1_100, 980];
const NT_PER_GAUSS: i32 = 100_000;
/// 220 Hz (CRA_REG_M, table 72).
const RATE_220_HZ: u8 = 7 << 2;
const CONTINUOUS: u8 = 0;

pub struct Magnetometer<I> {
    i2c: I,
}

impl<I: I2c> Magnetometer<I> {
    pub const fn new(i2c: I) -> Self {
        Self { i2c }
    }

    pub fn identification(&mut self) -> Result<[u8; 3], I::Error> {
        let mut bytes = [0; 3];
        self.i2c.write_read(ADDRESS, &[IRA_REG_M], &mut bytes)?;
        Ok(bytes)
    }

    pub fn start(&mut self) -> Result<(), I::Error> {
        self.i2c.write(ADDRESS, &[CRA_REG_M, RATE_220_HZ])?;
        self.i2c.write(ADDRESS, &[CRB_REG_M, RANGE_1_3_GAUSS])?;
        self.i2c.write(ADDRESS, &[MR_REG_M, CONTINUOUS])
    }

    /// Field along x, y and z, nanotesla. The registers' order is x, z, y, high byte first (section 7.2.4).
    pub fn field_nt(&mut self) -> Result<[i32; 3], I::Error> {
        let mut bytes = [0; 6];
        self.i2c.write_read(ADDRESS, &[OUT_X_H_M], &mut bytes)?;
        let [xh, xl, zh, zl, yh, yl] = bytes;
        let code = |high, low| i32::from(i16::from_be_bytes([high, low]));
        let [x, y, z] = [code(xh, xl), code(yh, yl), code(zh, zl)];
        let [per_x, per_y, per_z] = LSB_PER_GAUSS;
        Ok([x * NT_PER_GAUSS / per_x, y * NT_PER_GAUSS / per_y, z * NT_PER_GAUSS / per_z])
    }

    /// True if an address that no part has stays unacknowledged.
    pub fn nobody_answers(&mut self) -> bool {
        self.i2c.write(ADDRESS ^ 0x40, &[0]).is_err()
    }
}
