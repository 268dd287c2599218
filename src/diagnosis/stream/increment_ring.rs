use super::Increment;
use nalgebra::Vector3;

/// No reading, in the first axis of a stored vector.
const NONE: i16 = i16::MIN;

/// Resolution of the stored integers, per unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub rate_rad_s: f32,
    pub gravity_m_s2: f32,
    pub field_ut: f32,
}

impl Scales {
    pub const fn zero() -> Self {
        Self { rate_rad_s: 0.0, gravity_m_s2: 0.0, field_ut: 0.0 }
    }

    /// From the largest magnitudes that are to be stored.
    pub fn new(rate_rad_s: f32, gravity_m_s2: f32, field_ut: f32) -> Self {
        let step = |full_scale: f32| full_scale / f32::from(i16::MAX);
        Self { rate_rad_s: step(rate_rad_s), gravity_m_s2: step(gravity_m_s2), field_ut: step(field_ut) }
    }
}

#[derive(Clone, Copy)]
struct Stored {
    rate: [i16; 3],
    gravity: [i16; 3],
    field: [i16; 3],
}

/// The latest `N` increments, quantised to 16 bits. The rounding remainder of each axis is carried into the next increment,
/// so that sums over a window lose nothing.
pub(crate) struct IncrementRing<const N: usize> {
    stored: [Stored; N],
    /// Increments pushed since the start; the ring holds the last `N` of them. Enough for 2.7 years at 50 a second.
    count: u32,
    remainder: [Vector3<f32>; 3],
    scales: Scales,
}

impl<const N: usize> IncrementRing<N> {
    pub const fn zero() -> Self {
        const EMPTY: Stored = Stored { rate: [0; 3], gravity: [0; 3], field: [0; 3] };
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { stored: [EMPTY; N], count: 0, remainder: [zero; 3], scales: Scales::zero() }
    }

    pub fn start(&mut self, scales: Scales) {
        self.count = 0;
        self.remainder = [Vector3::zeros(); 3];
        self.scales = scales;
    }

    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Whether increment `index` (counted from the start) has not been overwritten yet.
    pub const fn holds(&self, index: u32) -> bool {
        index < self.count && self.count - index <= N as u32
    }

    /// Stores an increment; a vector beyond the range is none.
    pub fn push(&mut self, increment: &Increment) {
        let [r0, r1, r2] = &mut self.remainder;
        let stored = Stored {
            rate: quantise(increment.rate, self.scales.rate_rad_s, r0),
            gravity: quantise(increment.gravity, self.scales.gravity_m_s2, r1),
            field: quantise(increment.field, self.scales.field_ut, r2),
        };
        if let Some(slot) = self.stored.get_mut(self.count as usize % N) {
            *slot = stored;
        }
        self.count = self.count.wrapping_add(1);
    }

    /// Increment `index` (counted from the start), empty when the ring does not hold it.
    pub fn get(&self, index: u32) -> Increment {
        let Some(stored) = self.stored.get(index as usize % N).filter(|_| self.holds(index)) else {
            return Increment { rate: None, gravity: None, field: None };
        };
        let vector =
            |v: [i16; 3], step: f32| if v[0] == NONE { None } else { Some(Vector3::from(v.map(f32::from)) * step) };
        Increment {
            rate: vector(stored.rate, self.scales.rate_rad_s),
            gravity: vector(stored.gravity, self.scales.gravity_m_s2),
            field: vector(stored.field, self.scales.field_ut),
        }
    }
}

/// Rounds to steps, carrying the remainder; a vector beyond the range counts as no reading.
fn quantise(vector: Option<Vector3<f32>>, step: f32, remainder: &mut Vector3<f32>) -> [i16; 3] {
    let Some(vector) = vector else { return [NONE, 0, 0] };
    let wanted = vector + *remainder;
    let steps = wanted.map(|x| libm::roundf(x / step));
    if !steps.iter().all(|s| libm::fabsf(*s) <= f32::from(i16::MAX)) {
        return [NONE, 0, 0];
    }
    *remainder = wanted - steps * step;
    steps.map(|s| s as i16).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantisation_keeps_the_sum_to_half_a_step() {
        let mut ring = IncrementRing::<64>::zero();
        ring.start(Scales::new(40.0, 160.0, 1000.0));
        let rate = Vector3::new(0.123_456, -2.000_3, 7e-5);
        let mut sum = Vector3::zeros();
        for _ in 0..50 {
            ring.push(&Increment { rate: Some(rate), gravity: None, field: None });
        }
        for index in 0..50 {
            sum += ring.get(index).rate.unwrap();
        }
        let step = 40.0 / f32::from(i16::MAX);
        assert!((sum - rate * 50.0).amax() <= 0.51 * step + 1e-5, "{sum}");
    }

    #[test]
    fn a_vector_beyond_the_range_is_dropped_and_leaves_no_trace() {
        let mut ring = IncrementRing::<4>::zero();
        ring.start(Scales::new(40.0, 160.0, 1000.0));
        let good = Vector3::new(1.0, 2.0, 3.0);
        for bad in [1e30, f32::INFINITY, f32::NAN, 41.0] {
            let bad = Vector3::new(0.0, bad, 0.0);
            ring.push(&Increment { rate: Some(bad), gravity: Some(good), field: None });
            let kept = ring.get(ring.count() - 1);
            assert!(kept.rate.is_none() && kept.field.is_none());
            assert!(kept.gravity.is_some_and(|gravity| (gravity - good).amax() < 5e-3));
        }
        ring.push(&Increment { rate: Some(good), gravity: None, field: None });
        assert!(ring.get(4).rate.is_some_and(|rate| (rate - good).amax() < 1e-3));
    }
}
