//! Fit of nine parameters to a known norm: least squares in the directions that the readings determine, the
//! recorded values in the others, contradicted readings left out.

use nalgebra::{SymmetricEigen, Vector3};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::model::{Covariance, Model, PARAMETERS, Parameters};

/// Ratio of deviations after and before below which a direction is determined: the library's rule for P.
const DETERMINED: f64 = 0.5;
/// Chance that a calibration leaves out a good reading: the usual 1 %.
const LEFT_OUT_BY_CHANCE: f64 = 0.01;
/// Largest share of readings that may be left out: with more, nothing tells which are right (a quarter, the
/// breakdown point of a hinged median).
const MOST_LEFT_OUT: f64 = 0.25;
/// Limit of Gauss-Newton steps; four or five are needed, more from a large hard iron.
const STEPS: usize = 50;
/// Halvings of a step that does not lower the cost, before the point is taken for the minimum.
const CUTS: usize = 10;
/// Times the misfit is estimated again; it settles in two.
const MISFITS: usize = 4;

/// A reading whose norm is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Raw reading.
    pub raw: Vector3<f64>,
    /// Required norm of the calibrated vector.
    pub norm: f64,
    /// Deviation of the norm by noise. With many residuals only the ratios between readings matter.
    pub sigma: f64,
}

/// Input of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The readings, in order of time.
    pub observations: &'a [Observation],
    /// The values on record.
    pub record: Model,
    /// Deviation of each parameter from the values on record.
    pub prior: Parameters,
    /// True if a disturbance persists from one reading to the next, as a field that changes from place to
    /// place.
    pub correlated: bool,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The parameters.
    pub x: Parameters,
    /// Covariance of the parameters; the prior's where the readings determine nothing.
    pub covariance: Covariance,
    /// The recorded model corrected by the parameters.
    pub model: Model,
    /// Number of the nine directions that the readings determine.
    pub rank: usize,
    /// Degrees of freedom that the residuals leave.
    pub freedom: f64,
    /// For each reading: true if it was used.
    pub used: Vec<bool>,
    /// Norm of each calibrated reading minus its required value.
    pub residuals: Vec<f64>,
    /// True if more readings are contradicted than may be left out.
    pub torn: bool,
}

impl Fit {
    /// Number of deviations that the true value exceeds once in twenty: Student's t, 1.96 with many readings.
    #[must_use]
    pub fn quantile(&self) -> f64 {
        student(self.freedom, 0.975)
    }

    /// Deviation of each parameter.
    #[must_use]
    pub fn sigma(&self) -> Parameters {
        self.covariance.diagonal().map(|variance| variance.max(0.0).sqrt())
    }
}

fn student(freedom: f64, probability: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(probability))
}

