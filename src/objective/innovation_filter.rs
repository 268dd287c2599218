#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::Stretch;
use crate::window::Node;
use nalgebra::Vector3;

/// An innovation beyond so many of its deviations is no noise, and does not move the filter: it is disturbed.
const DISTURBED_SIGMAS: f32 = 6.0;

/// After so many disturbed nodes in a row (two seconds) the filter begins anew: not the vector but what carried it was disturbed.
const PATIENCE: u32 = 10;

/// Noise of a window's vectors and of its gyro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Variance of one component of a node's gravity, (m/s^2)^2, and field, microtesla^2.
    pub vectors: [f32; 2],
    /// What the gyro's noise adds to the variance of the rotation from one node to the next, rad^2.
    pub walk: f32,
}

/// Predicts each node's vector of one sensor from all nodes before, as a Kalman filter would, with the prediction's slopes in theta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InnovationFilter {
    predicted: Vector3<f32>,
    slopes: [[f32; 12]; 3],
    /// Of a component of what is predicted; `None`: nothing is.
    variance: Option<f32>,
    disturbed: u32,
}

impl InnovationFilter {
    pub const fn start() -> Self {
        Self { predicted: Vector3::new(0.0, 0.0, 0.0), slopes: [[0.0; 12]; 3], variance: None, disturbed: 0 }
    }

    /// The node that comes is not to be trusted: it is not taken, and if the next one is disturbed, what carried the vector was.
    pub const fn distrust(&mut self) {
        self.disturbed = PATIENCE - 1;
    }

    /// Takes a node, `sensor` 0 being gravity and 1 the field; adds its innovation to `stretch`. Returns whether it began anew because too
    /// many nodes were disturbed.
    pub fn take(&mut self, node: &Node, sensor: usize, noise: &Noise, stretch: &mut Stretch) -> bool {
        self.variance = self.variance.filter(|_| !node.broken).map(|variance| variance + noise.walk);
        let Some((vector, norm)) = node.vectors[sensor] else { return false };
        let own = noise.vectors[sensor] / (norm * norm);
        let mut begun_anew = false;
        if let Some(variance) = self.variance {
            let innovation = vector - self.predicted;
            let information = 1.0 / (variance + own);
            if innovation.norm_squared() * information <= DISTURBED_SIGMAS * DISTURBED_SIGMAS {
                self.disturbed = 0;
                self.learn(node, &vector, &innovation, variance * information, information, stretch);
                self.variance = Some((1.0 - variance * information) * variance);
                return false;
            }
            self.disturbed += 1;
            if self.disturbed < PATIENCE {
                return false;
            }
            begun_anew = true;
        }
        // The first vector is taken as it is: all of its innovation, and nothing to be learnt from it.
        *self = Self { variance: Some(own), ..Self::start() };
        self.learn(node, &vector, &vector, 1.0, 0.0, stretch);
        begun_anew
    }

