use approx::assert_relative_eq;
use meerkat_mwd::sensors::{Axis, Mounting, MountingError};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

fn rows(matrix: &Matrix3<f32>) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|row| [matrix[(row, 0)], matrix[(row, 1)], matrix[(row, 2)]])
}

/// Half of the 48 signed permutations, 24, are rotations; of the 216 triples of axes the rest name an axis twice.
#[test]
fn half_of_the_remappings_are_right_handed() {
    let axes = [Axis::PlusX, Axis::PlusY, Axis::PlusZ, Axis::MinusX, Axis::MinusY, Axis::MinusZ];
    let (mut right, mut left, mut twice) = (0, 0, 0);
    for x in axes {
        for y in axes {
            for z in axes {
                match Mounting::from_axes([x, y, z]) {
                    Ok(_) => right += 1,
                    Err(MountingError::LeftHanded) => left += 1,
                    Err(_) => twice += 1,
                }
            }
        }
    }
    assert_eq!((right, left, twice), (24, 24, 168));
}

/// The part lies with its x along the body's z: what it reads on x is the body's z.
#[test]
fn a_remapping_says_which_axis_points_along_the_bodys() {
    let mounting = Mounting::from_axes([Axis::PlusY, Axis::MinusZ, Axis::MinusX]).unwrap();
    assert_eq!(mounting.body([1.0, 2.0, 3.0]), [2.0, -3.0, -1.0]);
}

proptest! {
    /// Against nalgebra; the mirror image of a rotation is refused as such, and a stretched one too.
    #[test]
    fn a_rotation_turns_and_nothing_else_is_taken(
        turn in prop::array::uniform3(-3.0_f32..3.0), part in prop::array::uniform3(-100.0_f32..100.0), axis in 0_usize..3, stretch in 1.01_f32..2.0
    ) {
        let rotation = Rotation3::from_scaled_axis(Vector3::from(turn)).into_inner();
        let body = Mounting::from_matrix(rows(&rotation)).unwrap().body(part);
        assert_relative_eq!(Vector3::from(body), rotation * Vector3::from(part), epsilon = 1e-3);
        let mut mirror = rotation;
        mirror.row_mut(axis).neg_mut();
        prop_assert_eq!(Mounting::from_matrix(rows(&mirror)), Err(MountingError::LeftHanded));
        let mut stretched = rotation;
        stretched.row_mut(axis).scale_mut(stretch);
        prop_assert_eq!(Mounting::from_matrix(rows(&stretched)), Err(MountingError::NotOrthonormal));
        let mut not_finite = rotation;
        not_finite[(axis, axis)] = f32::NAN;
        prop_assert_eq!(Mounting::from_matrix(rows(&not_finite)), Err(MountingError::NotOrthonormal));
    }
}