impl Problem<'_> {
    /// Solves, leaving out every reading that the others contradict.
    #[must_use]
    pub fn solve(&self) -> Fit {
        let count = self.observations.len();
        let mut used = vec![true; count];
        let most = (MOST_LEFT_OUT * count as f64) as usize;
        loop {
            let start = self.with_prior(&used);
            let worst = contradicted(&start);
            let left_out = used.iter().filter(|used| !**used).count();
            if worst.is_empty() || left_out + worst.len() > most {
                let (basis, rank) = self.determined(&used, &start);
                return Fit { torn: !worst.is_empty(), ..self.within(&used, &start.x, &basis, rank) };
            }
            let places: Vec<usize> = (0..count).filter(|&at| used[at]).collect();
            worst.into_iter().for_each(|at| used[places[at]] = false);
        }
    }

    /// Sensitivities to parameters (in deviations of the prior) and residuals, both over the readings' noise.
    fn linearised(&self, used: &[bool], x: &Parameters) -> Vec<(Parameters, f64)> {
        let model = self.record.corrected(x);
        let used = self.observations.iter().zip(used).filter(|(_, used)| **used);
        used.map(|(observation, _)| {
            let vector = model.calibrate(&observation.raw);
            let norm = vector.norm();
            let change = model.sensitivity(&self.record, &observation.raw);
            let row = change.tr_mul(&(vector / norm)).component_mul(&self.prior) / observation.sigma;
            (row, (norm - observation.norm) / observation.sigma)
        })
        .collect()
    }

    /// Most probable parameters with the recorded values as prior. Readings and directions are judged there.
    fn with_prior(&self, used: &[bool]) -> MostProbable {
        let (mut misfit, mut spent) = (1.0, 0.0);
        // Start with the readings' own noise: a large misfit would let the prior hold the start.
        let mut y = self.most_probable(used, Parameters::zeros(), misfit);
        for _ in 0..MISFITS {
            let (information, _, square) = sums(&self.linearised(used, &self.scaled(&y)));
            // Each direction uses up as much freedom as the readings have weight in it.
            spent = information.symmetric_eigenvalues().iter().map(|l| l / (l + misfit)).sum();
            misfit = (square / (used.iter().filter(|used| **used).count() as f64 - spent).max(1.0)).max(1.0);
            y = self.most_probable(used, y, misfit);
        }
        let x = self.scaled(&y);
        let rows = self.linearised(used, &x);
        let covariance = (sums(&rows).0 / misfit + Covariance::identity()).try_inverse().unwrap_or_default();
        let rows = rows.iter().map(|(row, residual)| (*residual, row.dot(&(covariance * row)) / misfit)).collect();
        MostProbable { x, misfit, spent, rows }
    }

    /// Gauss-Newton from `y`, in deviations of the prior; each step is halved until the cost falls.
    fn most_probable(&self, used: &[bool], mut y: Parameters, misfit: f64) -> Parameters {
        let linearised = |y: &Parameters| sums(&self.linearised(used, &self.scaled(y)));
        let (mut information, mut gradient, mut square) = linearised(&y);
        for _ in 0..STEPS {
            let Some(cholesky) = (information / misfit + Covariance::identity()).cholesky() else { break };
            let mut step: Parameters = -cholesky.solve(&(gradient / misfit + y));
            if step.amax() < 1e-9 {
                break;
            }
            let cost = square / misfit + y.norm_squared();
            let down = (0..CUTS).find_map(|_| {
                let next = y + step;
                let sums = linearised(&next);
                step *= 0.5;
                (sums.2 / misfit + next.norm_squared() < cost).then_some((next, sums))
            });
            let Some((next, sums)) = down else { break };
            y = next;
            (information, gradient, square) = sums;
        }
        y
    }

    /// The directions that the readings determine, as the first columns of a basis in deviations of the
    /// prior. They are orthogonal in both metrics, so that undetermined directions do not leak into
    /// determined ones.
    fn determined(&self, used: &[bool], start: &MostProbable) -> (Covariance, usize) {
        let rows = self.linearised(used, &start.x);
        let eigen = SymmetricEigen::new(sums(&rows).0);
        let mut order: [usize; PARAMETERS] = std::array::from_fn(|k| k);
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        // 1 / (1 + information) below the square of the ratio, with Student's allowance for few residuals.
        let least = 1.0 / (DETERMINED * DETERMINED) - 1.0;
        let allowance = |rank: usize| {
            let freedom = rows.len().saturating_sub(rank) as f64;
            if freedom < 1.0 { f64::INFINITY } else { (student(freedom, 0.975) / 1.96).powi(2) }
        };
        let holds = |rank: usize| eigen.eigenvalues[order[rank - 1]] > least * start.misfit * allowance(rank);
        let rank = (1..=PARAMETERS).rev().find(|&rank| holds(rank)).unwrap_or(0);
        (Covariance::from_fn(|row, column| eigen.eigenvectors[(row, order[column])]), rank)
    }

    /// Least squares from `start` within the first `rank` columns of `basis`.
    fn within(&self, used: &[bool], start: &Parameters, basis: &Covariance, rank: usize) -> Fit {
        let inside = Covariance::from_fn(|row, column| if row == column && row < rank { 1.0 } else { 0.0 });
        let (basis, outside) = (basis * inside, Covariance::identity() - inside);
        let mut z = basis.tr_mul(&start.component_div(&self.prior));
        let mut inverse = Covariance::zeros();
        for _ in 0..STEPS {
            let (information, gradient, _) = sums(&self.linearised(used, &self.scaled(&(basis * z))));
            let Some(cholesky) = (basis.tr_mul(&information) * basis + outside).cholesky() else { break };
            inverse = cholesky.inverse() - outside;
            let step = inverse * basis.tr_mul(&gradient);
            z -= step;
            if step.amax() < 1e-12 {
                break;
            }
        }
        let x = self.scaled(&(basis * z));
        let rows = self.linearised(used, &x);
        let spread = basis * inverse * basis.transpose();
        let residuals: Vec<f64> = rows.iter().map(|(_, residual)| *residual).collect();
        let (count, spent) = (rows.len() as f64, rank as f64);
        let misfit = sums(&rows).2 / (count - spent).max(1.0);
        let inflation = if self.correlated { inflation(&residuals) } else { 1.0 };
        let whitened = spread * (misfit * inflation) + Covariance::identity() - basis * basis.transpose();
        let covariance = Covariance::from_fn(|i, j| whitened[(i, j)] * self.prior[i] * self.prior[j]);
        let model = self.record.corrected(&x);
        Fit {
            x,
            covariance,
            model,
            rank,
            freedom: (count / inflation - spent).max(0.0),
            used: used.to_vec(),
            residuals: self.observations.iter().map(|o| model.calibrate(&o.raw).norm() - o.norm).collect(),
            torn: false,
        }
    }

    fn scaled(&self, y: &Parameters) -> Parameters {
        y.component_mul(&self.prior)
    }
}

