//! A survey in ten bytes, for a mud pulser that takes a second or so for each bit, and its receiver at the surface.

mod quantity;
mod receiver;

pub use quantity::{DecodedQuantity, Quantity};
pub use receiver::{Expected, Received, SURVEY_WORD_BITS, SoftWord, SurveyReceiver, soft};

use crate::survey::{Grade, Survey, SurveyKind, ToolfaceKind, Uncertain};
use core::f32::consts::{FRAC_PI_2, PI};
use crc::{CRC_7_MMC, Crc, NoTable};

/// Length of a packed survey, bytes: 73 bits and a check of 7.
pub const SURVEY_WORD_BYTES: usize = 10;

/// Inclination, 12 bits: 0 to 180 deg in steps of 0.044 deg.
pub const INCLINATION: Quantity = Quantity::linear(12, 0.0, PI);
/// Magnetic azimuth, 12 bits: steps of 0.088 deg.
pub const AZIMUTH: Quantity = Quantity::whole_turn(12);
/// The toolface that applies, 9 bits: steps of 0.70 deg.
pub const TOOLFACE: Quantity = Quantity::whole_turn(9);
/// Total gravity, 8 bits: 9.6 to 10.0 m/s^2 in steps of 0.0016 m/s^2, under half of an accelerometer's bias
/// ([`SurveyErrors::accel_bias_m_s2`](crate::config::SurveyErrors)). The earth's own is within 9.76 to 9.84.
pub const GRAVITY_M_S2: Quantity = Quantity::linear(8, 9.6, 10.0);
/// Total field, 10 bits: 15 to 75 microtesla in steps of 0.059. The earth's own is within 22 and 67.
pub const FIELD_UT: Quantity = Quantity::linear(10, 15.0, 75.0);
/// Dip, 10 bits: -90 to 90 deg in steps of 0.18 deg.
pub const DIP: Quantity = Quantity::linear(10, -FRAC_PI_2, FRAC_PI_2);
/// Temperature, 7 bits: -40 to 208 degrees Celsius in steps of 2.
pub const TEMPERATURE_C: Quantity = Quantity::linear(7, -40.0, 208.0);

/// CRC-7 with x^7 + x^3 + 1, as on memory cards: the polynomial is primitive, so all errors of one or two bits in 127
/// are found, and all bursts of up to 7.
static CHECK: Crc<u8, NoTable> = Crc::<u8, NoTable>::new(&CRC_7_MMC);
const CHECK_BITS: u32 = 7;
/// Bits before the check.
const DATA_BITS: u32 = 73;
/// Distance in the content between bits that are neighbours on the line: a burst of errors then hits all quantities,
/// and a receiver that expects some of them notices. It is coprime to [`DATA_BITS`] and near 3/8 of it.
const STRIDE: u32 = 28;

/// Content of a packed survey.
///
/// Content from its most significant bit on: kind of survey (2 bits: 1 continuous, 2 stationary, 3 rotating), grade (2:
/// 0 not judged, 1 good, 2 doubtful, 3 bad), [`INCLINATION`], [`AZIMUTH`], toolface's kind (1: 0 gravity, 1 magnetic),
/// [`TOOLFACE`], [`GRAVITY_M_S2`], [`FIELD_UT`], [`DIP`], [`TEMPERATURE_C`]. On the line its bits come with a stride:
/// first the least significant one, then those 28, 56, 84 mod 73, .. places above it. The check of these 73 bits in
/// that order follows. A line that is stuck at 0 or at 1 gives no valid survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyWord {
    /// Kind of the survey.
    pub kind: SurveyKind,
    /// Grade; `None` if it was not judged.
    pub grade: Option<Grade>,
    /// Inclination, radians.
    pub inclination_rad: DecodedQuantity,
    /// Azimuth from magnetic north, radians.
    pub azimuth_rad: DecodedQuantity,
    /// Kind of the toolface.
    pub toolface_kind: ToolfaceKind,
    /// Toolface, radians.
    pub toolface_rad: DecodedQuantity,
    /// |G|, m/s^2.
    pub gravity_m_s2: DecodedQuantity,
    /// |B|, microtesla.
    pub field_ut: DecodedQuantity,
    /// Dip, radians below the horizon.
    pub dip_rad: DecodedQuantity,
    /// Temperature, degrees Celsius.
    pub temperature_c: DecodedQuantity,
}

/// Reason for which ten bytes are no survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum SurveyWordError {
    /// The check is wrong: bits were read wrong.
    Damaged,
    /// The check is right, but there is no such kind of survey.
    NoSurvey,
}

impl core::fmt::Display for SurveyWordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Damaged => "the survey word's check is wrong",
            Self::NoSurvey => "the survey word holds no survey",
        })
    }
}

impl core::error::Error for SurveyWordError {}

