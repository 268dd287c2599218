use crate::compensation::GyroModel;

/// What all samples so far say of the gyro's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// The mean that may fly.
    pub gyro: GyroModel,
    /// The factory's P with its own bias.
    pub bias_only: GyroModel,
    /// 1-sigma of P (row-major, 9) then b (rad/s, 3).
    pub sigma: [f32; 12],
    /// Covariance of P's nine elements, row-major: the packed lower triangle.
    pub p_covariance: [f32; 45],
    /// Directions of P's nine that the data decide.
    pub decided: u8,
    /// Which of the twelve parameters are observed.
    pub observable: [bool; 12],
    /// Widths that the data choose for the magnetometer's matrix, the hard iron and the accelerometer, over the data sheet's.
    pub widths: [f32; 3],
    /// Mean squared innovation over its degrees of freedom.
    pub nis: f32,
    /// Seconds of motion that it comes from.
    pub motion_s: f32,
    /// Whether it may fly.
    pub fitness: Result<(), Unfit>,
}

/// Why a posterior may not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Unfit {
    /// Too little motion with a gyro that can be used.
    NotEnoughMotion {
        /// How much there was, seconds.
        motion_s: f32,
        /// How much there has to be, seconds.
        needed_s: f32,
    },
    /// The innovations are larger than the filter thinks.
    Diverged {
        /// Mean squared innovation over its degrees of freedom.
        nis: f32,
    },
    /// The gyro's readings are missing, clipped or frozen too often.
    GyroUnusable {
        /// Share of the time without a rate.
        share: f32,
    },
    /// The accelerometer reads nothing usable.
    NoAccelerometer,
    /// The magnetometer's offset is too large: it needs a calibration first.
    MagnetometerUncalibrated {
        /// Hard iron, of the field's norm.
        hard_iron_share: f32,
    },
}
