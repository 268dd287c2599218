use nalgebra::Vector3;

/// A body-fixed magnetic offset (hard iron) that came while the probe ran: something magnetic was brought to it, and perhaps taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HardIronInterval {
    /// When it came, microseconds.
    pub from_us: u64,
    /// When it left or changed; `None` while it lasts.
    pub to_us: Option<u64>,
    /// What it adds to the calibrated field, body frame, microtesla.
    pub offset_ut: [f32; 3],
    /// Standard deviation of each axis of it, microtesla.
    pub sigma_ut: [f32; 3],
    /// Whether the field is corrected by it. Otherwise it came after the freeze and is none of those known before it: the field is
    /// not used while it lasts.
    pub corrected: bool,
}

impl HardIronInterval {
    /// All zero.
    pub(super) const NONE: Self =
        Self { from_us: 0, to_us: None, offset_ut: [0.0; 3], sigma_ut: [0.0; 3], corrected: false };

    /// The offset as a vector, microtesla.
    #[must_use]
    pub fn offset(&self) -> Vector3<f32> {
        Vector3::from(self.offset_ut)
    }
}

/// What the watch for magnets has counted since the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HardIronCounts {
    /// Body-fixed offsets that came, those no longer in the report included.
    pub intervals: u32,
    /// Changes of the field that were looked into.
    pub suspicions: u32,
    /// Those of them that stayed in the earth, passed, or could not be told.
    pub dismissed: u32,
}
