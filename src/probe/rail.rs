//! Rail of a gyro (saturation): a largest reading that repeats to the bit, with or without a declared full scale.

/// Bit-exact repeats after which a gyro's largest reading counts as its rail: an unsaturated gyro has noise. That of a
/// steady turn may be below the resolution: then the largest reading repeats, too, among others just under it.
const RAIL_REPEATS: u16 = 10;

/// Share of the largest reading above which another one is just under it, and says that it is no rail.
const JUST_UNDER: f32 = 0.99;

/// Lowest rail of any gyro, rad/s: 115 deg/s, under the lowest full scale of data sheets (LSM6DSO: 125
/// deg/s).
const LOWEST_RAIL_RAD_S: f32 = 2.0;

/// Detector of one axis's rail by repeats of its largest reading.
#[derive(Clone, Copy)]
pub(super) struct Rail {
    largest: f32,
    repeats: u16,
    /// Readings since the largest one came last.
    unmet: u16,
}

impl Rail {
    pub const fn zero() -> Self {
        Self { largest: 0.0, repeats: 0, unmet: 0 }
    }

    /// Takes a reading. Returns true if it is at the rail. A largest reading that does not come again within 65,535
    /// readings, some minutes, was an outlier and no rail.
    // Once in the program: it is called for each axis.
    #[inline(never)]
    pub fn update(&mut self, x: f32) -> bool {
        let size = libm::fabsf(x);
        self.unmet = self.unmet.saturating_add(1);
        let is_outlier = self.unmet == u16::MAX && self.repeats < RAIL_REPEATS;
        if size > self.largest || is_outlier {
            *self = Self { largest: size, repeats: 0, unmet: 0 };
        } else if size >= self.largest {
            (self.repeats, self.unmet) = (self.repeats.saturating_add(1), 0);
        } else if size > JUST_UNDER * self.largest && self.repeats < RAIL_REPEATS {
            self.repeats = 0;
        }
        size >= self.largest && self.repeats >= RAIL_REPEATS && size > LOWEST_RAIL_RAD_S
    }
}

#[cfg(test)]
mod tests;
