//! Register map of the RM3100: PNI document 1017252 (r03), "RM3100 & RM2100 Sensor Suite User Manual", chapter 5.

/// Number of 7-bit addresses.
pub const COUNT: usize = 128;

/// Single measurement (section 5.3).
pub const POLL: u8 = 0x00;
/// Continuous measurement mode (section 5.2).
pub const CMM: u8 = 0x01;
/// First of the six cycle-count registers, high byte first, x, y, z (section 5.1).
pub const CCX1: u8 = 0x04;
/// Update rate of the continuous mode (section 5.2.1).
pub const TMRC: u8 = 0x0B;
/// First of the nine result registers, high byte first, x, y, z (section 5.5, table 5-8).
pub const MX2: u8 = 0x24;
/// Last of the nine result registers.
pub const MZ0: u8 = 0x2C;
/// Data ready in bit 7 (section 5.4.1).
pub const STATUS: u8 = 0x34;
/// Events that clear data ready (section 5.6.2).
pub const HSHAKE: u8 = 0x35;
/// Revision (section 5.6.3).
pub const REVID: u8 = 0x36;

/// Value of REVID.
pub const REVISION: u8 = 0x22;

/// CMM: bits of the axes x, y, z (table of section 5.2).
pub const CMM_AXES: [u8; 3] = [1 << 4, 1 << 5, 1 << 6];
/// CMM: continuous mode is on.
pub const START: u8 = 1;
/// POLL: bits of the axes x, y, z (section 5.3).
pub const POLL_AXES: [u8; 3] = [1 << 4, 1 << 5, 1 << 6];
/// STATUS: data ready.
pub const DRDY: u8 = 1 << 7;
/// HSHAKE: data ready is cleared by reading results, or by writing any register.
pub const DRC1: u8 = 1 << 1;
pub const DRC0: u8 = 1;

/// Value after power-up. Addresses that are not listed read 0.
pub const fn default_of(address: u8) -> u8 {
    match address {
        // 200 cycles (table 5-1).
        0x05 | 0x07 | 0x09 => 0xC8,
        TMRC => 0x96,
        HSHAKE => 0x1B,
        REVID => REVISION,
        _ => 0,
    }
}

/// Returns true if a write to the register changes anything.
pub const fn is_writable(address: u8) -> bool {
    matches!(address, 0x00..=0x01 | 0x04..=0x20 | 0x33 | HSHAKE)
}

/// Time between readings, nanoseconds, of a TMRC value (table 5-4, update rates 600 Hz halved with every step).
/// Values outside 0x92 to 0x9F are undefined: they act as the default, 0x96.
pub const fn period_ns(tmrc: u8) -> u64 {
    match tmrc {
        0x92 => 1_666_667,
        0x93 => 3_333_333,
        0x94 => 6_666_667,
        0x95 => 13_333_333,
        0x97 => 55_555_556,
        0x98 => 111_111_111,
        0x99 => 222_222_222,
        0x9A => 434_782_609,
        0x9B => 833_333_333,
        0x9C => 1_666_666_667,
        0x9D => 3_333_333_333,
        0x9E => 6_666_666_667,
        0x9F => 13_333_333_333,
        _ => 27_027_027,
    }
}

/// Conversion time of one axis, nanoseconds, by cycle count: table 3-1 has 1,600, 850 and 440 Hz of a single axis at
/// 50, 100 and 200 cycles, and a straight line through the first and last is within 1 % of the one between.
pub const fn axis_ns(cycles: u16) -> u64 {
    76_000 + 10_984 * cycles as u64
}

/// Gain, counts per microtesla, by cycle count: table 3-1 has 20, 38 and 75 at 50, 100 and 200 cycles; at others the
/// manufacturer's straight line.
pub fn gain_per_ut(cycles: u16) -> f32 {
    match cycles {
        50 => 20.0,
        100 => 38.0,
        200 => 75.0,
        _ => 0.3671 * f32::from(cycles) + 1.5,
    }
}
