//! Receiver of survey words. The reference of the earth, the last station and repetitions back up the check of seven
//! bits.
//!
//! The check lets 0.6 % of random words pass. Few of those have the place's gravity, field and dip, and a direction
//! that a hole can have after the last station's. A word outside these ranges may still be true: a magnet is near, or a
//! station was left out. It is reported as doubted, until the same word comes again. Repetitions of a damaged word are
//! added up, bit by bit.

use super::{DecodedQuantity, SURVEY_WORD_BYTES, SurveyWord, SurveyWordError};
use crate::config::{Earth, SurveyLimits};
use core::f32::consts::TAU;

/// Bits of a word.
pub const SURVEY_WORD_BITS: usize = 8 * SURVEY_WORD_BYTES;

/// Evidence for each bit of a word, the first bit of the first byte first: over 0 for a 1, under 0 for a 0, 0 for a bit
/// of which nothing is known. Larger magnitudes are stronger evidence; a decoder that knows only bits gives 1 and -1.
pub type SoftWord = [i8; SURVEY_WORD_BITS];

/// Returns the evidence of a word of which only the bits are known.
#[must_use]
pub fn soft(word: &[u8; SURVEY_WORD_BYTES]) -> SoftWord {
    let mut soft = [0; SURVEY_WORD_BITS];
    for (byte, bits) in word.iter().zip(soft.chunks_exact_mut(8)) {
        for (k, bit) in bits.iter_mut().enumerate() {
            *bit = if byte >> (7 - k) & 1 == 1 { 1 } else { -1 };
        }
    }
    soft
}

/// Range in which a received word is plausible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Gravity, field and dip of the place; those that are `None` are not checked.
    pub earth: Earth,
    /// Limits of the differences from `earth`; beyond `bad_over_limit` times a limit, plus the step of the quantity, a
    /// word is doubted.
    pub limits: SurveyLimits,
    /// Largest turn of the hole since the last station, radians: its spacing by the dogleg that the assembly can make.
    pub turn_rad: f32,
    /// True if every survey has to come twice, not only one that does not look as expected.
    pub twice: bool,
}

/// Received survey.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum Received {
    /// Accepted survey: it is as expected, or came twice.
    Survey(SurveyWord),
    /// The check is right, but the survey does not look as expected: ask for another.
    Doubted(SurveyWord),
}

/// Receiver of survey words.
pub struct SurveyReceiver {
    expected: Expected,
    /// Direction of the last station: inclination and azimuth.
    last_rad: Option<[f32; 2]>,
    sums: [i16; SURVEY_WORD_BITS],
    words: u16,
    doubted: Option<[u8; SURVEY_WORD_BYTES]>,
}

impl SurveyReceiver {
    /// Returns a receiver that knows no station yet.
    #[must_use]
    pub const fn new(expected: Expected) -> Self {
        Self { expected, last_rad: None, sums: [0; SURVEY_WORD_BITS], words: 0, doubted: None }
    }

    /// Sets the range of the next words, for instance when another spacing of stations allows another turn.
    pub const fn expect(&mut self, expected: Expected) {
        self.expected = expected;
    }

    /// Begins the next survey: earlier words are forgotten, as the next ones do not repeat them.
    pub const fn begin(&mut self) {
        self.sums = [0; SURVEY_WORD_BITS];
        self.words = 0;
        self.doubted = None;
    }

    /// Takes a word. Words up to the next [`SurveyReceiver::begin`] are taken for repetitions of one survey.
    ///
    /// # Errors
    /// Neither the word nor the sum of the repetitions is a survey.
    pub fn push(&mut self, word: &SoftWord) -> Result<Received, SurveyWordError> {
        for (sum, bit) in self.sums.iter_mut().zip(word) {
            *sum = sum.saturating_add((*bit).into());
        }
        self.words = self.words.saturating_add(1);
        let alone = self.judge(hard(word.iter().map(|bit| i16::from(*bit))), true);
        if self.words < 2 || matches!(alone, Ok(Received::Survey(_))) {
            return alone;
        }
        let together = self.judge(hard(self.sums.iter().copied()), false);
        match (&together, &alone) {
            (Ok(Received::Survey(_)), _) | (Ok(_), Err(_)) => together,
            _ => alone,
        }
    }

    /// Judges a word. A sum contains the words before it, so that only a single word (`own`) confirms a doubted one.
    fn judge(&mut self, bits: [u8; SURVEY_WORD_BYTES], own: bool) -> Result<Received, SurveyWordError> {
        let survey = SurveyWord::unpack(&bits)?;
        let confirmed = own && self.doubted == Some(bits);
        if !confirmed && (self.expected.twice || !self.is_expected(&survey)) {
            self.doubted = Some(bits);
            return Ok(Received::Doubted(survey));
        }
        if let DecodedQuantity::Value(inclination) = survey.inclination_rad {
            self.last_rad = match survey.azimuth_rad {
                DecodedQuantity::Value(azimuth) => Some([inclination, azimuth]),
                _ => None,
            };
        }
        Ok(Received::Survey(survey))
    }

    fn is_expected(&self, survey: &SurveyWord) -> bool {
        let Expected { earth, limits, turn_rad, .. } = &self.expected;
        let near = |decoded, reference: Option<f32>, limit: f32, step: f32| match (decoded, reference) {
            (_, None) => true,
            (DecodedQuantity::Value(value), Some(reference)) => {
                (value - reference).abs() <= limits.bad_over_limit * limit + step
            }
            _ => false,
        };
        let DecodedQuantity::Value(inclination) = survey.inclination_rad else { return false };
        let turned = match (self.last_rad, survey.azimuth_rad) {
            (Some([last, last_azimuth]), DecodedQuantity::Value(azimuth)) => {
                let around = libm::remainderf(azimuth - last_azimuth, TAU) * libm::sinf(0.5 * (inclination + last));
                let tilted = inclination - last;
                tilted * tilted + around * around <= turn_rad * turn_rad
            }
            (None, _) => true,
            _ => false,
        };
        turned
            && near(survey.gravity_m_s2, Some(earth.gravity_m_s2), limits.gravity_m_s2, super::GRAVITY_M_S2.step())
            && near(survey.field_ut, earth.magnetic_field_ut, limits.field_ut, super::FIELD_UT.step())
            && near(survey.dip_rad, earth.dip_rad, limits.dip_rad, super::DIP.step())
    }
}

fn hard(bits: impl Iterator<Item = i16>) -> [u8; SURVEY_WORD_BYTES] {
    let mut word = [0; SURVEY_WORD_BYTES];
    for (k, bit) in bits.enumerate() {
        if let Some(byte) = word.get_mut(k / 8) {
            *byte = *byte << 1 | u8::from(bit > 0);
        }
    }
    word
}
