use super::squares_of;
use crate::{
    algebra::quantile,
    window::{MAGNETIC, TESTS, TestWindows},
};

/// Quantile of the squared norm of three standard normal components below which a quarter of them lie (chi-square, 3 degrees of
/// freedom).
const QUARTER: f32 = 1.212_5;

/// Margin on the field's noise: a scale that is too small costs more than one that is too large (half: 10 points of success under
/// contamination, double: 1).
pub(super) const NOISE_MARGIN: f32 = 1.44;

/// Variances of one equation of a clean window, gravity and field, from the residuals of the unweighted solution; and the largest of the
/// field's squared residuals.
pub(super) fn clean_variances(tests: &TestWindows, theta: &[f32; 12], x: &[f32; MAGNETIC]) -> ([f32; 2], f32) {
    let mut squares = [[0.0_f32; TESTS]; 2];
    let mut noise = [0.0_f32; TESTS];
    let mut counts = [0_usize; 2];
    for test in tests.all() {
        let found = squares_of(test, theta, x);
        for ((square, count), sensor) in found.iter().zip(&mut counts).zip(&mut squares) {
            let (Some(square), Some(slot)) = (square, sensor.get_mut(*count)) else { continue };
            *slot = *square;
            *count += 1;
        }
        if let (Some(_), Some(slot)) = (found[1], counts[1].checked_sub(1).and_then(|last| noise.get_mut(last))) {
            *slot = test.field_noise_ut2;
        }
    }
    let [gravity, field] = &mut squares;
    let own =
        |squares: &mut [f32], count: usize| quantile(squares.get_mut(..count).unwrap_or_default(), 0.25) / QUARTER;
    let largest = field.iter().fold(0.0, |most: f32, square| if *square > most { *square } else { most });
    let sensor_noise = quantile(noise.get_mut(..counts[1]).unwrap_or_default(), 0.25);
    ([own(gravity, counts[0]), NOISE_MARGIN * tests.noise_gain() * sensor_noise], largest)
}
