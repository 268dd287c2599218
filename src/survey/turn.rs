use nalgebra::Vector3;

/// Up to this step the sine and cosine are short series, radians.
const LARGEST_SERIES_RAD: f32 = 0.5;

/// An angle about the tool axis, kept as cosine and sine so that it never has to be reduced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    cosine: f32,
    sine: f32,
}

impl Turn {
    pub(crate) const NONE: Self = Self { cosine: 1.0, sine: 0.0 };

    /// Turns on by an angle, radians. Up to half a radian by series (error under 2e-7; the next term of the cosine is angle^8 / 40,320, at most
    /// 1e-7), beyond by `libm`.
    pub(crate) fn by(&mut self, angle_rad: f32) {
        let (s, c) = if angle_rad.abs() <= LARGEST_SERIES_RAD {
            let x = angle_rad * angle_rad;
            let c = 1.0 - x * (0.5 - x * (1.0 / 24.0 - x * (1.0 / 720.0)));
            (angle_rad * (1.0 - x * (1.0 / 6.0 - x * (1.0 / 120.0 - x * (1.0 / 5_040.0)))), c)
        } else {
            libm::sincosf(angle_rad)
        };
        let cosine = self.cosine * c - self.sine * s;
        let sine = self.sine * c + self.cosine * s;
        let renormalised = 1.5 - 0.5 * (cosine * cosine + sine * sine);
        (self.cosine, self.sine) = (cosine * renormalised, sine * renormalised);
    }

    /// A vector of the tool, in the frame that does not turn.
    pub(crate) fn back(&self, v: &Vector3<f32>) -> Vector3<f32> {
        Vector3::new(self.cosine * v.x - self.sine * v.y, self.sine * v.x + self.cosine * v.y, v.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_every_size_add_up_to_their_sum() {
        for step in [1e-4_f32, 0.03, -0.1, 0.49, 0.51, -2.0] {
            let mut turn = Turn::NONE;
            (0..2_000).for_each(|_| turn.by(step));
            let (s, c) = libm::sincos(2_000.0 * f64::from(step));
            let v = turn.back(&Vector3::x());
            assert!((f64::from(v.x) - c).abs() < 2e-4 && (f64::from(v.y) - s).abs() < 2e-4, "{step} {v} {c} {s}");
        }
        let mut once = Turn::NONE;
        once.by(LARGEST_SERIES_RAD);
        let exact = libm::sincos(f64::from(LARGEST_SERIES_RAD));
        assert!((f64::from(once.sine) - exact.0).abs() < 2e-7 && (f64::from(once.cosine) - exact.1).abs() < 2e-7);
    }
}
