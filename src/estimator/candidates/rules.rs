//! Rules of the evidence: thresholds from which an effect is claimed. `choice.rs` applies them.

/// Rules by the kind of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Log Bayes factor from which on an effect is claimed.
    pub least: f32,
    /// True if all nuisances are fitted before any effect is weighed, because every sensor has a little of each.
    pub with_nuisances: bool,
}

impl Rules {
    /// A drill string.
    pub const DRILL_STRING: Self = Self { least: 5.0, with_nuisances: false };
    /// By hand.
    pub const HAND: Self = Self { least: 10.0, with_nuisances: true };
}
