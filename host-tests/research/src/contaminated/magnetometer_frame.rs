//! A magnetometer turned by an unknown rotation against the gyro and accelerometer.

use meerkat_mwd::optimizer::{Cost, OptimizerError, SearchSpace};
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};

use super::{
    axes::{SHORT_S, wide_prior},
    effort::Spent,
    graduated::{Schedule, graduated},
    loss::{HUBER, Loss, TUKEY},
    population::Search,
    prior::Prior,
    readings::{Readings, Theta, identity},
    weak_form::{Equation, TEST_WINDOW_S, WeakForm, equations, nominal_sigma},
};

/// theta and the three angles of a small turn of the frame.
type Fifteen = SVector<f64, 15>;

/// Equations of a window for any frame of the magnetometer: the field's are linear in the rotation's nine
/// elements.
pub(super) struct FreeFrame<'a> {
    gravity: Vec<Equation>,
    /// `elements[3 i + j]`: equations of a field that lies along axis i and reads what axis j of the
    /// magnetometer reads.
    elements: Vec<Vec<Equation>>,
    prior: &'a Prior,
    sigma: [f64; 2],
}

/// Result of a method, and its Tukey cost.
pub(super) struct Framed {
    pub theta: Theta,
    cost: f64,
}

impl<'a> FreeFrame<'a> {
    pub fn new(readings: &Readings, prior: &'a Prior) -> Self {
        let of_sensor = |readings: &Readings, sensor: usize| -> Vec<Equation> {
            let all = equations(readings, &identity(), TEST_WINDOW_S);
            all.into_iter().filter(|e| e.sensor == sensor).collect()
        };
        let element = |k: usize| {
            let mut one = readings.clone();
            for sample in &mut one.samples {
                let reading = sample.vectors[1][k % 3];
                sample.vectors[1] = Vector3::from_fn(|i, _| if i == k / 3 { reading } else { 0.0 });
            }
            of_sensor(&one, 1)
        };
        let sigma = nominal_sigma(readings.period_s, TEST_WINDOW_S[0]);
        Self { gravity: of_sensor(readings, 0), elements: (0..9).map(element).collect(), prior, sigma }
    }

    /// The field's equations `rows` theta = `right` of a test window when `map` takes its readings to the
    /// body's axes.
    fn field(&self, index: usize, map: &Matrix3<f64>) -> (SMatrix<f64, 3, 12>, Vector3<f64>) {
        let mut sum = (SMatrix::zeros(), Vector3::zeros());
        for (k, element) in self.elements.iter().enumerate() {
            let (factor, equation) = (map[(k / 3, k % 3)], &element[index]);
            sum.0 += equation.rows * factor;
            sum.1 += equation.right * factor;
        }
        sum
    }

    /// The problem with the frame fixed.
    fn fixed(&self, to_body: &Matrix3<f64>) -> WeakForm<'a> {
        let pairs = self.gravity.iter().enumerate().flat_map(|(index, gravity)| {
            let (rows, right) = self.field(index, to_body);
            [gravity.clone(), Equation { rows, right, sensor: 1, hit: gravity.hit }]
        });
        WeakForm { equations: pairs.collect(), sigma: self.sigma, prior: self.prior, coupled: true }
    }

    /// One Gauss-Newton step in theta and the frame with these weights.
    fn step(&self, loss: Loss, theta: &mut Theta, to_body: &mut Matrix3<f64>) {
        let problem = self.fixed(to_body);
        let weights = problem.weights(loss, theta);
        let mut normal = SMatrix::<f64, 15, 15>::zeros();
        let mut descent = Fifteen::zeros();
        let information = self.prior.information();
        normal.fixed_view_mut::<12, 12>(0, 0).copy_from(&information);
        descent.fixed_rows_mut::<12>(0).copy_from(&(information * (self.prior.mean - *theta)));
        for (index, (equation, weight)) in problem.equations.iter().zip(&weights).enumerate() {
            let mut rows = SMatrix::<f64, 3, 15>::zeros();
            rows.fixed_view_mut::<3, 12>(0, 0).copy_from(&equation.rows);
            if equation.sensor == 1 {
                for axis in 0..3 {
                    let turn = Vector3::ith(axis, 1.0).cross_matrix() * *to_body;
                    let (slope, right) = self.field(index / 2, &turn);
                    rows.set_column(12 + axis, &(slope * *theta - right));
                }
            }
            let sigma = self.sigma[equation.sensor];
            let residual = equation.right - equation.rows * *theta;
            let transposed = rows.transpose() * (weight / (sigma * sigma));
            normal += transposed * rows;
            descent += transposed * residual;
        }
        // A linearised step of a whole radian is not to be believed.
        for k in 12..15 {
            normal[(k, k)] += 1.0;
        }
        if let Some(factor) = normal.cholesky() {
            let step = factor.solve(&descent);
            *theta += step.fixed_rows::<12>(0);
            let turn = Vector3::new(step[12], step[13], step[14]);
            *to_body = Rotation3::from_scaled_axis(turn).matrix() * *to_body;
        }
    }

    /// Fifteen unknowns from a frame: the recipe for theta, then Gauss-Newton steps on all of them.
    pub fn refined(&self, mut to_body: Matrix3<f64>, spent: &mut Spent) -> Framed {
        let mut theta = self.inner(&to_body, 4, spent);
        let losses = [(Loss::Huber(HUBER), 8), (Loss::GemanMcClure(2.0, 1.0), 6), (Loss::Tukey(TUKEY), 4)];
        for (loss, steps) in losses {
            for _ in 0..steps {
                self.step(loss, &mut theta, &mut to_body);
                spent.solve();
            }
        }
        let cost = self.fixed(&to_body).cost(Loss::Tukey(TUKEY), &theta);
        Framed { theta, cost }
    }

    /// theta by a few Huber solves with the frame fixed.
    fn inner(&self, to_body: &Matrix3<f64>, solves: u32, spent: &mut Spent) -> Theta {
        let problem = self.fixed(to_body);
        let start = problem.unweighted(spent);
        super::graduated::reweighted(&problem, Loss::Huber(HUBER), start, solves, spent)
    }
}

