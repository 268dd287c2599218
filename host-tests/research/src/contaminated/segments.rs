//! One-second segments between nodes, implemented a second time: de-rotated Hann means, pre-integrated
//! rotations, Jacobians.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

use super::{
    loss::Loss,
    prior::Prior,
    readings::{Matrix12, Readings, Theta, add_gyro_rows},
};

/// One vector over one segment: at its start, carried to its end by the rotation at theta0, and as measured
/// at its end.
#[derive(Clone, Debug)]
pub(super) struct Sighting {
    /// Index of the segment, and of its Jacobian.
    pub segment: usize,
    /// 0 gravity, 1 field.
    pub sensor: usize,
    pub predicted: Vector3<f64>,
    pub measured: Vector3<f64>,
    /// True if a sample in it was hit; only the oracle may look.
    pub hit: bool,
}

/// Deviations of one component of gravity's and the field's residual over clean seconds of the simulated
/// drilling, rad, measured.
pub(super) const NOMINAL_SIGMA: [f64; 2] = [0.018, 0.000_75];

/// A window as segments about theta0.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    pub theta0: Theta,
    pub jacobians: Vec<SMatrix<f64, 3, 12>>,
    pub sightings: Vec<Sighting>,
}

impl Segments {
    /// Nodes every second from half a second on; segments between neighbours.
    pub fn new(readings: &Readings, theta0: &Theta) -> Self {
        let dt = readings.period_s;
        let (half, second) = ((0.5 / dt).round() as usize, (1.0 / dt).round() as usize);
        let attitudes = readings.attitudes(theta0);
        let nodes: Vec<usize> = (half..readings.samples.len().saturating_sub(half)).step_by(second).collect();
        let means: Vec<[Vector3<f64>; 2]> =
            nodes.iter().map(|&node| node_means(readings, &attitudes, node, half)).collect();
        let mut segments = Self { theta0: *theta0, jacobians: Vec::new(), sightings: Vec::new() };
        for (pair, mean) in nodes.windows(2).zip(means.windows(2)) {
            let ([from, to], [before, after]) = (pair, mean) else { continue };
            let turned = attitudes[*to].transpose() * attitudes[*from];
            segments.push_sightings(readings, (*from, *to, half), &turned, before, after);
            segments.jacobians.push(jacobian(readings, &attitudes, *from, *to));
        }
        segments
    }

    fn push_sightings(
        &mut self,
        readings: &Readings,
        (from, to, half): (usize, usize, usize),
        turned: &Matrix3<f64>,
        before: &[Vector3<f64>; 2],
        after: &[Vector3<f64>; 2],
    ) {
        let samples = readings.samples.get(from - half..=to + half).unwrap_or_default();
        for sensor in 0..2 {
            self.sightings.push(Sighting {
                segment: self.jacobians.len(),
                sensor,
                predicted: turned * before[sensor],
                measured: after[sensor],
                hit: samples.iter().any(|s| s.hit[0] || s.hit[1 + sensor]),
            });
        }
    }
}

/// Hann means over half a second to each side, de-rotated to the node, of length 1.
fn node_means(readings: &Readings, attitudes: &[Matrix3<f64>], node: usize, half: usize) -> [Vector3<f64>; 2] {
    let mut sums = [Vector3::zeros(); 2];
    let samples = readings.samples.iter().zip(attitudes).enumerate();
    for (k, (sample, attitude)) in samples.take(node + half + 1).skip(node - half) {
        let weight = 0.5 + 0.5 * libm::cos(PI * (k as f64 - node as f64) / (half as f64 + 1.0));
        for (sum, v) in sums.iter_mut().zip(&sample.vectors) {
            *sum += attitude * v * weight;
        }
    }
    sums.map(|sum| attitudes[node].transpose() * sum.normalize())
}

