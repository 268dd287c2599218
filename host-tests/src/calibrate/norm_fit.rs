//! Nine parameters from a norm that is known: least squares in the directions that the readings determine, the values on record in the
//! others, and readings that disagree left out.

use nalgebra::{SymmetricEigen, Vector3};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::model::{Covariance, Model, PARAMETERS, Parameters};

/// A direction is determined when its deviation is under half of what it was before: the rule by which the library applies P.
const DETERMINED: f64 = 0.5;
/// Chance that one good reading is left out of a whole calibration: the usual 1 %.
const LEFT_OUT_BY_CHANCE: f64 = 0.01;
/// Where more than this share of the readings disagrees, nothing says who is right: a quarter, the breakdown of a hinged median.
const MOST_LEFT_OUT: f64 = 0.25;
/// Most Gauss-Newton steps; four or five are needed, more from a large hard iron.
const STEPS: usize = 50;
/// Halvings of a step that does not go down, before the point is taken for the lowest.
const CUTS: usize = 10;
/// How often the misfit is taken anew; it settles in two.
const MISFITS: usize = 4;

/// One reading of which the norm is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// What the sensor reads, raw.
    pub raw: Vector3<f64>,
    /// What the norm of the calibrated vector has to be.
    pub norm: f64,
    /// Deviation of the norm by noise; only its ratio from one reading to the other matters where residuals are plenty.
    pub sigma: f64,
}

/// What is fitted.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The readings, in order of time.
    pub observations: &'a [Observation],
    /// The values on record.
    pub record: Model,
    /// How far off these may be, one deviation a parameter.
    pub prior: Parameters,
    /// Whether what disturbs one reading also disturbs the next (a field that differs from place to place).
    pub correlated: bool,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The parameters.
    pub x: Parameters,
    /// Their covariance; where the readings determine nothing, that of the values on record.
    pub covariance: Covariance,
    /// The model on record with the parameters taken out.
    pub model: Model,
    /// How many of nine directions the readings determine.
    pub rank: usize,
    /// Degrees of freedom that the residuals leave.
    pub freedom: f64,
    /// Whether a reading was used.
    pub used: Vec<bool>,
    /// Norm of each calibrated reading minus what it has to be.
    pub residuals: Vec<f64>,
    /// Whether more readings disagree than may be left out.
    pub torn: bool,
}

impl Fit {
    /// By how many deviations the true value is off once in twenty: Student's t, 1.96 with many readings.
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
    /// Solves; every reading that the others contradict is left out.
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

    /// Rows of the sensitivity to parameters in deviations of the prior, with their residuals, both over the readings' noise.
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

    /// The most probable point with the values on record as prior knowledge. It is where readings and directions are judged.
    fn with_prior(&self, used: &[bool]) -> MostProbable {
        let (mut misfit, mut spent) = (1.0, 0.0);
        // First as if the readings had only their own noise: with a large misfit the prior would hold the start.
        let mut y = self.most_probable(used, Parameters::zeros(), misfit);
        for _ in 0..MISFITS {
            let (information, _, square) = sums(&self.linearised(used, &self.scaled(&y)));
            // Each direction takes as much freedom as the readings have a say in it.
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

    /// Gauss-Newton from `y`, in deviations of the prior, each step cut until it is one down.
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

    /// The directions, in deviations of the prior, that the readings determine: so many first columns. They are orthogonal in both
    /// metrics, so that what is not determined does not leak into what is.
    fn determined(&self, used: &[bool], start: &MostProbable) -> (Covariance, usize) {
        let rows = self.linearised(used, &start.x);
        let eigen = SymmetricEigen::new(sums(&rows).0);
        let mut order: [usize; PARAMETERS] = std::array::from_fn(|k| k);
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        // 1 / (1 + information) under the square of the rule's ratio, with Student's allowance for few residuals.
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

/// Information matrix, gradient and sum of squares of rows with their residuals.
fn sums(rows: &[(Parameters, f64)]) -> (Covariance, Parameters, f64) {
    rows.iter().fold(
        (Covariance::zeros(), Parameters::zeros(), 0.0),
        |(information, gradient, square), (row, residual)| {
            (information + row * row.transpose(), gradient + row * *residual, square + residual * residual)
        },
    )
}

/// The point of [`Problem::with_prior`].
struct MostProbable {
    x: Parameters,
    /// Square of the residuals over that of the readings' own noise, at least 1.
    misfit: f64,
    /// Degrees of freedom that the parameters take.
    spent: f64,
    /// Residual over the reading's noise, and leverage, of each reading used.
    rows: Vec<(f64, f64)>,
}

/// Which of the readings used all the others contradict: residual over its deviation when left out, against Student's t shared out among
/// all readings (Bonferroni). One at a time, or of many the worst fiftieth: a bad one shifts the residuals of the good.
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

/// By what factor the variance of a mean exceeds that of independent residuals: the initial positive sequence of their
/// autocorrelation (Geyer, Statistical Science 7, 1992).
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
