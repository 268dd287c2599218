/// Decision to correct an angle, or the reason not to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Decision {
    /// The angle is corrected.
    Corrected,
    /// The angle stays as measured.
    Refused(Refusal),
}

/// Reason for leaving an angle as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Refusal {
    /// The correction is too uncertain for its size: it would too often make the angle worse.
    NotCertain,
    /// Left-out stations are predicted better without correction than with the errors estimated from the other
    /// stations.
    PredictsWorse,
    /// Stations contradict each other far beyond their noise.
    Contradiction,
}

impl Refusal {
    /// Reason in words, for a report.
    #[must_use]
    pub const fn told(self) -> &'static str {
        match self {
            Self::NotCertain => "too uncertain for its size",
            Self::PredictsWorse => "left-out stations are predicted better without it",
            Self::Contradiction => "stations contradict each other far beyond their noise",
        }
    }
}
