use super::robust_loss::{huber, huber_weight};
use crate::{
    algebra::{Packed, add_scaled, dot, quantile},
    identification::Prior,
    optimizer::{Cost, LeastSquaresCost},
};
use nalgebra::{Matrix3, Vector3};

/// The innovations of one sensor over some seconds, as a quadratic in delta: sum of squares s + 2 h' delta + delta' N delta, in their
/// variances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    normal: Packed<12, 78>,
    /// Half the slope at 0.
    slope: [f32; 12],
    square: f32,
    /// Independent components in it.
    pub count: f32,
}

impl Stretch {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self { normal: Packed::zero(), slope: [0.0; 12], square: 0.0, count: 0.0 }
    }

    /// Adds an innovation r + rows delta with its information.
    pub fn add(&mut self, rows: &[[f32; 12]; 3], r: &Vector3<f32>, information: f32) {
        self.normal.add_outers(rows, information);
        for (row, r) in rows.iter().zip(r.iter()) {
            add_scaled(&mut self.slope, row, information * r);
        }
        self.square += information * r.norm_squared();
    }

    /// The normal matrix of c alone and its direction of descent at `delta`, P being what it is there.
    pub fn bias_equations(&self, delta: &[f32; 12]) -> (Matrix3<f32>, Vector3<f32>) {
        let weight = self.weight(delta);
        let product = self.normal.times(delta);
        let mut descent = Vector3::zeros();
        for ((d, slope), product) in descent.iter_mut().zip(self.slope.iter().skip(9)).zip(product.iter().skip(9)) {
            *d = -weight * (slope + product);
        }
        (Matrix3::from_fn(|i, j| weight * self.normal.get(9 + i, 9 + j)), descent)
    }

    /// Of its equations, robust.
    fn weight(&self, delta: &[f32; 12]) -> f32 {
        huber_weight(self.square_at(delta, &Packed::monomials(delta)), self.count)
    }

    /// Sum of squares at `delta`, whose monomials are given.
    fn square_at(&self, delta: &[f32; 12], monomials: &Packed<12, 78>) -> f32 {
        let square = self.square + 2.0 * dot(&self.slope, delta) + self.normal.quadratic_of(monomials);
        // Cancellation can leave a small negative number.
        if square > 0.0 { square } else { 0.0 }
    }
}

/// Objective of the search: over the stretches of a window, the robust squared innovations of gravity and field, plus the prior.
///
/// Gravity and field stand still in the earth (the paper's eq 5 asks it of gravity alone and over the whole window), so, carried by
/// the candidate's rotation into the frame of the beginning, each node's vector is the one before, but for the node's own noise and the gyro's.
/// A filter of one vector per sensor predicts it from all nodes before, as a Kalman filter would: then innovations are
/// independent, what they say adds up to all that the window holds, and its inverse is the uncertainty.
///
/// The unknown is delta = theta - theta0, theta0 being where the nodes were made; the least-squares point is within a few deviations,
/// where the innovations are linear in it.
pub(crate) struct Innovations<'a> {
    pub stretches: &'a [Stretch],
    pub prior: &'a Prior,
    pub theta0: &'a [f32; 12],
}

/// Adds the (re-weighted) normal equations of stretches at `delta`.
pub(crate) fn add_equations<'a>(
    stretches: impl IntoIterator<Item = &'a Stretch>,
    delta: &[f32; 12],
    normal: &mut Packed<12, 78>,
    descent: &mut [f32; 12],
) {
    for stretch in stretches {
        let weight = stretch.weight(delta);
        normal.add_scaled(&stretch.normal, weight);
        for ((d, slope), product) in descent.iter_mut().zip(&stretch.slope).zip(stretch.normal.times(delta)) {
            *d -= weight * (slope + product);
        }
    }
}

