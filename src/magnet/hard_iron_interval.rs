//! Interval in which a magnet was on the probe.

use nalgebra::Vector3;

/// A body-fixed magnetic offset (hard iron) that came while the probe ran: a magnet was brought to the probe, and
/// perhaps taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HardIronInterval {
    /// Time at which the offset came, microseconds.
    pub from_us: u64,
    /// Time at which the offset left or changed, microseconds; `None` while it lasts.
    pub to_us: Option<u64>,
    /// Offset added to the calibrated field, body frame, microtesla.
    pub offset_ut: [f32; 3],
    /// Standard deviation of each axis of the offset, microtesla.
    pub sigma_ut: [f32; 3],
    /// Use of the field while the offset lasts.
    pub field_use: FieldUse,
}

/// Use of the field while a magnet's offset lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FieldUse {
    /// It is not used: the offset came after the freeze and matches none known before.
    Withheld,
    /// It is corrected by the offset.
    Corrected,
    /// It was used as it came: a magnet that comes before the probe has turned is taken for the probe's own iron. It
    /// was told when it left.
    ToldAfterwards,
}

impl HardIronInterval {
    /// Empty slot, all zero.
    pub(super) const NONE: Self =
        Self { from_us: 0, to_us: None, offset_ut: [0.0; 3], sigma_ut: [0.0; 3], field_use: FieldUse::Withheld };

    /// Returns true if the field is corrected by the offset.
    #[must_use]
    pub const fn is_corrected(&self) -> bool {
        matches!(self.field_use, FieldUse::Corrected)
    }

    /// The offset as a vector, microtesla.
    #[must_use]
    pub fn offset(&self) -> Vector3<f32> {
        Vector3::from(self.offset_ut)
    }
}

/// Counters of the watch for magnets since its configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HardIronCounts {
    /// Number of body-fixed offsets that came, including those no longer reported.
    pub intervals: u32,
    /// Number of changes of the field that were examined.
    pub suspicions: u32,
    /// Number of examined changes that were of the earth's field, passed, or could not be decided.
    pub dismissed: u32,
}
