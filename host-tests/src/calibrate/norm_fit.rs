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
/// Most Gauss-Newton steps; four or five are needed.
const STEPS: usize = 50;
/// After so many the residuals are those of the readings and not of the start.
const SETTLED: usize = 8;

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
    /// Square of residuals over that of the readings' own noise.
    pub misfit: f64,
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
            let (fit, leverage) = self.solve_with(&used);
            let worst = contradicted(&fit, &leverage, self.observations);
            let left_out = used.iter().filter(|used| !**used).count();
            if worst.is_empty() || left_out + worst.len() > most {
                return Fit { torn: !worst.is_empty(), ..fit };
            }
            worst.into_iter().for_each(|at| used[at] = false);
        }
    }

    fn solve_with(&self, used: &[bool]) -> (Fit, Vec<f64>) {
        let (start, misfit) = self.with_prior(used);
        let (basis, rank) = self.determined(used, &start, misfit);
        self.within(used, &basis, rank)
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

    /// The most probable point with the values on record as prior knowledge, and the misfit there. It is where the directions are judged.
    fn with_prior(&self, used: &[bool]) -> (Parameters, f64) {
        let mut y = Parameters::zeros();
        let mut misfit = 1.0;
        for step in 0..STEPS {
            let rows = self.linearised(used, &self.scaled(&y));
            let (information, gradient, square) = sums(&rows);
            if step >= SETTLED {
                // Each direction takes as much freedom as the readings have a say in it.
                let spent: f64 = information.symmetric_eigenvalues().iter().map(|l| l / (l + misfit)).sum();
                misfit = (square / (rows.len() as f64 - spent).max(1.0)).max(1.0);
            }
            let Some(cholesky) = (information / misfit + Covariance::identity()).cholesky() else { break };
            let change: Parameters = cholesky.solve(&(gradient / misfit + y));
            y -= change;
            if step > SETTLED && change.amax() < 1e-9 {
                break;
            }
        }
        (self.scaled(&y), misfit)
    }

    /// The directions, in deviations of the prior, that the readings determine: so many first columns. They are orthogonal in both
    /// metrics, so that what is not determined does not leak into what is.
    fn determined(&self, used: &[bool], x: &Parameters, misfit: f64) -> (Covariance, usize) {
        let rows = self.linearised(used, x);
        let eigen = SymmetricEigen::new(sums(&rows).0);
        let mut order: [usize; PARAMETERS] = std::array::from_fn(|k| k);
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        // 1 / (1 + information) under the square of the rule's ratio, with Student's allowance for few residuals.
        let least = 1.0 / (DETERMINED * DETERMINED) - 1.0;
        let allowance = |rank: usize| {
            let freedom = rows.len().saturating_sub(rank) as f64;
            if freedom < 1.0 { f64::INFINITY } else { (student(freedom, 0.975) / 1.96).powi(2) }
        };
        let holds = |rank: usize| eigen.eigenvalues[order[rank - 1]] > least * misfit * allowance(rank);
        let rank = (1..=PARAMETERS).rev().find(|&rank| holds(rank)).unwrap_or(0);
        (Covariance::from_fn(|row, column| eigen.eigenvectors[(row, order[column])]), rank)
    }

    /// Least squares within the first `rank` columns of `basis`, with the leverage of every reading used.
    fn within(&self, used: &[bool], basis: &Covariance, rank: usize) -> (Fit, Vec<f64>) {
        let inside = Covariance::from_fn(|row, column| if row == column && row < rank { 1.0 } else { 0.0 });
        let (basis, outside) = (basis * inside, Covariance::identity() - inside);
        let mut z = Parameters::zeros();
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
        let leverage = rows.iter().map(|(row, _)| row.dot(&(spread * row))).collect();
        let residuals: Vec<f64> = rows.iter().map(|(_, residual)| *residual).collect();
        let (count, spent) = (rows.len() as f64, rank as f64);
        let misfit = sums(&rows).2 / (count - spent).max(1.0);
        let inflation = if self.correlated { inflation(&residuals) } else { 1.0 };
        let whitened = spread * (misfit * inflation) + Covariance::identity() - basis * basis.transpose();
        let covariance = Covariance::from_fn(|i, j| whitened[(i, j)] * self.prior[i] * self.prior[j]);
        let model = self.record.corrected(&x);
        let fit = Fit {
            x,
            covariance,
            model,
            rank,
            freedom: (count / inflation - spent).max(0.0),
            used: used.to_vec(),
            residuals: self.observations.iter().map(|o| model.calibrate(&o.raw).norm() - o.norm).collect(),
            torn: false,
            misfit,
        };
        (fit, leverage)
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

/// The readings that all the others contradict: residual over its deviation when left out, against Student's t shared out among all
/// readings (Bonferroni). One at a time, or of many the worst fiftieth: a bad one shifts the residuals of the good.
fn contradicted(fit: &Fit, leverage: &[f64], observations: &[Observation]) -> Vec<usize> {
    let places: Vec<usize> = (0..observations.len()).filter(|&at| fit.used[at]).collect();
    let freedom = places.len() as f64 - fit.rank as f64;
    if freedom < 2.0 {
        return Vec::new();
    }
    let limit = student(freedom - 1.0, 1.0 - LEFT_OUT_BY_CHANCE / (2.0 * places.len() as f64));
    let whole = fit.misfit * freedom;
    let mut odd: Vec<(f64, usize)> = places
        .iter()
        .zip(leverage)
        .filter_map(|(&at, &leverage)| {
            let free = (1.0 - leverage).max(1e-9);
            let square = (fit.residuals[at] / observations[at].sigma).powi(2) / free;
            let others = ((whole - square) / (freedom - 1.0)).max(1e-12);
            let t = (square / others).sqrt();
            (t > limit).then_some((t, at))
        })
        .collect();
    odd.sort_by(|a, b| b.0.total_cmp(&a.0));
    odd.truncate((places.len() / 50).max(1));
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