/// Information matrix, gradient and sum of squares of rows and residuals.
fn sums(rows: &[(Parameters, f64)]) -> (Covariance, Parameters, f64) {
    rows.iter().fold(
        (Covariance::zeros(), Parameters::zeros(), 0.0),
        |(information, gradient, square), (row, residual)| {
            (information + row * row.transpose(), gradient + row * *residual, square + residual * residual)
        },
    )
}

/// Result of [`Problem::with_prior`].
struct MostProbable {
    x: Parameters,
    /// Mean square of the residuals over that of the readings' noise, at least 1.
    misfit: f64,
    /// Degrees of freedom that the parameters use up.
    spent: f64,
    /// Residual over noise, and leverage, of each reading used.
    rows: Vec<(f64, f64)>,
}

/// Readings that all others contradict: residual over its deviation when left out, against Student's t at a
/// level shared among all readings (Bonferroni). Returns the worst one, or the worst fiftieth of many,
/// because a bad reading shifts the residuals of good ones.
fn contradicted(start: &MostProbable) -> Vec<usize> {
    let count = start.rows.len();
    let freedom = count as f64 - start.spent;
    if freedom < 2.0 {
        return Vec::new();
    }
    let limit = student(freedom - 1.0, 1.0 - LEFT_OUT_BY_CHANCE / (2.0 * count as f64));
    let whole: f64 = start.rows.iter().map(|(residual, _)| residual * residual).sum();
    let t = |&(residual, leverage): &(f64, f64)| {
        let square = residual * residual / (1.0 - leverage).max(1e-9);
        (square / ((whole - square) / (freedom - 1.0)).max(1e-12)).sqrt()
    };
    let mut odd: Vec<(f64, usize)> = start.rows.iter().map(t).zip(0..).filter(|(t, _)| *t > limit).collect();
    odd.sort_by(|a, b| b.0.total_cmp(&a.0));
    odd.truncate((count / 50).max(1));
    odd.into_iter().map(|(_, at)| at).collect()
}

/// Factor by which correlation of the residuals increases the variance of a mean: the initial positive
/// sequence of their autocorrelation (Geyer, Statistical Science 7, 1992).
fn inflation(residuals: &[f64]) -> f64 {
    let count = residuals.len();
    let at_lag = |lag: usize| residuals.iter().zip(residuals.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>();
    let square = at_lag(0);
    if count < 4 || square <= 0.0 {
        return 1.0;
    }
    let pairs = (0..count / 2).map(|pair| (at_lag(2 * pair) + at_lag(2 * pair + 1)) / square);
    let sum: f64 = pairs.take_while(|sum| *sum > 0.0).sum();
    (2.0 * sum - 1.0).max(1.0)
}