    fn learn(
        &mut self,
        node: &Node,
        vector: &Vector3<f32>,
        innovation: &Vector3<f32>,
        gain: f32,
        information: f32,
        stretch: &mut Stretch,
    ) {
        self.predicted += innovation * gain;
        let mut rows = [[0.0; 12]; 3];
        for (axis, row) in rows.iter_mut().enumerate() {
            // d(vector)/d(delta) = -[vector]x S.
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let (up, down) = (vector[c], vector[b]);
            let sensitivities = node.sensitivity[b].iter().zip(&node.sensitivity[c]);
            for ((value, (s_b, s_c)), slope) in row.iter_mut().zip(sensitivities).zip(&mut self.slopes[axis]) {
                *value = up * s_b - down * s_c - *slope;
                *slope += gain * *value;
            }
        }
        if information > 0.0 {
            stretch.add(&rows, innovation, information);
            // A unit vector errs in two directions.
            stretch.count += 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const NORM: f32 = 50.0;
    const NOISE: Noise = Noise { vectors: [1.0, 0.25], walk: 4e-6 };

    /// Standard normal: the sum of twelve uniform deviates.
    fn normal(generator: &mut Xoshiro128PlusPlus) -> f32 {
        (0..12).map(|_| generator.next_u32() as f32 / u32::MAX as f32).sum::<f32>() - 6.0
    }

    fn node_of(field: Option<Vector3<f32>>) -> Node {
        Node {
            vectors: [None, field.map(|v| (v.normalize(), v.norm()))],
            sensitivity: [[0.0; 12]; 3],
            square_rate: 1.0,
            body: None,
            broken: false,
        }
    }

    /// A stretch's sum of squares at the model that the nodes were made with.
    fn square_of(stretch: &Stretch) -> f32 {
        use crate::{identification::Prior, objective::Innovations, optimizer::Cost};
        // Huber's loss is half the sum until far beyond its mean.
        let prior = Prior::zero();
        let lone = Innovations { stretches: core::slice::from_ref(stretch), prior: &prior, theta0: &[0.0; 12] };
        2.0 * lone.evaluate(&[0.0; 12])
    }

    /// Fields of a vector that walks about in the earth's frame as the gyro's noise carries it, with the sensor's noise on top.
    fn noisy(generator: &mut Xoshiro128PlusPlus, count: usize, mut take: impl FnMut(Node)) {
        let mut carried = Vector3::new(0.3, -0.4, 0.87).normalize() * NORM;
        let mut random = |sigma: f32| Vector3::from([0.0; 3].map(|_: f32| sigma * normal(generator)));
        for _ in 0..count {
            take(node_of(Some(carried + random(libm::sqrtf(NOISE.vectors[1])))));
            carried += random(libm::sqrtf(NOISE.walk)).cross(&carried);
        }
    }

    #[test]
    fn innovations_of_a_noisy_vector_are_white_and_as_large_as_stated() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(4);
        let (mut square, mut count, mut products) = (0.0, 0.0, 0.0);
        for _ in 0..60 {
            let mut filter = InnovationFilter::start();
            let mut stretch = Stretch::zero();
            let mut last = None;
            noisy(&mut generator, 25, |node| {
                let predicted = filter.variance.map(|variance| (filter.predicted, variance + NOISE.walk));
                assert!(!filter.take(&node, 1, &NOISE, &mut stretch));
                let Some((predicted, variance)) = predicted else { return };
                let (vector, norm) = node.vectors[1].unwrap();
                let deviation = libm::sqrtf(variance + NOISE.vectors[1] / (norm * norm));
                let now = (vector - predicted) / deviation;
                products += last.map_or(0.0, |last: Vector3<f32>| last.dot(&now));
                last = Some(now);
            });
            // The first vector is no innovation.
            assert_eq!(stretch.count, 48.0);
            square += square_of(&stretch);
            count += stretch.count;
        }
        // Of 2,880 components: the mean square errs by 2.6 %, the correlation by 1.9 %.
        assert!((square / count - 1.0).abs() < 0.1, "{}", square / count);
        assert!((products / count).abs() < 0.08, "{}", products / count);
    }

    #[test]
    fn a_single_disturbed_node_does_not_move_the_prediction() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
        let (mut filter, mut stretch) = (InnovationFilter::start(), Stretch::zero());
        noisy(&mut generator, 20, |node| assert!(!filter.take(&node, 1, &NOISE, &mut stretch)));
        let (before, count) = (filter, stretch.count);
        let joint = node_of(Some(Vector3::new(30.0, 30.0, -20.0)));
        assert!(!filter.take(&joint, 1, &NOISE, &mut stretch));
        assert_eq!((filter.predicted, filter.slopes), (before.predicted, before.slopes));
        assert_eq!((filter.disturbed, stretch.count), (1, count));
        // Nor does a node without a vector; the variance grows by the walk in each.
        assert!(!filter.take(&node_of(None), 1, &NOISE, &mut stretch));
        assert_eq!(filter.predicted, before.predicted);
        let grown = before.variance.unwrap() + 2.0 * NOISE.walk;
        assert!((filter.variance.unwrap() / grown - 1.0).abs() < 1e-5);
        // One that agrees ends the disturbance.
        assert!(!filter.take(&node_of(Some(before.predicted * NORM)), 1, &NOISE, &mut stretch));
        assert_eq!((filter.disturbed, stretch.count), (0, count + 2.0));
    }

