//! Every threshold of a diagnosis, and where it comes from.

/// Fewest test windows in a group: two seconds.
pub(super) const LEAST_PER_GROUP: u32 = 4;

/// Rate of false alarms of a whole diagnosis of a model that lacks nothing; shared out among the candidates (Bonferroni).
/// The same again is that of what this window and the one before show together.
pub(super) const FALSE_ALARMS: f32 = 0.01;

/// Least evidence of a candidate over the cost of its parameters: odds of 20 to 1.
pub(super) const LEAST_WORTH: f32 = 3.0;

/// By how much a candidate has to show more than one that stands before it in the library, where the likelier of two that look alike
/// come first: odds of 7 to 1.
pub(super) const LEAST_LEAD: f32 = 2.0;

/// Huber's constant, in deviations of a vector residual's component.
pub(super) const HUBER: f32 = 3.0;

/// Squared residual of a vector that every other one is under: the median of chi-square with 3 degrees of freedom.
pub(super) const MEDIAN_SQUARE: f32 = 2.366;

/// Deviation of specific force that is sensor noise, m/s^2: 2 mg in 50 Hz, the noise of common parts (0.2 mg/rtHz) and their cross-axis
/// terms.
pub(super) const FORCE_NOISE_M_S2: f32 = 0.02;

/// Deviation of the field that is sensor noise at least, microtesla: a step of 0.15 over the root of 12 (AK8963, MS1356-E-02, 16 bit).
pub(super) const FIELD_NOISE_UT: f32 = 0.05;

/// A vector that is turned by less does not matter: 0.3 deg.
pub(super) const LEAST_TURN_RAD: f32 = 0.005_2;

/// Rotation over a second that grows to those 0.3 deg over 36 s, the usual time from one diagnosis to the next, even if it adds up like
/// noise.
pub(super) const LEAST_DRIFT_RAD: f32 = LEAST_TURN_RAD / 6.0;

/// A residual of the field that is left for unexplained: a fifth of what matters.
pub(super) const LEAST_LEFT_RAD: f32 = LEAST_TURN_RAD / 5.0;

/// Most passes of one diagnosis.
pub(super) const MOST_PASSES: u8 = 20;

/// Least share of the misfit that P has to explain to be what is mainly wrong: three quarters, so that the residual's rms is at least
/// halved.
pub(super) const LEAST_EXPLAINED: f32 = 0.75;

/// Information from which a parameter is observed: its deviation is half its usual size.
pub(super) const OBSERVED: f32 = 4.0;

/// Deviations that a parameter of an effect has to be from zero to be taken out.
pub(super) const SIGNIFICANT: f32 = 3.0;

/// Variance of what flies from one window to the next: what is known of an effect is that of 25 windows at most, a quarter of an hour.
pub(super) const AGEING: f32 = 1.04;

/// Columns of P.
pub(super) const P: usize = 9;

/// A step of the bias has settled when it changes by less of its deviation.
pub(super) const STEP_SETTLED: f32 = 0.1;

/// Passes after which candidates are tried though the solution has not settled: a model that lacks a large effect may never do so.
pub(super) const PATIENCE: u8 = 4;

/// The solution has settled when the scales of the residuals change by less than this from one pass to the next.
pub(super) const SETTLED: f32 = 1.3;