/// J, so that R(theta) = R(theta0) Exp(J (theta - theta0)) from one node to the next.
fn jacobian(readings: &Readings, attitudes: &[Matrix3<f64>], from: usize, to: usize) -> SMatrix<f64, 3, 12> {
    let mut rows = SMatrix::zeros();
    for k in from..=to {
        let weight = if k == from || k == to { 0.5 } else { 1.0 };
        let gain = attitudes[to].transpose() * attitudes[k] * (weight * readings.period_s);
        add_gyro_rows(&mut rows, &gain, &readings.samples[k].raw);
    }
    rows
}

/// The robust cost of the segments, as a function of theta - theta0.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentCost<'a> {
    pub segments: &'a Segments,
    /// Standard deviation of one component of gravity's and the field's residual, rad.
    pub sigma: [f64; 2],
    pub prior: &'a Prior,
    pub loss: Loss,
}

impl SegmentCost<'_> {
    fn turns(&self, delta: &Theta) -> Vec<Rotation3<f64>> {
        // The frame turns one way, so a vector turns the other.
        self.segments.jacobians.iter().map(|j| Rotation3::from_scaled_axis(-(j * delta))).collect()
    }

    /// Squared norms of the residuals in standard deviations.
    pub fn squares(&self, delta: &Theta) -> Vec<f64> {
        let turns = self.turns(delta);
        let square = |s: &Sighting| {
            let residual = s.measured - turns[s.segment] * s.predicted;
            residual.norm_squared() / (self.sigma[s.sensor] * self.sigma[s.sensor])
        };
        self.segments.sightings.iter().map(square).collect()
    }

    pub fn evaluate(&self, delta: &Theta) -> f64 {
        let data: f64 = self.squares(delta).into_iter().map(|square| self.loss.value(square)).sum();
        data + self.prior.cost(&(self.segments.theta0 + delta))
    }

    /// Gauss-Newton matrix and direction of descent.
    pub fn normal(&self, delta: &Theta) -> (Matrix12, Theta) {
        let turns = self.turns(delta);
        let mut normal = self.prior.information();
        let mut descent = normal * (self.prior.mean - self.segments.theta0 - delta);
        for s in &self.segments.sightings {
            let carried = turns[s.segment] * s.predicted;
            let residual = s.measured - carried;
            let information = 1.0 / (self.sigma[s.sensor] * self.sigma[s.sensor]);
            let weight = information * self.loss.weight(residual.norm_squared() * information);
            if weight > 0.0 {
                let rows = carried.cross_matrix() * self.segments.jacobians[s.segment];
                let transposed = rows.transpose() * weight;
                normal.gemm(1.0, &transposed, &rows, 1.0);
                descent.gemv(1.0, &transposed, &residual, 1.0);
            }
        }
        (normal, descent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contaminated::{prior::Prior, readings::identity, weak_form::tests::noiseless};

    #[test]
    fn the_descent_is_minus_the_slope_of_the_cost() {
        let (readings, _) = noiseless();
        let (segments, prior) = (Segments::new(&readings, &identity()), Prior::data_sheet());
        for loss in [Loss::Square, Loss::Huber(2.35), Loss::Tukey(1e3)] {
            let cost = SegmentCost { segments: &segments, sigma: [0.02, 0.001], prior: &prior, loss };
            let delta = Theta::from_fn(|i, _| 2e-3 * f64::from(i as u8 % 5) - 3e-3);
            let (_, descent) = cost.normal(&delta);
            for i in 0..12 {
                let step = Theta::from_fn(|k, _| if k == i { 1e-6 } else { 0.0 });
                let slope = (cost.evaluate(&(delta + step)) - cost.evaluate(&(delta - step))) / 2e-6;
                // The Jacobian is that of theta0: what remains is second order in delta.
                assert!((slope + descent[i]).abs() < 0.03 * descent.amax(), "{loss:?} {i}: {slope} {}", descent[i]);
            }
        }
    }

    #[test]
    fn at_the_truth_nothing_is_left() {
        let (readings, truth) = noiseless();
        let segments = Segments::new(&readings, &truth);
        let worst = segments.sightings.iter().map(|s| (s.measured - s.predicted).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
    }
}
