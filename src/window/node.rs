use super::{Grid, IncrementRing};
use crate::rotation::{exp_quaternion, rotate, rotate_back};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Quaternion, Vector3};

/// What is taken off the vectors before they are averaged: effects that would otherwise bend P to fit them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VectorEffects {
    /// Lag of the magnetometer behind the gyro, seconds.
    pub mag_lag_s: f32,
    /// Hard iron, microtesla, body frame.
    pub hard_iron_ut: Vector3<f32>,
}

/// Gravity and field of one node, unit vectors in the body frame at the node's instant; `None` where readings are missing, or a rate
/// is suspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeVectors {
    pub gravity: Option<Vector3<f32>>,
    pub field: Option<Vector3<f32>>,
}

/// Share of the Hann weight that has to be read for a mean to stand.
const LEAST_WEIGHT: f32 = 0.9;

/// Specific force under a third of gravity has no usable direction of gravity (free fall), m/s^2.
const LEAST_GRAVITY_M_S2: f32 = 3.3;

/// A field under a tenth of the weakest on earth (22 microtesla) is no field.
const LEAST_FIELD_UT: f32 = 2.2;

/// Hann means over +-0.5 s around increment `centre`, of vectors DE-ROTATED to the middle of that increment by w = P w_raw - c.
/// A body-frame low-pass would smear them: the body turns 150 deg/s.
pub(crate) fn node_vectors<const N: usize>(
    ring: &IncrementRing<N>,
    grid: Grid,
    centre: u32,
    (p, c): (&Matrix3<f32>, &Vector3<f32>),
    effects: &VectorEffects,
) -> NodeVectors {
    let nothing = NodeVectors { gravity: None, field: None };
    let half = grid.increments_in(0.5);
    let mut sums = Means::zero();
    let here = ring.get(centre);
    let Some(here_raw) = here.rate else { return nothing };
    let here_rate = p * here_raw - c;
    sums.add(&here.gravity, &here.field, &Quaternion::identity(), &here_rate, 1.0, effects);
    for forward in [true, false] {
        let mut q = Quaternion::identity();
        let mut rate = here_rate;
        for step in 1..=half {
            let increment = ring.get(if forward { centre + step as u32 } else { centre - step as u32 });
            let Some(raw) = increment.rate else { return nothing };
            let next = p * raw - c;
            let turn = (rate + next) * (0.5 * grid.interval_s());
            // q takes a vector at this increment into the frame at the centre.
            q *= exp_quaternion(&if forward { turn } else { -turn });
            rate = next;
            let weight = 0.5 + 0.5 * cosine(PI * step as f32 / (half + 1) as f32);
            sums.add(&increment.gravity, &increment.field, &q, &rate, weight, effects);
        }
    }
    // The Hann weights sum to half + 1.
    let least = LEAST_WEIGHT * (half + 1) as f32;
    let unit = |sum: Vector3<f32>, weight: f32, least_norm: f32| {
        let norm = sum.norm();
        if weight >= least && norm > least_norm * weight { Some(sum / norm) } else { None }
    };
    NodeVectors {
        gravity: unit(sums.gravity, sums.gravity_weight, LEAST_GRAVITY_M_S2),
        field: unit(sums.field, sums.field_weight, LEAST_FIELD_UT),
    }
}

struct Means {
    gravity: Vector3<f32>,
    gravity_weight: f32,
    field: Vector3<f32>,
    field_weight: f32,
}

impl Means {
    fn zero() -> Self {
        Self { gravity: Vector3::zeros(), gravity_weight: 0.0, field: Vector3::zeros(), field_weight: 0.0 }
    }

    fn add(
        &mut self,
        gravity: &Option<Vector3<f32>>,
        field: &Option<Vector3<f32>>,
        q: &Quaternion<f32>,
        rate: &Vector3<f32>,
        weight: f32,
        effects: &VectorEffects,
    ) {
        if let Some(gravity) = gravity {
            self.gravity += rotate(q, gravity) * weight;
            self.gravity_weight += weight;
        }
        if let Some(field) = field {
            // Measured v(t - tau) + iron. The field at t is that of t - tau turned back by the body's rotation since:
            // first order in tau w, 0.5 % of the field at 10 ms and 600 deg/s.
            let clean = field - effects.hard_iron_ut;
            self.field += rotate(q, &(clean - rate.cross(&clean) * effects.mag_lag_s)) * weight;
            self.field_weight += weight;
        }
    }
}

/// cos x for 0 <= x <= pi, by the Taylor series to the 8th order about pi/2 after folding; error under 1e-6.
fn cosine(x: f32) -> f32 {
    let y = 0.5 * PI - x;
    let y2 = y * y;
    y * (1.0 - y2 * (1.0 / 6.0 - y2 * (1.0 / 120.0 - y2 * (1.0 / 5_040.0 - y2 / 362_880.0))))
}

/// Rotates an earth-fixed vector from the body frame before a rotation into the one after it.
pub(crate) fn carried(rotation: &Quaternion<f32>, v: &Vector3<f32>) -> Vector3<f32> {
    rotate_back(rotation, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::{Increment, Scales};

    #[test]
    fn the_hann_cosine_is_within_a_millionth() {
        for k in 0..=100 {
            let x = PI * k as f32 / 100.0;
            assert!((cosine(x) - libm::cosf(x)).abs() < 4e-6, "{x}");
        }
    }

    /// A steadily spinning body: every de-rotated sample is the same vector, so the mean is the vector at the centre.
    #[test]
    fn the_mean_of_a_spinning_body_is_the_vector_at_the_centre() {
        let grid = Grid::new(20_000);
        let mut ring = IncrementRing::<128>::zero();
        ring.start(Scales::new(40.0, 160.0, 1000.0));
        let rate = Vector3::new(0.4, -0.2, 2.6);
        let lag = 0.011;
        let iron = Vector3::new(4.0, -9.0, 2.0);
        let body = |t: f32, v: Vector3<f32>| nalgebra::Rotation3::from_scaled_axis(-rate * t) * v;
        for k in 0..100 {
            let t = (k - 50) as f32 * 0.02;
            let field = body(t - lag, Vector3::new(20.0, 3.0, 44.0)) + iron;
            ring.push(&Increment {
                rate: Some(rate),
                gravity: Some(body(t, Vector3::new(0.0, 9.81, 0.0))),
                field: Some(field),
            });
        }
        let effects = VectorEffects { mag_lag_s: lag, hard_iron_ut: iron };
        let nodes = node_vectors(&ring, grid, 50, (&Matrix3::identity(), &Vector3::zeros()), &effects);
        assert!((nodes.gravity.unwrap() - Vector3::y()).norm() < 2e-4);
        // The lag is taken off to first order: (tau w)^2 / 2 = 4e-4.
        assert!((nodes.field.unwrap() - Vector3::new(20.0, 3.0, 44.0).normalize()).norm() < 6e-4);
    }
}
