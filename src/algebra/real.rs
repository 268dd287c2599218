//! Numbers that the estimator computes with: `f32` on the chip, `f64` where the chip's rounding is measured.

use nalgebra::{Matrix3, RealField, Vector3};

/// `f32` or `f64`. Functions come from `libm` by path: a method such as `sqrt` would become the standard library's on
/// a host.
pub trait Real: RealField + Copy {
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Converts a constant.
    fn of(x: f32) -> Self;
    /// Rounds to `f32`, the chip's width.
    fn narrow(self) -> f32;
    /// Square root.
    fn root(self) -> Self;
    /// Natural logarithm.
    fn logarithm(self) -> Self;
    /// Exponential.
    fn exponential(self) -> Self;
    /// Angle of the point (x, `self`): atan2(self, x).
    fn angle(self, x: Self) -> Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn of(x: f32) -> Self {
        x
    }
    fn narrow(self) -> f32 {
        self
    }
    fn root(self) -> Self {
        libm::sqrtf(self)
    }
    fn logarithm(self) -> Self {
        libm::logf(self)
    }
    fn exponential(self) -> Self {
        libm::expf(self)
    }
    fn angle(self, x: Self) -> Self {
        libm::atan2f(self, x)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn of(x: f32) -> Self {
        Self::from(x)
    }
    fn narrow(self) -> f32 {
        self as f32
    }
    fn root(self) -> Self {
        libm::sqrt(self)
    }
    fn logarithm(self) -> Self {
        libm::log(self)
    }
    fn exponential(self) -> Self {
        libm::exp(self)
    }
    fn angle(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
}

/// A vector of three.
pub type V3<T> = Vector3<T>;
/// A matrix of three by three.
pub type M3<T> = Matrix3<T>;

pub(crate) const fn zero3<T: Real>() -> V3<T> {
    Vector3::new(T::ZERO, T::ZERO, T::ZERO)
}

pub(crate) const fn zero33<T: Real>() -> M3<T> {
    Matrix3::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO)
}

pub(crate) const fn identity<T: Real>() -> M3<T> {
    Matrix3::new(T::ONE, T::ZERO, T::ZERO, T::ZERO, T::ONE, T::ZERO, T::ZERO, T::ZERO, T::ONE)
}

pub(crate) fn widened<T: Real>(v: &Vector3<f32>) -> V3<T> {
    V3::new(T::of(v.x), T::of(v.y), T::of(v.z))
}

pub(crate) fn square<T: Real>(v: &V3<T>) -> T {
    v.x * v.x + v.y * v.y + v.z * v.z
}

pub(crate) fn norm<T: Real>(v: &V3<T>) -> T {
    square(v).root()
}

/// [v]x: the matrix with [v]x u = v x u.
pub(crate) fn cross_matrix<T: Real>(v: &V3<T>) -> M3<T> {
    Matrix3::new(T::ZERO, -v.z, v.y, v.z, T::ZERO, -v.x, -v.y, v.x, T::ZERO)
}

/// The rotation matrix of a rotation vector, radians: Rodrigues' formula, its two coefficients as Taylor series of
/// five terms. Up to 1 rad the next terms are 1 / 11! and 1 / 12!, 2.5e-8; a longer vector is halved and the rotation
/// squared.
pub(crate) fn rotation<T: Real>(v: &V3<T>) -> M3<T> {
    let t2 = square(v);
    if t2 > T::ONE && t2 < T::of(1e4) {
        let half = rotation(&(v * T::of(0.5)));
        return half * half;
    }
    let series = |first: T, divisors: [f32; 4]| {
        // Products: a division takes fourteen times as long.
        let [a, b, c, d] = divisors.map(|divisor| t2 * T::of(1.0 / divisor));
        first * (T::ONE - a * (T::ONE - b * (T::ONE - c * (T::ONE - d))))
    };
    let sine = series(T::ONE, [6.0, 20.0, 42.0, 72.0]);
    let versine = series(T::of(0.5), [12.0, 30.0, 56.0, 90.0]);
    let x = cross_matrix(v);
    identity::<T>() + x * sine + x * x * versine
}

/// The rotation vector of a rotation matrix, radians, for angles under pi.
pub(crate) fn rotation_vector<T: Real>(r: &M3<T>) -> V3<T> {
    let half = T::of(0.5);
    let sine = V3::new(r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12) * half;
    let cosine = (r.m11 + r.m22 + r.m33 - T::ONE) * half;
    let s2 = square(&sine);
    if s2 < T::of(1e-6) && cosine > T::ZERO {
        // asin(s) / s = 1 + s^2 / 6 to s^4.
        return sine * (T::ONE + s2 / T::of(6.0));
    }
    let s = s2.root();
    sine * (s.angle(cosine) / s)
}
