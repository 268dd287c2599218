/// A number with its standard deviation, both in the unit that the field's name ends with.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Uncertain {
    /// The number.
    pub value: f32,
    /// One standard deviation.
    pub sigma: f32,
}