impl SurveyWord {
    /// Packs a survey. A value out of a quantity's range is marked as such, see [`DecodedQuantity`].
    #[must_use]
    pub fn pack(survey: &Survey, grade: Option<Grade>) -> [u8; SURVEY_WORD_BYTES] {
        let value = |x: Option<Uncertain>| x.map(|x| x.value);
        let kind = match survey.kind {
            SurveyKind::Continuous => 1,
            SurveyKind::Stationary => 2,
            SurveyKind::Rotating => 3,
        };
        let grade = match grade {
            None => 0,
            Some(Grade::Good) => 1,
            Some(Grade::Doubtful) => 2,
            Some(Grade::Bad) => 3,
        };
        let mut bits = Bits(0);
        bits.push(2, kind);
        bits.push(2, grade);
        bits.push_quantity(&INCLINATION, Some(survey.inclination_rad.value));
        bits.push_quantity(&AZIMUTH, value(survey.magnetic_azimuth_rad));
        bits.push(1, u16::from(survey.toolface_kind == ToolfaceKind::Magnetic));
        bits.push_quantity(&TOOLFACE, value(survey.toolface_rad()));
        bits.push_quantity(&GRAVITY_M_S2, value(survey.gravity_m_s2));
        bits.push_quantity(&FIELD_UT, value(survey.field_ut));
        bits.push_quantity(&DIP, value(survey.dip_rad));
        bits.push_quantity(&TEMPERATURE_C, survey.temperature_c);
        let mut bits = bits.spread();
        let check = CHECK.checksum(&bits.bytes());
        bits.push(CHECK_BITS, check.into());
        bits.bytes()
    }

    /// Unpacks a survey.
    ///
    /// # Errors
    /// The bytes were damaged, or hold no kind of survey.
    pub fn unpack(word: &[u8; SURVEY_WORD_BYTES]) -> Result<Self, SurveyWordError> {
        let mut bits = Bits::of(word);
        let check = bits.pop(CHECK_BITS);
        if u16::from(CHECK.checksum(&bits.bytes())) != check {
            return Err(SurveyWordError::Damaged);
        }
        let mut bits = bits.gathered();
        // Fields are popped in reverse order.
        let temperature_c = bits.pop_quantity(&TEMPERATURE_C);
        let dip_rad = bits.pop_quantity(&DIP);
        let field_ut = bits.pop_quantity(&FIELD_UT);
        let gravity_m_s2 = bits.pop_quantity(&GRAVITY_M_S2);
        let toolface_rad = bits.pop_quantity(&TOOLFACE);
        let toolface_kind = if bits.pop(1) == 1 { ToolfaceKind::Magnetic } else { ToolfaceKind::Gravity };
        let azimuth_rad = bits.pop_quantity(&AZIMUTH);
        let inclination_rad = bits.pop_quantity(&INCLINATION);
        let grade = match bits.pop(2) {
            1 => Some(Grade::Good),
            2 => Some(Grade::Doubtful),
            3 => Some(Grade::Bad),
            _ => None,
        };
        let kind = match bits.pop(2) {
            1 => SurveyKind::Continuous,
            2 => SurveyKind::Stationary,
            3 => SurveyKind::Rotating,
            _ => return Err(SurveyWordError::NoSurvey),
        };
        Ok(Self {
            kind,
            grade,
            inclination_rad,
            azimuth_rad,
            toolface_kind,
            toolface_rad,
            gravity_m_s2,
            field_ut,
            dip_rad,
            temperature_c,
        })
    }
}

/// Up to 80 bits; the last one pushed is the least significant.
struct Bits(u128);

impl Bits {
    fn of(word: &[u8; SURVEY_WORD_BYTES]) -> Self {
        Self(word.iter().fold(0, |bits, &byte| bits << 8 | u128::from(byte)))
    }

    /// Returns the content, reordered as it goes over the line.
    fn spread(&self) -> Self {
        Self((0..DATA_BITS).fold(0, |line, k| line << 1 | self.0 >> (STRIDE * k % DATA_BITS) & 1))
    }

    /// Returns the content of bits in the order of the line.
    fn gathered(&self) -> Self {
        let bit = |k: u32| (self.0 >> (DATA_BITS - 1 - k) & 1) << (STRIDE * k % DATA_BITS);
        Self((0..DATA_BITS).map(bit).fold(0, |content, bit| content | bit))
    }

    fn push(&mut self, count: u32, code: u16) {
        self.0 = self.0 << count | u128::from(code);
    }

    fn push_quantity(&mut self, quantity: &Quantity, value: Option<f32>) {
        self.push(quantity.bits(), quantity.code(value));
    }

    fn pop(&mut self, count: u32) -> u16 {
        let code = self.0 as u16 & ((1_u32 << count) - 1) as u16;
        self.0 >>= count;
        code
    }

    fn pop_quantity(&mut self, quantity: &Quantity) -> DecodedQuantity {
        let code = self.pop(quantity.bits());
        quantity.decode(code)
    }

    /// Returns the bits as ten bytes: leading zeros do not change a CRC that starts at zero.
    fn bytes(&self) -> [u8; SURVEY_WORD_BYTES] {
        let [.., a, b, c, d, e, f, g, h, i, j] = self.0.to_be_bytes();
        [a, b, c, d, e, f, g, h, i, j]
    }
}
