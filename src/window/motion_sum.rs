use nalgebra::{Matrix3, Vector3};

/// Rotations and raw rates of some increments, for the sum of their products R0 (x) (w_raw, -1): taken as the product of their means.
///
/// Within 40 ms the body turns by 0.13 rad at 180 deg/s, and a rate that swings at 0.25 Hz changes by 0.06 of itself: what the product
/// of the means lacks is a twelfth of the two's product, 0.07 %; of a tenth of a second 0.4 %.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionSum {
    count: u8,
    rotation: Matrix3<f32>,
    raw: Vector3<f32>,
}

impl MotionSum {
    /// Most increments: 40 ms.
    const MOST: u8 = 2;

    pub const fn zero() -> Self {
        let rotation = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self { count: 0, rotation, raw: Vector3::new(0.0, 0.0, 0.0) }
    }

    #[inline(always)]
    pub fn add(&mut self, rotation: &Matrix3<f32>, raw: &Vector3<f32>) {
        self.count += 1;
        self.rotation += rotation;
        self.raw += raw;
    }

    /// Whether there is no room for more.
    pub const fn is_full(&self) -> bool {
        self.count == Self::MOST
    }

    /// The sum of the rotations and the mean of the raw rates, to be multiplied; zero of no increment.
    pub fn factors(&self) -> (Matrix3<f32>, Vector3<f32>) {
        (self.rotation, self.raw * self.share())
    }

    /// What sums over the same increments are on the mean.
    pub fn mean<const N: usize>(&self, sums: [f32; N]) -> [f32; N] {
        sums.map(|sum| sum * self.share())
    }

    fn share(&self) -> f32 {
        if self.count > 0 { 1.0 / f32::from(self.count) } else { 0.0 }
    }
}