impl Cost<12> for Innovations<'_> {
    fn evaluate(&self, delta: &[f32; 12]) -> f32 {
        // Made once for all stretches.
        let monomials = Packed::monomials(delta);
        let of = |stretch: &Stretch| huber(stretch.square_at(delta, &monomials), stretch.count);
        let data: f32 = self.stretches.iter().map(of).sum();
        data + self.prior.cost(self.theta0, delta)
    }
}

impl LeastSquaresCost<12, 78> for Innovations<'_> {
    fn normal_equations(&self, delta: &[f32; 12], normal: &mut Packed<12, 78>, descent: &mut [f32; 12]) {
        *normal = self.prior.information;
        *descent = self.prior.descent(self.theta0, delta);
        add_equations(self.stretches, delta, normal, descent);
    }
}

/// Most stretches of one sensor in a window.
pub(crate) const STRETCHES: usize = 10;

/// Scales the variances of one sensor's stretches to what they show: the median over the stretches of the mean square.
pub(crate) fn rescale(stretches: &mut [Stretch]) {
    let mut mean_squares = [0.0; STRETCHES];
    let mut count = 0;
    for stretch in stretches.iter().filter(|stretch| stretch.count > 0.0) {
        if let Some(slot) = mean_squares.get_mut(count) {
            *slot = stretch.square / stretch.count;
            count += 1;
        }
    }
    let median = quantile(mean_squares.get_mut(..count).unwrap_or_default(), 0.5);
    if median > 0.0 {
        for stretch in stretches {
            stretch.normal.scale(1.0 / median);
            for slope in &mut stretch.slope {
                *slope /= median;
            }
            stretch.square /= median;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{compensation::GyroModel, config::IdentificationConfig};
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const THETA: [f32; 12] = [1.02, 0.01, 0.0, 0.0, 0.98, 0.0, -0.02, 0.0, 1.01, 0.01, 0.0, -0.01];

    fn deviate(generator: &mut Xoshiro128PlusPlus) -> f32 {
        generator.next_u32() as f32 / (u32::MAX / 2) as f32 - 1.0
    }

    /// Stretches of 24 innovations of three components with a deviation of `sigma`, stated to be 1e-2.
    fn stretches(generator: &mut Xoshiro128PlusPlus, sigma: f32) -> [Stretch; 6] {
        [Stretch::zero(); 6].map(|mut stretch| {
            for _ in 0..24 {
                let rows = [[0.0; 12]; 3].map(|row| row.map(|_: f32| deviate(generator)));
                // Uniform deviates have a third of the variance.
                let r = Vector3::from([0.0; 3].map(|_: f32| 1.732 * sigma * deviate(generator)));
                stretch.add(&rows, &r, 1e4);
                stretch.count += 3.0;
            }
            stretch
        })
    }

    fn prior() -> Prior {
        Prior::new(&IdentificationConfig::default(), &GyroModel::IDENTITY, None)
    }

    /// Near the bottom, where all is quadratic, and far off, where the loss is linear.
    #[test]
    fn the_descent_is_minus_the_slope_of_the_cost() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
        let (mut stretches, prior) = (stretches(&mut generator, 1e-2), prior());
        rescale(&mut stretches);
        let objective = Innovations { stretches: &stretches, prior: &prior, theta0: &THETA };
        for size in [0.0, 3e-3, 0.1] {
            let delta = [0.0; 12].map(|_: f32| size * deviate(&mut generator));
            let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
            objective.normal_equations(&delta, &mut normal, &mut descent);
            for parameter in 0..12 {
                let step = if size > 0.01 { 0.03 * size } else { 1e-3 };
                let at = |sign: f32| {
                    let mut moved = delta;
                    moved[parameter] += sign * step;
                    f64::from(objective.evaluate(&moved))
                };
                let slope = ((at(1.0) - at(-1.0)) / (2.0 * f64::from(step))) as f32;
                let scale = libm::sqrtf(normal.get(parameter, parameter)) + slope.abs();
                assert!(
                    (slope + descent[parameter]).abs() < 0.02 * scale,
                    "{size} {parameter}: {slope} {}",
                    descent[parameter]
                );
            }
        }
    }

    /// Where no stretch is beyond its limit the normal matrix is the cost's second derivative.
    #[test]
    fn the_normal_matrix_is_the_curvature_of_the_cost() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(2);
        let (mut stretches, prior) = (stretches(&mut generator, 1e-2), prior());
        rescale(&mut stretches);
        let objective = Innovations { stretches: &stretches, prior: &prior, theta0: &THETA };
        let mut normal = Packed::zero();
        objective.normal_equations(&[0.0; 12], &mut normal, &mut [0.0; 12]);
        let middle = f64::from(objective.evaluate(&[0.0; 12]));
        for _ in 0..12 {
            let step = [0.0; 12].map(|_: f32| 2e-3 * deviate(&mut generator));
            let ends = [1.0, -1.0].map(|sign: f32| f64::from(objective.evaluate(&step.map(|x| sign * x))));
            let curvature = (ends[0] + ends[1] - 2.0 * middle) as f32;
            assert!(
                (curvature / normal.quadratic(&step) - 1.0).abs() < 0.02,
                "{curvature} {}",
                normal.quadratic(&step)
            );
        }
    }

    #[test]
    fn rescaling_brings_the_mean_square_to_one_whatever_was_stated_and_a_bad_stretch_does_not_move_it() {
        for sigma in [1e-3, 1e-2, 0.3] {
            let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
            let mut stretches = stretches(&mut generator, sigma);
            stretches[2].square *= 1e4;
            stretches[4] = Stretch::zero();
            rescale(&mut stretches);
            for number in [0, 1, 3, 5] {
                let mean = stretches[number].square / stretches[number].count;
                assert!((mean - 1.0).abs() < 0.5, "{sigma}: {mean}");
            }
            let mut means = [0, 1, 2, 3, 5].map(|k: usize| stretches[k].square / stretches[k].count);
            assert!((quantile(&mut means, 0.5) - 1.0).abs() < 1e-5);
            assert!(stretches[2].weight(&[0.0; 12]) < 0.05 * stretches[0].weight(&[0.0; 12]));
        }
    }

    #[test]
    fn without_innovations_there_is_only_the_prior() {
        let mut stretches = [Stretch::zero(); STRETCHES];
        rescale(&mut stretches);
        let prior = prior();
        let objective = Innovations { stretches: &stretches, prior: &prior, theta0: &THETA };
        let delta = [0.01; 12];
        assert_eq!(objective.evaluate(&delta), prior.cost(&THETA, &delta));
        let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
        objective.normal_equations(&delta, &mut normal, &mut descent);
        assert_eq!(descent, prior.descent(&THETA, &delta));
        let (bias_normal, bias_descent) = Stretch::zero().bias_equations(&delta);
        assert_eq!((bias_normal, bias_descent), (Matrix3::zeros(), Vector3::zeros()));
    }

    #[test]
    fn the_equations_of_the_bias_are_the_last_three_of_all() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(4);
        let mut stretches = stretches(&mut generator, 1e-2);
        rescale(&mut stretches);
        let [stretch, ..] = stretches;
        // The further, the less it weighs.
        for (size, weighs) in [(1e-3, 1.0), (0.3, 0.2)] {
            let delta = [0.0; 12].map(|_: f32| size * deviate(&mut generator));
            assert!(stretch.weight(&delta) < 1.2 * weighs);
            let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
            add_equations([&stretch], &delta, &mut normal, &mut descent);
            let (bias_normal, bias_descent) = stretch.bias_equations(&delta);
            for i in 0..3 {
                assert!((bias_descent[i] - descent[9 + i]).abs() < 1e-3 * descent[9 + i].abs() + 1.0);
                for j in 0..3 {
                    assert!((bias_normal[(i, j)] - normal.get(9 + i, 9 + j)).abs() < 1e-3 * normal.get(9, 9));
                }
            }
        }
    }
}
