use crate::{compensation::GyroModel, config::OptimizerKind};

/// What came of one window.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WindowReport {
    /// Beginning of the window, microseconds.
    pub t_start_us: u64,
    /// Last sample of the window, microseconds.
    pub t_end_us: u64,
    /// First sample to which the result applies, microseconds; `None` where nothing was there to apply.
    pub t_effect_us: Option<u64>,
    /// Whether P and b of `fitted` fly, or why not.
    pub decision: Decision,
    /// What searched.
    pub optimizer: OptimizerKind,
    /// Cost evaluations spent by the search.
    pub evaluations: u32,
    /// Cost of the model flown so far, on this window: the robust sum of
    /// its vectors' squared innovations, in units of their noise, and of the prior; `None` when there was nothing to evaluate.
    pub cost_before: Option<f32>,
    /// Cost of `fitted` on this window; `None` when there was nothing to evaluate.
    pub cost_after: Option<f32>,
    /// The 12-parameter fit, accepted or not; the model flown where there was no fit.
    pub fitted: GyroModel,
    /// The bias-only alternative, what would fly had P never moved: the factory's P with the bias from rest, or with a fitted one
    /// that won clearly, or with the one before.
    pub bias_only: GyroModel,
    /// What flies from `t_effect_us` on.
    pub flown: GyroModel,
    /// 1-sigma of P (row-major, 9) then b (rad/s, 3) of `fitted`; the prior's where nothing was observed.
    pub sigma: [f32; 12],
    /// Which of the 12 parameters the window observes (posterior below half the prior).
    pub observable: [bool; 12],
    /// How many independent directions of the 12 the window observes.
    pub rank: u8,
    /// Seconds of rest in this window.
    pub rest_s: f32,
    /// Fraction of the misfit on unseen blocks, with the bias alone fitted, that the fit of P explains; at most 1, negative when it is
    /// worse. `None`: not evaluated.
    pub explained: Option<f32>,
    /// Probability of so clear a win on unseen blocks if nothing had changed (exact sign-flip permutation); `None`: not evaluated.
    pub p_value: Option<f32>,
}

/// Accepted, or refused and why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Decision {
    /// P and b fly.
    Accepted,
    /// P stays as it was; only the bias may have moved.
    Refused(Refusal),
}

/// Why P was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Refusal {
    /// The window is shorter than the shortest that is identified.
    WindowTooShort {
        /// Length of the window, seconds.
        length_s: f32,
        /// The shortest that is identified, seconds.
        needed_s: f32,
        /// Whether a gap in time cut it short.
        cut_by_gap: bool,
    },
    /// The result was not ready at the instant at which it would have taken effect.
    Overrun,
    /// Without a magnetometer rotation about gravity cannot be seen.
    NoMagnetometer {
        /// How far the norm of specific force at rest is from gravity, m/s^2, where that is too far; `None`: the configuration
        /// holds no calibration of the accelerometer.
        accel_norm_error_m_s2: Option<f32>,
    },
    /// The accelerometer reads nothing usable.
    NoAccelerometer,
    /// The norm of specific force at rest is too far from gravity: the accelerometer needs a calibration first.
    AccelerometerUncalibrated {
        /// How far, m/s^2.
        norm_error_m_s2: f32,
    },
    /// The tool hardly turned: too few parameters are observable.
    NotEnoughExcitation {
        /// Observable directions of the 12.
        rank: u8,
    },
    /// Too little of the window moved with readings that can be used: the cross-validation has too few groups.
    TooLittleMotion {
        /// How many there are.
        groups: u8,
    },
    /// On unseen blocks of the window the fit does not win beyond chance.
    NoClearWin {
        /// Probability of so clear a win if nothing had changed.
        p_value: f32,
    },
    /// The fit wins, but leaves too much of the misfit unexplained: what is wrong is not mainly P.
    MisfitNotExplained {
        /// Fraction of the misfit on unseen blocks that the fit explains.
        explained: f32,
    },
    /// The change of attitude that the swap promises is too small to be worth its risk.
    ChangeTooSmall {
        /// Promised change of the rotation over one second, radians rms.
        change_rad: f32,
        /// Its own uncertainty, radians rms.
        sigma_rad: f32,
    },
    /// The normal matrix could not be factorised, or the fit is not finite or not plausible.
    Degenerate,
    /// With the fit, gyro and accelerometer disagree more than before on how far the body turned, or which way.
    RotationDisagrees {
        /// By how many standard deviations of chance more.
        sigmas: f32,
    },
    /// The window contradicts what earlier ones taught, which is forgotten; the next one stands by itself.
    Contradiction {
        /// Squared distance between the two in their own deviations, of 12 parameters.
        square: f32,
    },
    /// What flew no longer beats the factory's P on unseen blocks, and is rolled back.
    RolledBack {
        /// Probability of so clear a win of the factory's by chance.
        p_value: f32,
    },
    /// The gyro's readings are missing, clipped or frozen too often.
    GyroUnusable {
        /// Share of the window's one-second tests that lack a rate.
        share: f32,
    },
    /// The magnetometer's axes were found to be turned, or a magnet came or left, and P changes by no more than that may look like.
    FieldDoubtful,
}
