use crate::objective::Stretch;
use nalgebra::{Matrix3, Vector3};

/// How far c has walked from its mean over the window by the window's end, and with which variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drift {
    /// rad/s.
    pub change: Vector3<f32>,
    /// (rad/s)^2.
    pub variance: Matrix3<f32>,
}

/// The window's fit takes the bias for constant; what its innovations still say of c, stretch by stretch, goes through a Kalman
/// filter of a random walk: the last stretches count most, and a noisy window moves nothing. `start_variance`: of a component of c
/// before the first stretch; `walk_variance`: what a stretch adds, both (rad/s)^2.
pub(crate) fn drift(
    stretches: [&[Stretch]; 2],
    delta: &[f32; 12],
    start_variance: f32,
    walk_variance: f32,
) -> Option<Drift> {
    let [gravity, field] = stretches;
    let mut variance = Matrix3::from_diagonal_element(start_variance);
    let mut change = Vector3::zeros();
    for (gravity, field) in gravity.iter().zip(field) {
        variance += Matrix3::from_diagonal_element(walk_variance);
        let mut information = variance.try_inverse()?;
        let mut pull = Vector3::zeros();
        for stretch in [gravity, field] {
            let (normal, descent) = stretch.bias_equations(delta);
            information += normal;
            pull += descent - normal * change;
        }
        variance = information.try_inverse()?;
        change += variance * pull;
    }
    change.iter().all(|x| x.is_finite()).then_some(Drift { change, variance })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stretches in each of which c is seen with the given offset and a deviation of 0.01.
    fn seen(offsets: [f32; 10]) -> [Stretch; 10] {
        offsets.map(|offset| {
            let mut stretch = Stretch::zero();
            let mut rows = [[0.0; 12]; 3];
            for (axis, row) in rows.iter_mut().enumerate() {
                row[9 + axis] = 1.0;
            }
            stretch.add(&rows, &Vector3::repeat(-offset), 1e4);
            stretch.count = 3.0;
            stretch
        })
    }

    #[test]
    fn a_bias_that_walks_is_followed_and_one_that_does_not_is_averaged() {
        let nothing = [Stretch::zero(); 10];
        let ramp = seen(core::array::from_fn(|k| 1e-3 * k as f32));
        let of = |stretches: &[Stretch; 10], walk| drift([&nothing, stretches], &[0.0; 12], 1.0, walk).unwrap();
        let followed = of(&ramp, 0.1);
        assert!((followed.change - Vector3::repeat(9e-3)).amax() < 1e-4, "{}", followed.change);
        let averaged = of(&ramp, 0.0);
        assert!((averaged.change - Vector3::repeat(4.5e-3)).amax() < 1e-5, "{}", averaged.change);
        assert!((averaged.variance[(0, 0)] / 1e-5 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn without_innovations_nothing_moves() {
        let nothing = [Stretch::zero(); 10];
        let found = drift([&nothing, &nothing], &[0.0; 12], 1e-4, 1e-6).unwrap();
        assert_eq!(found.change, Vector3::zeros());
        assert!((found.variance[(1, 1)] / 1.1e-4 - 1.0).abs() < 1e-3);
    }
}
