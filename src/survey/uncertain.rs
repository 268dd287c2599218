//! Value with its standard deviation.

/// Value with its standard deviation, both in the unit that the field's name ends with.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Uncertain {
    /// Value.
    pub value: f32,
    /// Standard deviation.
    pub sigma: f32,
}