    /// What carried the vector was disturbed, or only the vector: the first node that is trusted tells.
    #[test]
    fn after_nodes_that_are_not_trusted_the_first_that_is_begins_anew_or_goes_on() {
        for (jump, begins) in [(0.0_f32, false), (0.2, true)] {
            let mut generator = Xoshiro128PlusPlus::seed_from_u64(9);
            let (mut filter, mut stretch) = (InnovationFilter::start(), Stretch::zero());
            noisy(&mut generator, 20, |node| assert!(!filter.take(&node, 1, &NOISE, &mut stretch)));
            let count = stretch.count;
            for _ in 0..3 {
                filter.distrust();
                assert!(!filter.take(&node_of(None), 1, &NOISE, &mut stretch));
            }
            let after = nalgebra::Rotation3::from_scaled_axis(Vector3::new(jump, 0.0, 0.0)) * filter.predicted;
            assert_eq!(filter.take(&node_of(Some(after * NORM)), 1, &NOISE, &mut stretch), begins);
            assert_eq!(stretch.count, if begins { count } else { count + 2.0 });
        }
    }

    #[test]
    fn a_jump_that_lasts_begins_anew_once_and_says_so() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(6);
        let (mut filter, mut stretch) = (InnovationFilter::start(), Stretch::zero());
        let jump = nalgebra::Rotation3::from_scaled_axis(Vector3::new(0.2, 0.1, -0.2));
        let (mut number, mut begun) = (0, 0);
        noisy(&mut generator, 60, |mut node| {
            if number >= 20
                && let Some((vector, _)) = &mut node.vectors[1]
            {
                *vector = jump * *vector;
            }
            if filter.take(&node, 1, &NOISE, &mut stretch) {
                begun += 1;
                assert_eq!(number, 20 + PATIENCE - 1);
                assert_eq!(filter.predicted, node.vectors[1].unwrap().0);
            }
            number += 1;
        });
        assert_eq!(begun, 1);
        // All but the first, the disturbed and the one that it began anew with.
        assert_eq!(stretch.count, 2.0 * (60.0 - 1.0 - PATIENCE as f32));
        assert!(square_of(&stretch) < 1.5 * stretch.count);
    }

    #[test]
    fn after_a_broken_walk_the_first_vector_is_learnt_and_nothing_is_innovation() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
        let (mut filter, mut stretch) = (InnovationFilter::start(), Stretch::zero());
        noisy(&mut generator, 10, |node| assert!(!filter.take(&node, 1, &NOISE, &mut stretch)));
        let elsewhere = Node { broken: true, ..node_of(Some(Vector3::new(-40.0, 30.0, 0.0))) };
        let count = stretch.count;
        assert!(!filter.take(&elsewhere, 1, &NOISE, &mut stretch), "a break is known, not found out");
        assert_eq!((filter.predicted, stretch.count), (elsewhere.vectors[1].unwrap().0, count));
        assert_eq!(filter.variance, Some(NOISE.vectors[1] / 2500.0));
    }

    /// A change of theta turns each node's vector by its sensitivity; what the filter makes of the turned vectors is what its slopes
    /// say.
    #[test]
    fn slopes_are_the_finite_differences_of_the_prediction() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(8);
        let growth = [[0.0; 12]; 3].map(|row| row.map(|_: f32| normal(&mut generator)));
        let mut nodes = [node_of(None); 20];
        let mut slots = nodes.iter_mut().enumerate();
        noisy(&mut generator, 20, |node| {
            let (number, slot) = slots.next().unwrap();
            *slot = Node { sensitivity: growth.map(|row| row.map(|x| 0.2 * number as f32 * x)), ..node };
        });
        let after = |delta: &[f32; 12]| {
            let mut filter = InnovationFilter::start();
            for node in &nodes {
                let turn = Vector3::from(node.sensitivity.map(|row| crate::algebra::dot(&row, delta)));
                let (vector, norm) = node.vectors[1].unwrap();
                let turned = Node { vectors: [None, Some((vector + turn.cross(&vector), norm))], ..*node };
                assert!(!filter.take(&turned, 1, &NOISE, &mut Stretch::zero()));
            }
            filter
        };
        for parameter in 0..12 {
            let mut step = [0.0; 12];
            step[parameter] = 1e-3;
            let ahead = after(&step).predicted;
            step[parameter] = -1e-3;
            let difference = (ahead - after(&step).predicted) / 2e-3;
            let slope = Vector3::from(after(&[0.0; 12]).slopes.map(|row| row[parameter]));
            // The slope is that of the innovation's rows, which the prediction follows.
            assert!((difference - slope).norm() < 2e-2 * difference.norm() + 1e-3, "{parameter}: {difference} {slope}");
        }
    }
}
