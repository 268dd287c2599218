//! Rotations by rotation vectors, through a short series without sine, cosine or square root; sine and cosine
//! of an angle.

use nalgebra::{Matrix3, Quaternion, Vector3};

/// Largest squared half-angle of the series, rad^2: a rotation of 1 rad.
const MAX_SQUARED_HALF_ANGLE: f32 = 0.25;
/// Largest number of halvings before the series: rotations up to 256 rad.
const MAX_HALVINGS: u32 = 8;

/// Unit quaternion of a rotation vector, radians.
///
/// Taylor series of cosine and of sine over angle in the squared half-angle, four terms each. Up to 1 rad the
/// truncation is under 1.0e-7 (the next term of the cosine, 0.5^8 / 8!). A longer vector is halved n times
/// and the result squared n times, which doubles the error each time. Components are within 3e-7 of the exact
/// ones up to 1 rad and within 3e-6 up to 2 pi. A vector that is not finite or longer than 256 rad gives the
/// identity: no sample can hold such a rotation.
pub(crate) fn exp_quaternion(rotation_vector: &Vector3<f32>) -> Quaternion<f32> {
    let mut half = rotation_vector * 0.5;
    let mut x = half.norm_squared();
    let mut halvings = 0;
    while x > MAX_SQUARED_HALF_ANGLE && halvings < MAX_HALVINGS {
        half *= 0.5;
        x *= 0.25;
        halvings += 1;
    }
    if !matches!(x.partial_cmp(&MAX_SQUARED_HALF_ANGLE), Some(core::cmp::Ordering::Less | core::cmp::Ordering::Equal)) {
        return IDENTITY;
    }
    let cosine = 1.0 - x * (0.5 - x * (1.0 / 24.0 - x * (1.0 / 720.0)));
    let sine_over_angle = 1.0 - x * (1.0 / 6.0 - x * (1.0 / 120.0 - x * (1.0 / 5_040.0)));
    let v = half * sine_over_angle;
    let mut q = Quaternion::new(cosine, v.x, v.y, v.z);
    for _ in 0..halvings {
        q = renormalised(&(q * q));
    }
    q
}

/// Rotation vector from the middle of one interval to the middle of the next, radians. `rates` are the means
/// (rad/s) over the interval before the first, the first and the second, each `dt` long.
///
/// The vector joins half of the first interval and half of the second, each for a rate linear in time, so that the
/// sum over many intervals is exactly that of the means. (Half the sum of two means alone loses (w dt)^2 / 8
/// of a rate that swings at w rad/s, and nothing of a steady one: at 0.25 Hz and 20 ms 1.2e-4, as large as the errors
/// that are identified.) The two-sample coning term is (phi1 x phi2) / 12 (Bortz's equation to second order for a rate
/// linear in time).
pub(crate) fn middle_to_middle(rates: [&Vector3<f32>; 3], dt: f32) -> Vector3<f32> {
    let [earlier, first, second] = rates;
    let sum = (first + second) * 0.5 - (second - first * 2.0 + earlier) * 0.125;
    sum * dt + first.cross(second) * (dt * dt / 12.0)
}

/// Rotation matrix of a rotation vector, radians; its errors are those of [`exp_quaternion`], doubled.
pub(crate) fn exp_matrix(rotation_vector: &Vector3<f32>) -> Matrix3<f32> {
    matrix(&exp_quaternion(rotation_vector))
}

/// Sine and cosine of an angle, radians.
///
/// Taylor series within an eighth of a turn of the nearest quarter, five terms each (the next one of the
/// cosine is (pi / 4)^10 / 10!, 2.5e-8). Within 1.5e-7 of the exact values up to 100 rad, and within 1e-6 up
/// to 10,000. `libm` reduces the angle and sums its series in emulated f64: eleven kilobytes of flash and two
/// thousand instructions, for a precision that no angle here has.
pub(crate) fn sine_and_cosine(angle_rad: f32) -> (f32, f32) {
    // pi / 2 in three parts (Cody and Waite): the first two have so few bits that their products with a count
    // of quarters are exact.
    const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    let quarters = libm::roundf(angle_rad * core::f32::consts::FRAC_2_PI);
    let x = QUARTER.iter().fold(angle_rad, |rest, part| rest - quarters * part);
    let square = x * x;
    let sine = x
        * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5_040.0 - square * (1.0 / 362_880.0)))));
    let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40_320.0))));
    match quarters as i32 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Quaternion of no rotation.
pub(crate) const IDENTITY: Quaternion<f32> = Quaternion::from_vector(nalgebra::Vector4::new(0.0, 0.0, 0.0, 1.0));

/// Rotation matrix of a unit quaternion: `matrix(q) v = q v q*`.
pub(crate) fn matrix(q: &Quaternion<f32>) -> Matrix3<f32> {
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    Matrix3::new(
        1.0 - (yy + zz),
        xy - wz,
        xz + wy,
        xy + wz,
        1.0 - (xx + zz),
        yz - wx,
        xz - wy,
        yz + wx,
        1.0 - (xx + yy),
    )
}

/// Unit quaternion of a rotation matrix (Shepperd, J. Guidance and Control 1(3), 1978).
pub(crate) fn quaternion(m: &Matrix3<f32>) -> Quaternion<f32> {
    let trace = m.m11 + m.m22 + m.m33;
    let root = |x: f32| libm::sqrtf(if x > 0.0 { x } else { 0.0 });
    let q = if trace > 0.0 {
        Quaternion::new(1.0 + trace, m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12)
    } else if m.m11 >= m.m22 && m.m11 >= m.m33 {
        Quaternion::new(m.m32 - m.m23, 1.0 + m.m11 - m.m22 - m.m33, m.m12 + m.m21, m.m13 + m.m31)
    } else if m.m22 >= m.m33 {
        Quaternion::new(m.m13 - m.m31, m.m12 + m.m21, 1.0 + m.m22 - m.m11 - m.m33, m.m23 + m.m32)
    } else {
        Quaternion::new(m.m21 - m.m12, m.m13 + m.m31, m.m23 + m.m32, 1.0 + m.m33 - m.m11 - m.m22)
    };
    q / root(q.norm_squared())
}

/// Normalises a quaternion whose norm is within 1e-3 of one, by one Newton step to within rounding.
pub(crate) fn renormalised(q: &Quaternion<f32>) -> Quaternion<f32> {
    q * (1.5 - 0.5 * q.norm_squared())
}

/// Rotates `v` by the unit quaternion `q`: q v q*.
pub(crate) fn rotate(q: &Quaternion<f32>, v: &Vector3<f32>) -> Vector3<f32> {
    let axis = q.imag();
    let t = axis.cross(v) * 2.0;
    v + t * q.scalar() + axis.cross(&t)
}

/// Rotates `v` by the inverse of the unit quaternion `q`: q* v q.
pub(crate) fn rotate_back(q: &Quaternion<f32>, v: &Vector3<f32>) -> Vector3<f32> {
    rotate(&q.conjugate(), v)
}

#[cfg(test)]
mod tests;
