//! Mounting of a part in the tool.

/// Mounting: the rotation of a part's axes into the body's, `body = C part`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    part_to_body: [[f32; 3]; 3],
}

/// Axis of a part, with its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[allow(missing_docs)] // The names say it.
pub enum Axis {
    PlusX,
    PlusY,
    PlusZ,
    MinusX,
    MinusY,
    MinusZ,
}

/// Reason to refuse a mounting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum MountingError {
    /// A row is not of length one, or two are not at right angles, by more than 0.001; or a number is not
    /// finite.
    NotOrthonormal,
    /// The matrix makes a right-handed part left-handed: an axis has the wrong sign, or two are exchanged.
    LeftHanded,
}

impl core::fmt::Display for MountingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotOrthonormal => "mounting: the rows are not orthonormal",
            Self::LeftHanded => "mounting: it is left-handed",
        })
    }
}

impl core::error::Error for MountingError {}

/// Tolerance of a product of two rows against 0 or 1: readings are then wrong by less than 0.1 %.
const ORTHONORMAL: f32 = 1e-3;

impl Mounting {
    /// Mounting of a part whose axes are the body's.
    pub const ALIGNED: Self = Self { part_to_body: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// Creates a mounting from the part's axes that point along the body's x, y and z.
    ///
    /// # Errors
    /// Rejects an axis that is named twice, and left-handed axes.
    pub fn from_axes(along: [Axis; 3]) -> Result<Self, MountingError> {
        Self::from_matrix(along.map(|axis| match axis {
            Axis::PlusX => [1.0, 0.0, 0.0],
            Axis::PlusY => [0.0, 1.0, 0.0],
            Axis::PlusZ => [0.0, 0.0, 1.0],
            Axis::MinusX => [-1.0, 0.0, 0.0],
            Axis::MinusY => [0.0, -1.0, 0.0],
            Axis::MinusZ => [0.0, 0.0, -1.0],
        }))
    }

    /// Creates a mounting from a proper rotation, row by row: `body = C part`.
    ///
    /// # Errors
    /// Rejects a matrix that is no rotation, or one with a reflection.
    pub fn from_matrix(part_to_body: [[f32; 3]; 3]) -> Result<Self, MountingError> {
        let [x, y, z] = part_to_body;
        let near = |product: f32, wanted: f32| libm::fabsf(product - wanted) <= ORTHONORMAL;
        let unit = near(dot(x, x), 1.0) && near(dot(y, y), 1.0) && near(dot(z, z), 1.0);
        if !(unit && near(dot(x, y), 0.0) && near(dot(y, z), 0.0) && near(dot(z, x), 0.0)) {
            return Err(MountingError::NotOrthonormal);
        }
        if dot(cross(x, y), z) < 0.0 {
            return Err(MountingError::LeftHanded);
        }
        Ok(Self { part_to_body })
    }

    /// Rotates a vector of the part into the body's axes.
    #[must_use]
    pub fn body(&self, part: [f32; 3]) -> [f32; 3] {
        self.part_to_body.map(|row| dot(row, part))
    }
}

impl Default for Mounting {
    fn default() -> Self {
        Self::ALIGNED
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    ax * bx + ay * by + az * bz
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}
