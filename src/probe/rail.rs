//! Rail of a gyro (saturation): a largest reading that repeats to the bit, with or without a declared full scale.

/// Bit-exact repeats after which a gyro's largest reading counts as its rail: an unsaturated gyro has noise.
const RAIL_REPEATS: u32 = 10;

/// Lowest rail of any gyro, rad/s: 115 deg/s, under the lowest full scale of data sheets (LSM6DSO: 125
/// deg/s).
const LOWEST_RAIL_RAD_S: f32 = 2.0;

/// Detector of one axis's rail by repeats of its largest reading.
#[derive(Clone, Copy)]
pub(super) struct Rail {
    largest: f32,
    repeats: u32,
}

impl Rail {
    pub const fn zero() -> Self {
        Self { largest: 0.0, repeats: 0 }
    }

    /// Takes a reading. Returns true if it is at the rail.
    pub fn update(&mut self, x: f32) -> bool {
        let size = libm::fabsf(x);
        if size > self.largest {
            *self = Self { largest: size, repeats: 0 };
        } else if size >= self.largest {
            self.repeats = self.repeats.saturating_add(1);
        }
        size >= self.largest && self.repeats >= RAIL_REPEATS && size > LOWEST_RAIL_RAD_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_repeats_of_the_largest_reading_are_a_rail_and_no_others() {
        let mut rail = Rail::zero();
        let seen = (0..15).filter(|_| rail.update(-4.0)).count();
        assert_eq!(seen, 5, "the first and nine repeats are not yet one");
        assert!(!rail.update(3.9), "below it");
        assert!(!rail.update(4.1), "beyond it: it was none");
        assert!(!rail.update(4.0));
        let mut slow = Rail::zero();
        assert!((0..100).all(|_| !slow.update(1.9)), "no gyro's rail is so low");
    }
}
