//! Quantities of a survey word: numbers in a few bits, with codes for missing and out of range.

use core::f32::consts::TAU;

/// Meaning of a quantity's code.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum DecodedQuantity {
    /// The quantity was not measured, or is no number.
    Missing,
    /// The value is under the range.
    Below,
    /// The value is over the range.
    Above,
    /// The value is within half a [`Quantity::step`] of this.
    Value(f32),
}

/// Map of a number to a few bits.
///
/// The highest of the 2^n codes of n bits means missing. A linear quantity has the two codes under it for below and
/// above its range and spreads the rest from its least to its greatest value, both included; an angle uses all other
/// codes, from 0 on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    bits: u32,
    least: f32,
    greatest: f32,
    whole_turn: bool,
}

impl Quantity {
    pub(super) const fn linear(bits: u32, least: f32, greatest: f32) -> Self {
        Self { bits, least, greatest, whole_turn: false }
    }

    pub(super) const fn whole_turn(bits: u32) -> Self {
        Self { bits, least: 0.0, greatest: TAU, whole_turn: true }
    }

    /// Returns the number of bits.
    #[must_use]
    pub const fn bits(&self) -> u32 {
        self.bits
    }

    /// Returns the least and the greatest value that have codes; angles outside are wrapped.
    #[must_use]
    pub const fn range(&self) -> [f32; 2] {
        [self.least, self.greatest]
    }

    /// Returns the step between neighbouring codes.
    #[must_use]
    pub fn step(&self) -> f32 {
        (self.greatest - self.least) / f32::from(self.steps())
    }

    const fn missing(&self) -> u16 {
        ((1_u32 << self.bits) - 1) as u16
    }

    const fn above(&self) -> u16 {
        self.missing() - 1
    }

    const fn below(&self) -> u16 {
        self.missing() - 2
    }

    /// Returns the number of steps between the ends of the range, or around a whole turn.
    const fn steps(&self) -> u16 {
        if self.whole_turn { self.missing() } else { self.missing() - 3 }
    }

    /// Returns the code of a value.
    #[must_use]
    pub fn code(&self, value: Option<f32>) -> u16 {
        let Some(value) = value.filter(|x| !x.is_nan()) else { return self.missing() };
        if self.whole_turn {
            if value.is_infinite() {
                return self.missing();
            }
            let turned = libm::remainderf(value, TAU);
            let positive = if turned < 0.0 { turned + TAU } else { turned };
            let code = libm::roundf(positive / self.step()) as u16;
            return if code < self.steps() { code } else { 0 };
        }
        if value < self.least {
            self.below()
        } else if value > self.greatest {
            self.above()
        } else {
            let code = libm::roundf((value - self.least) / self.step()) as u16;
            code.min(self.steps())
        }
    }

    /// Returns the meaning of a code.
    #[must_use]
    pub fn decode(&self, code: u16) -> DecodedQuantity {
        if code >= self.missing() {
            DecodedQuantity::Missing
        } else if code <= self.steps() {
            DecodedQuantity::Value(self.least + f32::from(code) * self.step())
        } else if code == self.below() {
            DecodedQuantity::Below
        } else {
            DecodedQuantity::Above
        }
    }
}
