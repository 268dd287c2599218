use super::node::carried;
use super::{NodeVectors, Preintegrated};
use nalgebra::Vector3;

/// One vector seen at both ends of a segment, as unit vectors in the body frame at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sighting {
    /// The vector of the beginning, carried to the end by the pre-integrated rotation at theta0.
    pub predicted: Vector3<f32>,
    /// The vector measured at the end.
    pub measured: Vector3<f32>,
}

/// What the objective needs of one second: the rotation's Jacobian and up to two vectors. 208 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// d(rotation vector at the end)/d(P row-major, c), 3 x 12.
    pub jacobian: [[f32; 12]; 3],
    pub gravity: Option<Sighting>,
    pub field: Option<Sighting>,
    /// Whether the tool turned: rest and motion have noise scales of their own.
    pub moving: bool,
}

impl Segment {
    pub const fn zero() -> Self {
        Self { jacobian: [[0.0; 12]; 3], gravity: None, field: None, moving: false }
    }

    pub fn new(rotation: &Preintegrated, from: &NodeVectors, to: &NodeVectors, moving_rate_rad_s: f32) -> Self {
        let sighting = |from: Option<Vector3<f32>>, to: Option<Vector3<f32>>| {
            Some(Sighting { predicted: carried(&rotation.rotation, &from?), measured: to? })
        };
        Self {
            jacobian: rotation.jacobian,
            gravity: sighting(from.gravity, to.gravity),
            field: sighting(from.field, to.field),
            moving: rotation.rate_rms_rad_s > moving_rate_rad_s,
        }
    }
}
