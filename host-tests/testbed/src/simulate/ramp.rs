//! Smooth ramp from 0 to 1: drilling sets in with it, a magnet comes, a sensor turns in its mount.

/// `3 x^2 - 2 x^3` and its slope; 0 before 0, 1 from 1 on.
pub(super) fn smooth_ramp(x: f64) -> (f64, f64) {
    if x <= 0.0 {
        (0.0, 0.0)
    } else if x >= 1.0 {
        (1.0, 0.0)
    } else {
        (x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_from_nothing_to_all_and_the_slope_is_its_derivative() {
        for (x, value) in [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.15625), (0.5, 0.5), (1.0, 1.0), (7.0, 1.0)] {
            assert!((smooth_ramp(x).0 - value).abs() < 1e-15);
            let difference = (smooth_ramp(x + 1e-6).0 - smooth_ramp(x - 1e-6).0) / 2e-6;
            assert!((difference - smooth_ramp(x).1).abs() < 1e-5);
        }
    }
}
