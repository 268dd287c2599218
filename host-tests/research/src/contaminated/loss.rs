/// A robust loss of a residual's norm z in standard deviations of one component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Loss {
    /// z^2 / 2.
    Square,
    /// Huber (1964), linear beyond the constant.
    Huber(f64),
    /// Tukey's biweight, constant beyond the constant.
    Tukey(f64),
    /// Geman-McClure with c and mu: mu c^2 z^2 / 2 (mu c^2 + z^2); convex for large mu (Yang, Antonante,
    /// Tzoumas and Carlone, IEEE Robotics and Automation Letters 5 (2020) 1127, eq 6).
    GemanMcClure(f64, f64),
}

/// Huber's constant of the library's objective: 95 % efficiency for the norm of a two-dimensional residual.
pub(super) const HUBER: f64 = 1.345 * 1.75;

/// Tukey's constant: 4.685 (95 % in one dimension) widened for a norm, as much as keeps every good second.
pub(super) const TUKEY: f64 = 6.0;

impl Loss {
    /// The loss at z^2.
    pub fn value(self, square: f64) -> f64 {
        match self {
            Self::Square => 0.5 * square,
            Self::Huber(c) if square > c * c => c * square.sqrt() - 0.5 * c * c,
            Self::Huber(_) => 0.5 * square,
            Self::Tukey(c) => {
                let rest = (1.0 - square / (c * c)).max(0.0);
                c * c / 6.0 * (1.0 - rest * rest * rest)
            }
            Self::GemanMcClure(c, mu) => 0.5 * mu * c * c * square / (mu * c * c + square),
        }
    }

    /// The weight in re-weighted least squares: the slope of the loss in z^2 / 2.
    pub fn weight(self, square: f64) -> f64 {
        match self {
            Self::Square => 1.0,
            Self::Huber(c) if square > c * c => c / square.sqrt(),
            Self::Huber(_) => 1.0,
            Self::Tukey(c) => {
                let rest = (1.0 - square / (c * c)).max(0.0);
                rest * rest
            }
            Self::GemanMcClure(c, mu) => {
                let share = mu * c * c / (mu * c * c + square);
                share * share
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_slope_of_the_loss() {
        for loss in [Loss::Square, Loss::Huber(HUBER), Loss::Tukey(TUKEY), Loss::GemanMcClure(3.0, 4.0)] {
            for square in [0.1, 1.0, 4.0, 7.0, 30.0, 100.0, 1e4] {
                let step = 1e-4 * square;
                let slope = (loss.value(square + step) - loss.value(square - step)) / step;
                assert!((slope - loss.weight(square)).abs() < 1e-3, "{loss:?} {square}");
            }
        }
    }
}
