//! The schedule of graduated non-convexity: which weight a residual gets after each solution.

/// Geman and McClure's constant, in deviations of one component of the residual's three.
const C: f32 = 2.0;

/// Tukey's.
const C_TUKEY: f32 = 6.0;

/// A window in which no residual is beyond this squared norm is clean: of three normal components 1.5e-5 are, so one of two hundred
/// is in 0.3 % of clean windows.
const CLEAN_SQUARE: f32 = 25.0;

/// By what the graduation falls from one solution to the next.
const FALL: f32 = 4.0;

/// Solutions with the last of the graduated weights, and with Tukey's.
const ROUNDS_AT_ONE: u8 = 3;
const ROUNDS_OF_TUKEY: u8 = 4;

/// Where graduated non-convexity (Yang, Antonante, Tzoumas and Carlone, IEEE Robotics and Automation Letters 5 (2020) 1127, with Geman and
/// McClure's kernel, and Tukey's in the end) stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Graduation {
    /// Nothing to weigh down, or all of it done. The first, so that its tag is zero in a static.
    Over,
    /// (mu c^2 / (mu c^2 + z^2))^2, and how often it has been solved with mu = 1.
    GemanMcClure { mu: f32, at_one: u8 },
    /// (1 - z^2 / c^2)^2, and how often.
    Tukey(u8),
}

impl Graduation {
    /// From where the largest of the squared residuals hardly loses weight, and over at once where all of them are noise.
    pub fn from(largest: f32) -> Self {
        // Beyond a million a residual is so far off that it does not matter where the graduation begins.
        let mu = 2.0 * if largest < 1e6 { largest } else { 1e6 } / (C * C);
        if largest > CLEAN_SQUARE {
            Self::GemanMcClure { mu: if mu > 1.0 { mu } else { 1.0 }, at_one: 0 }
        } else {
            Self::Over
        }
    }

    /// Weight of a squared residual, z^2; NaN weighs nothing.
    pub fn weight(self, square: f32) -> f32 {
        let root = match self {
            Self::Over => 1.0,
            Self::GemanMcClure { mu, .. } => mu * C * C / (mu * C * C + square),
            Self::Tukey(_) => 1.0 - square / (C_TUKEY * C_TUKEY),
        };
        if root > 0.0 { root * root } else { 0.0 }
    }

    /// The one after a solution with this one.
    pub fn next(self) -> Self {
        match self {
            Self::GemanMcClure { mu, .. } if mu > 1.0 => {
                let mu = mu / FALL;
                Self::GemanMcClure { mu: if mu > 1.0 { mu } else { 1.0 }, at_one: 0 }
            }
            Self::GemanMcClure { at_one, .. } if at_one + 1 < ROUNDS_AT_ONE => {
                Self::GemanMcClure { mu: 1.0, at_one: at_one + 1 }
            }
            Self::GemanMcClure { .. } => Self::Tukey(0),
            Self::Tukey(round) if round + 1 < ROUNDS_OF_TUKEY => Self::Tukey(round + 1),
            Self::Tukey(_) | Self::Over => Self::Over,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_weighs_nothing_and_no_residual_everything() {
        let kernels = [
            Graduation::GemanMcClure { mu: 64.0, at_one: 0 },
            Graduation::GemanMcClure { mu: 1.0, at_one: 2 },
            Graduation::Tukey(0),
        ];
        for kernel in kernels {
            assert_eq!(kernel.weight(f32::NAN), 0.0, "{kernel:?}");
            assert_eq!(kernel.weight(0.0), 1.0, "{kernel:?}");
            assert!(kernel.weight(f32::INFINITY) < 1e-6, "{kernel:?}");
            let falls = (0..100).map(|k| kernel.weight(k as f32)).is_sorted_by(|before, after| before >= after);
            assert!(falls, "{kernel:?}");
        }
        assert_eq!(Graduation::Tukey(0).weight(C_TUKEY * C_TUKEY), 0.0);
    }

    #[test]
    fn it_falls_to_one_and_ends_from_wherever_it_begins() {
        for largest in [30.0, 1e3, 1e8, f32::INFINITY] {
            let (mut now, mut rounds, mut before) = (Graduation::from(largest), 0, f32::INFINITY);
            while now != Graduation::Over {
                if let Graduation::GemanMcClure { mu, .. } = now {
                    assert!(mu >= 1.0 && mu <= before, "{mu}");
                    before = mu;
                }
                rounds += 1;
                now = now.next();
            }
            assert!(before == 1.0 && rounds < 80, "{largest}: {rounds}");
        }
        assert_eq!(Graduation::from(CLEAN_SQUARE), Graduation::Over);
        assert_eq!(Graduation::from(f32::NAN), Graduation::Over);
    }
}