/// Way to find the frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Frame {
    /// Known: the standard that the others are measured by.
    Known,
    /// Taken as aligned, not refined.
    Aligned,
    /// Refined from aligned.
    Refined,
    /// A linear solve of the field alone with a wide prior: its P is the rotation times nearly the identity.
    Linear,
    /// The best of the 24 turns of a cube, each refined.
    Cube,
    /// A search over the rotation vector, solving for theta at each point, refined.
    Search(Search, u32),
}

/// The Tukey cost over the rotation vector, theta solved for (variable projection).
struct Projected<'a, 'b>(&'b FreeFrame<'a>);

impl Cost<3> for Projected<'_, '_> {
    fn evaluate(&self, x: &[f32; 3]) -> f32 {
        let to_body = Rotation3::from_scaled_axis(Vector3::from(x.map(f64::from))).into_inner();
        let theta = self.0.inner(&to_body, 1, &mut Spent::default());
        self.0.fixed(&to_body).cost(Loss::Tukey(TUKEY), &theta) as f32
    }
}

impl Frame {
    pub fn find(
        self,
        readings: &Readings,
        prior: &Prior,
        truth: &Matrix3<f64>,
        seed: u64,
        spent: &mut Spent,
    ) -> Result<Framed, OptimizerError> {
        let free = FreeFrame::new(readings, prior);
        Ok(match self {
            Self::Known => free.refined(*truth, spent),
            Self::Aligned => {
                let to_body = Matrix3::identity();
                let theta = graduated(&free.fixed(&to_body), Schedule::POLISHED, spent);
                Framed { theta, cost: f64::INFINITY }
            }
            Self::Refined => free.refined(Matrix3::identity(), spent),
            Self::Linear => free.refined(turn_of_field_alone(readings, spent), spent),
            Self::Cube => {
                let all = super::axes::signed_permutations();
                let turns = all.into_iter().filter(|turn| turn.determinant() > 0.0);
                let found = turns.map(|turn| free.refined(turn, spent));
                let best = found.min_by(|a, b| a.cost.total_cmp(&b.cost));
                best.unwrap_or(Framed { theta: prior.mean, cost: f64::INFINITY })
            }
            Self::Search(search, most) => {
                let pi = std::f32::consts::PI;
                let space = SearchSpace::within([-pi; 3], [pi; 3])?;
                let best = search.best(&Projected(&free), &space, most, seed)?;
                spent.evaluations += 3 * most;
                spent.matrices += 2 * most;
                free.refined(Rotation3::from_scaled_axis(Vector3::from(best.map(f64::from))).into_inner(), spent)
            }
        })
    }
}

/// The field alone turns as the magnetometer does: its rate is Q P `w_raw` - Q c with the rotation Q from
/// body to magnetometer. A wide linear solve gives Q P, and P is nearly the identity, so Q is the nearest
/// rotation.
fn turn_of_field_alone(readings: &Readings, spent: &mut Spent) -> Matrix3<f64> {
    let prior = wide_prior();
    let all = equations(readings, &Theta::zeros(), SHORT_S);
    let equations = all.into_iter().filter(|e| e.sensor == 1).collect();
    let sigma = nominal_sigma(readings.period_s, SHORT_S[0]);
    let problem = WeakForm { equations, sigma, prior: &prior, coupled: false };
    let theta = graduated(&problem, Schedule::POLISHED, spent);
    let product = Matrix3::from_fn(|i, j| theta[3 * i + j]);
    nearest_rotation(&product).transpose()
}

/// The rotation nearest to a matrix (Kabsch).
fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let sign = (u * v_t).determinant();
    u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t
}

/// The readings of a magnetometer whose axes `truth` takes back to the body's.
pub(super) fn turned_readings(mut readings: Readings, truth: &Matrix3<f64>) -> Readings {
    for sample in &mut readings.samples {
        sample.vectors[1] = truth.transpose() * sample.vectors[1];
    }
    readings
}
