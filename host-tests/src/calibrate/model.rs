//! Model of a vector sensor's nine errors that its norm shows, relative to the values on record.

use meerkat_mwd::compensation::VectorModel;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Number of parameters.
pub const PARAMETERS: usize = 9;

/// A symmetric S (three scales, three cross terms, dimensionless) and three offsets in the sensor's unit:
/// `v = (I + S) M (raw - o - offset)`, with M and o on record. S is symmetric because a norm shows no
/// rotation: of all matrices with the same norms it turns the axes least.
pub type Parameters = SVector<f64, PARAMETERS>;
/// Covariance of the parameters.
pub type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Names of the parameters.
pub const NAMES: [&str; PARAMETERS] =
    ["scale_x", "scale_y", "scale_z", "cross_xy", "cross_xz", "cross_yz", "offset_x", "offset_y", "offset_z"];

/// Row and column of each cross term.
const CROSSES: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// A vector sensor's model in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// M, dimensionless.
    pub matrix: Matrix3<f64>,
    /// Offset, subtracted before M, in the sensor's unit.
    pub offset: Vector3<f64>,
}

impl From<VectorModel> for Model {
    fn from(model: VectorModel) -> Self {
        let rows = model.matrix.map(|row| row.map(f64::from));
        Self {
            matrix: Matrix3::from_fn(|row, column| rows[row][column]),
            offset: Vector3::from(model.offset.map(f64::from)),
        }
    }
}

impl From<Model> for VectorModel {
    fn from(model: Model) -> Self {
        Self {
            matrix: std::array::from_fn(|row| std::array::from_fn(|column| model.matrix[(row, column)] as f32)),
            offset: std::array::from_fn(|axis| model.offset[axis] as f32),
        }
    }
}

impl Model {
    /// The calibrated vector.
    #[must_use]
    pub fn calibrate(&self, raw: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * (raw - self.offset)
    }

    /// This model corrected by errors `x`.
    #[must_use]
    pub fn corrected(&self, x: &Parameters) -> Self {
        Self {
            matrix: (Matrix3::identity() + symmetric(x)) * self.matrix,
            offset: self.offset + Vector3::new(x[6], x[7], x[8]),
        }
    }

    /// Derivative of the calibrated vector by each parameter, for a `record` that `x` corrected into this
    /// model.
    #[must_use]
    pub fn sensitivity(&self, record: &Self, raw: &Vector3<f64>) -> SMatrix<f64, 3, PARAMETERS> {
        let before = record.matrix * (raw - self.offset);
        let mut change = SMatrix::<f64, 3, PARAMETERS>::zeros();
        for k in 0..3 {
            change[(k, k)] = before[k];
        }
        for (k, (i, j)) in CROSSES.into_iter().enumerate() {
            change[(i, 3 + k)] = before[j];
            change[(j, 3 + k)] = before[i];
        }
        change.fixed_view_mut::<3, 3>(0, 6).copy_from(&-self.matrix);
        change
    }
}

fn symmetric(x: &Parameters) -> Matrix3<f64> {
    let mut s = Matrix3::from_diagonal(&Vector3::new(x[0], x[1], x[2]));
    for (k, (i, j)) in CROSSES.into_iter().enumerate() {
        s[(i, j)] = x[3 + k];
        s[(j, i)] = x[3 + k];
    }
    s
}
