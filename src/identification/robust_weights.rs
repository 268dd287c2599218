mod clean_variances;

use super::graduation::Graduation;
use crate::window::{Equations, MAGNETIC, TESTS, TestEquations, TestWindows, gyro_part};
use clean_variances::{NOISE_MARGIN, clean_variances};

/// Fewer test windows in agreement than P, c and the lag have unknowns agree because they are fitted: each holds two independent equations of the
/// field, half of them its neighbours' too.
const LEAST_AGREEING: f32 = 13.0;

/// Weights of a window's test windows, for gravity and field, by graduated non-convexity: windows that a casing joint, a shock train or a
/// saturated gyro bends lose their weight, without a first solution that has to be good.
pub(crate) struct RobustWeights {
    /// What each has lost of its weight, in 255ths.
    disregard: [[u8; 2]; TESTS],
    graduation: Graduation,
    /// Variance of one equation of a clean window: gravity, field.
    variances: [f32; 2],
}

impl RobustWeights {
    pub const fn zero() -> Self {
        Self { disregard: [[0; 2]; TESTS], graduation: Graduation::Over, variances: [0.0; 2] }
    }

    /// All ones.
    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Of a test window by its number.
    pub fn of(&self, number: usize) -> [f32; 2] {
        let stored = self.disregard.get(number).copied().unwrap_or([255; 2]);
        stored.map(|lost| f32::from(255 - lost) / 255.0)
    }

    /// From the residuals of the unweighted solution: the scales, and whether there is anything to weigh down.
    pub fn measure(&mut self, tests: &TestWindows, theta: &[f32; 12], x: &[f32; MAGNETIC]) {
        let (variances, largest) = clean_variances(tests, theta, x);
        self.variances = variances;
        self.begin(largest);
    }

    /// Begins the graduation by the largest of the field's squared residuals. Gravity's do not ask for one: shocks are many and
    /// harmless.
    fn begin(&mut self, largest: f32) {
        let [_, variance] = self.variances;
        self.graduation = Graduation::from(if variance > 0.0 { largest / variance } else { 0.0 });
    }

    /// Those of a window with a disturbance.
    #[cfg(test)]
    pub fn begun() -> Self {
        Self { graduation: Graduation::from(1e4), ..Self::zero() }
    }

    /// Variance of one equation of the field by the sensor's own noise alone.
    pub fn sensor_noise(&self) -> f32 {
        let [_, field] = self.variances;
        field / NOISE_MARGIN
    }

    /// Sum of the field's weights.
    fn field_agreement(&self, tests: &TestWindows) -> f32 {
        let seen = tests.numbered().filter(|(_, test)| test.field.is_some());
        seen.map(|(number, _)| self.of(number)).map(|[_, field]| field).sum()
    }

    /// Whether there is a round to go.
    pub const fn is_running(&self) -> bool {
        !matches!(self.graduation, Graduation::Over)
    }

    /// Weighs some test windows anew by their residuals at a solution, in `sum` too.
    pub fn weigh<'a>(
        &mut self,
        tests: impl Iterator<Item = (usize, &'a TestEquations)>,
        theta: &[f32; 12],
        x: &[f32; MAGNETIC],
        sum: &mut Equations,
    ) {
        let graduation = self.graduation;
        for (number, test) in tests {
            let Some(stored) = self.disregard.get_mut(number) else { continue };
            let mut weights = [1.0; 2];
            for ((weight, square), variance) in weights.iter_mut().zip(squares_of(test, theta, x)).zip(self.variances) {
                if let Some(square) = square {
                    *weight = graduation.weight(if variance > 0.0 { square / variance } else { 0.0 });
                }
            }
            // A fault of the gyro spoils both, but only the sharp field shows it.
            let [gravity, field] = weights;
            let new =
                [if field < gravity { field } else { gravity }, field].map(|w| 255 - libm::roundf(255.0 * w) as u8);
            let change = [0, 1].map(|sensor: usize| {
                let of = |weights: &[u8; 2]| weights.get(sensor).copied().map_or(0.0, f32::from);
                (of(stored) - of(&new)) / 255.0
            });
            sum.add(test, theta, change);
            *stored = new;
        }
    }

    /// To the next round, after a solution, unless the field agrees in too few test windows.
    pub fn advance(&mut self, tests: &TestWindows) -> Round {
        if self.field_agreement(tests) < LEAST_AGREEING {
            return Round::Again;
        }
        self.graduation = self.graduation.next();
        if self.is_running() { Round::Next } else { Round::Done }
    }
}

/// What comes after a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Round {
    Next,
    /// Too few agree: with other test windows, from the start.
    Again,
    Done,
}

/// Squared norms of the residuals of gravity and field.
fn squares_of(test: &TestEquations, theta: &[f32; 12], x: &[f32; MAGNETIC]) -> [Option<f32>; 2] {
    let gravity = test.gravity.is_some().then(|| test.gravity.misfits(theta, &[gyro_part(x)]));
    let field = test.field.is_some().then(|| test.field.misfits(theta, &[*x]));
    [gravity, field].map(|squares| squares.map(|[square]| square))
}

#[cfg(test)]
mod tests;
