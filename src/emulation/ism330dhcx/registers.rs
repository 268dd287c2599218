//! Register map of the ISM330DHCX: data sheet DS13012, chapters "Register mapping" and "Register description" (each
//! register under its name, in order of address), and table "Mechanical characteristics".

/// Number of 7-bit addresses.
pub const COUNT: usize = 128;

pub const FIFO_CTRL1: u8 = 0x07;
pub const FIFO_CTRL2: u8 = 0x08;
pub const FIFO_CTRL3: u8 = 0x09;
pub const FIFO_CTRL4: u8 = 0x0A;
pub const INT1_CTRL: u8 = 0x0D;
pub const WHO_AM_I: u8 = 0x0F;
pub const CTRL1_XL: u8 = 0x10;
pub const CTRL2_G: u8 = 0x11;
pub const CTRL3_C: u8 = 0x12;
pub const CTRL10_C: u8 = 0x19;
pub const STATUS_REG: u8 = 0x1E;
pub const OUT_TEMP_L: u8 = 0x20;
pub const OUT_TEMP_H: u8 = 0x21;
pub const OUTX_L_G: u8 = 0x22;
pub const OUTZ_H_G: u8 = 0x27;
pub const OUTX_L_A: u8 = 0x28;
pub const OUTZ_H_A: u8 = 0x2D;
pub const FIFO_STATUS1: u8 = 0x3A;
pub const FIFO_STATUS2: u8 = 0x3B;
pub const TIMESTAMP0: u8 = 0x40;
pub const TIMESTAMP2: u8 = 0x42;
pub const TIMESTAMP3: u8 = 0x43;
pub const FIFO_DATA_OUT_TAG: u8 = 0x78;
pub const FIFO_DATA_OUT_Z_H: u8 = 0x7E;

/// Value of WHO_AM_I.
pub const IDENTIFICATION: u8 = 0x6B;

/// Bits of CTRL3_C.
pub const BOOT: u8 = 1 << 7;
pub const IF_INC: u8 = 1 << 2;
pub const SW_RESET: u8 = 1;
/// Bit of CTRL10_C.
pub const TIMESTAMP_EN: u8 = 1 << 5;
/// Bits of STATUS_REG.
pub const TDA: u8 = 1 << 2;
pub const GDA: u8 = 1 << 1;
pub const XLDA: u8 = 1;
/// Bit of FIFO_CTRL2.
pub const STOP_ON_WTM: u8 = 1 << 7;
/// Bits of FIFO_STATUS2.
pub const FIFO_WTM_IA: u8 = 1 << 7;
pub const FIFO_OVR_IA: u8 = 1 << 6;
pub const FIFO_FULL_IA: u8 = 1 << 5;
pub const FIFO_OVR_LATCHED: u8 = 1 << 3;
/// Bits of INT1_CTRL.
pub const INT1_FIFO_FULL: u8 = 1 << 5;
pub const INT1_FIFO_OVR: u8 = 1 << 4;
pub const INT1_FIFO_TH: u8 = 1 << 3;
pub const INT1_DRDY_G: u8 = 1 << 1;
pub const INT1_DRDY_XL: u8 = 1;

/// Value of a register after power-up or reset (table "Registers address map", column "default"). Addresses that are
/// not listed read 0.
pub const fn default_of(address: u8) -> u8 {
    match address {
        0x02 => 0x3F,
        WHO_AM_I => IDENTIFICATION,
        CTRL3_C => IF_INC,
        0x18 => 0xE0,
        _ => 0,
    }
}

/// Returns true if a write to the register changes anything (the same table, column "type").
pub const fn is_writable(address: u8) -> bool {
    matches!(address, 0x01..=0x02 | 0x07..=0x0E | 0x10..=0x19 | 0x56..=0x5F | 0x6F..=0x75)
}

/// Period of an output data rate field, nanoseconds; `None` is power-down (CTRL1_XL and CTRL2_G, ODR_XL and ODR_G,
/// high-performance mode; the codes of FIFO_CTRL3's batch rates up to 10 mean the same rates).
pub const fn period_ns(code: u8) -> Option<u64> {
    Some(match code {
        1 => 80_000_000,
        2 => 38_461_538,
        3 => 19_230_769,
        4 => 9_615_385,
        5 => 4_807_692,
        6 => 2_403_846,
        7 => 1_200_480,
        8 => 600_240,
        9 => 300_120,
        10 => 149_925,
        // "1.6 Hz (low-power mode)" of the accelerometer, 6.5 Hz as a batch rate of the gyro; not allowed for the gyro.
        11 => 625_000_000,
        _ => return None,
    })
}

/// Sensitivity of the accelerometer, milli-g per LSB, of the FS_XL field (LA_So; CTRL1_XL).
pub const fn accel_mg_lsb(ctrl1_xl: u8) -> f32 {
    match ctrl1_xl >> 2 & 3 {
        0 => 0.061,
        1 => 0.488,
        2 => 0.122,
        _ => 0.244,
    }
}

/// Sensitivity of the gyro, millidegrees per second and LSB, of CTRL2_G's range bits (G_So; CTRL2_G): FS_4000
/// overrides FS_125, which overrides FS_G.
pub const fn gyro_mdps_lsb(ctrl2_g: u8) -> f32 {
    if ctrl2_g & 1 != 0 {
        return 140.0;
    }
    if ctrl2_g & 2 != 0 {
        return 4.375;
    }
    match ctrl2_g >> 2 & 3 {
        0 => 8.75,
        1 => 17.5,
        2 => 35.0,
        _ => 70.0,
    }
}
