//! Reasons for which P is refused. They are found in `posterior.rs` (`Filter::fitness`), but for `Overrun`, which
//! `identification/identifier.rs` finds, and `WrongMounting`, which `identification/flying.rs` is told.

use crate::sample::TurnFlags;

/// Reason for which P was refused. Telemetry numbers the reasons in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Refusal {
    /// Too little motion with a gyro that can be used.
    NotEnoughMotion {
        /// Motion since the start, seconds.
        motion_s: f32,
        /// Motion needed, seconds.
        needed_s: f32,
    },
    /// The result was not ready at the instant at which it would have taken effect. The estimator itself never
    /// says so: it does not know that instant.
    Overrun,
    /// The accelerometer reads nothing usable.
    NoAccelerometer,
    /// The gyro's readings are missing, clipped or frozen too often, or contradict field and gravity.
    GyroUnusable {
        /// Share of the time without a rate that can be used.
        share: f32,
    },
    /// The innovations are larger than the estimator thinks, or its mean is no model.
    Diverged {
        /// Mean squared innovation over its degrees of freedom.
        nis: f32,
    },
    /// Too little of the motion has a field: rotation about gravity cannot be seen.
    NoMagnetometer {
        /// Share of the motion without a field.
        share: f32,
    },
    /// P is farther from the factory's than any part's data sheet allows.
    Implausible {
        /// Distance from the factory's P, in deviations of the prior.
        sigmas: f32,
    },
    /// The magnetometer's offset is too large: it needs a calibration first.
    MagnetometerUncalibrated {
        /// Hard iron, of the field's norm.
        hard_iron_share: f32,
    },
    /// The sensors do not agree on turns: a sign, a unit or an axis is wrong. Told by
    /// [`Probe::mistrust_mounting`](crate::Probe::mistrust_mounting).
    WrongMounting {
        /// Turns about which they do not agree.
        turns: TurnFlags,
    },
}
