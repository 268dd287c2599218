//! Maximum of the posterior: Gauss-Newton on the stations' residuals and the priors.

use super::{
    PARAMETERS, Station,
    rows::{Scales, Whitened},
};
use crate::algebra::cholesky::Cholesky;

/// Largest number of Gauss-Newton steps. Errors of a thousandth converge in two steps.
const STEPS: usize = 8;
/// Step below which the maximum is reached, in standard deviations of the priors.
const LAST_STEP: f32 = 1e-3;

/// Most probable errors with their information, both in units of the priors' standard deviations.
pub(super) struct Fit {
    pub(super) x: Whitened,
    pub(super) information: InformationFactor,
}

/// Factor of the posterior's information: the priors' identity and the stations' rows.
pub(super) struct InformationFactor(Cholesky<f32, PARAMETERS>);

impl InformationFactor {
    /// v^T S v with the posterior's covariance S.
    pub(super) fn variance(&self, v: &Whitened) -> f32 {
        let mut y = *v;
        self.0.solve_lower(&mut y);
        y.iter().fold(0.0, |sum, y| sum + y * y)
    }

    /// a^T S b.
    pub(super) fn covariance(&self, a: &Whitened, b: &Whitened) -> f32 {
        let (mut a, mut b) = (*a, *b);
        self.0.solve_lower(&mut a);
        self.0.solve_lower(&mut b);
        dot(&a, &b)
    }

    /// S v.
    fn times(&self, v: &Whitened) -> Whitened {
        let mut y = *v;
        self.0.solve_lower(&mut y);
        self.0.solve_upper(&mut y);
        y
    }
}

pub(super) fn dot(a: &Whitened, b: &Whitened) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// Fits the errors to the stations whose index `counts` accepts.
pub(super) fn fitted(stations: &[Station], counts: impl Fn(usize) -> bool, scales: &Scales) -> Option<Fit> {
    let mut x = [0.0; PARAMETERS];
    let mut last = None;
    for _ in 0..STEPS {
        // The prior: identity, and a pull towards zero.
        let mut normal = [[0.0; PARAMETERS]; PARAMETERS];
        let mut pull = x;
        for (_, station) in stations.iter().enumerate().filter(|(k, _)| counts(*k)) {
            let rows = scales.rows(station, &x)?;
            for (residual, derivative) in rows.residual.iter().zip(&rows.derivative) {
                for ((sums, a), pull) in normal.iter_mut().zip(derivative).zip(&mut pull) {
                    *pull += a * residual;
                    for (sum, b) in sums.iter_mut().zip(derivative) {
                        *sum += a * b;
                    }
                }
            }
        }
        let element = |i: usize, j: usize| {
            let sum = normal.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
            if i == j { 1.0 + sum } else { sum }
        };
        let information = InformationFactor(Cholesky::new(PARAMETERS, element)?);
        let step = information.times(&pull);
        let mut longest = 0.0;
        for (x, step) in x.iter_mut().zip(&step) {
            *x -= step;
            let size = libm::fabsf(*step);
            if size > longest || size.is_nan() {
                longest = size;
            }
        }
        if !longest.is_finite() {
            return None;
        }
        last = Some(information);
        if longest < LAST_STEP {
            break;
        }
    }
    last.map(|information| Fit { x, information })
}
