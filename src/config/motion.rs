//! Kinds of motion.

/// Kind of motion: how much the probe's turning and its accelerations may change between two nodes of the
/// estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Motion {
    /// A hand that turns and swings the probe.
    Hand,
    /// A drill string, or a rig that turns the probe without carrying it about.
    #[default]
    DrillString,
}
