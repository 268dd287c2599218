//! Report of a remainder: quantities that it goes with, and its memory.

/// Quantity that the remainder can go with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Correlate {
    /// Time and its square: a drift or a step.
    #[default]
    Time,
    /// Temperature.
    Temperature,
    /// The body's rate, axis by axis.
    Rate,
    /// The square of the rate, beside the rate.
    RateSquared,
    /// Specific force, axis by axis.
    Acceleration,
    /// Mean square of the specific force.
    VibrationPower,
    /// Sine and cosine of the gravity toolface.
    OncePerRevolution,
    /// Sine and cosine of twice the gravity toolface.
    TwicePerRevolution,
    /// Angular acceleration: a vector or a rate that is late, and more than a pure delay would be.
    Lag,
}

impl Correlate {
    /// Name of the quantity in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Temperature => "temperature",
            Self::Rate => "rate",
            Self::RateSquared => "rate_squared",
            Self::Acceleration => "acceleration",
            Self::VibrationPower => "vibration_power",
            Self::OncePerRevolution => "once_per_revolution",
            Self::TwicePerRevolution => "twice_per_revolution",
            Self::Lag => "lag",
        }
    }
}

/// Most correlates that are named.
pub const MOST_NAMED: usize = 3;

/// A quantity that the remainder goes with. That is no cause yet: what warms up also goes with time.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GoesWith {
    /// The quantity.
    pub correlate: Correlate,
    /// Squared multiple correlation: the share of the remainder's variance that goes with the quantity.
    pub share: f32,
    /// Chance of so large a share in a remainder that is white.
    pub p_value: f32,
}

/// Likeness of the remainder to itself some time later.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Memory {
    /// Largest correlation of the nodes' innovations with later ones, of either sign.
    pub correlation: f32,
    /// Time between the correlated nodes, seconds.
    pub apart_s: f32,
    /// Chance of so large a correlation, at any distance, in a remainder that is white.
    pub p_value: f32,
}

/// Report of a residual that no candidate explains. If it is white, one report in a hundred names anything.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RemainderReport {
    /// Quantities that the remainder goes with, the least likely to be chance first.
    pub goes_with: [GoesWith; MOST_NAMED],
    /// Number of these quantities.
    pub count: u8,
    /// Likeness of the remainder to itself some time later.
    pub memory: Memory,
    /// True if the memory is beyond chance.
    pub has_memory: bool,
}

impl RemainderReport {
    /// Returns the quantities that the remainder goes with.
    pub fn named(&self) -> impl Iterator<Item = &GoesWith> {
        self.goes_with.iter().take(usize::from(self.count))
    }

    /// Returns true if the remainder cannot be told from white noise; larger than expected, it then means that the
    /// noise was stated too small.
    #[must_use]
    pub const fn is_white(&self) -> bool {
        self.count == 0 && !self.has_memory
    }
}
