use nalgebra::Vector3;

/// Interval of one increment: summing to 50 Hz loses nothing of the identification, to 10 Hz most of it.
const NOMINAL_INTERVAL_US: u32 = 20_000;

/// No reading, in the first axis of a stored vector.
const NONE: i16 = i16::MIN;

/// The time grid of the increments: the fewest whole nominal sample periods that make 20 ms, less a thousandth for periods that
/// are rounded to microseconds. Never shorter: the ring is sized for the longest window in increments of 20 ms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub interval_us: u32,
}

impl Grid {
    pub const fn zero() -> Self {
        Self { interval_us: 0 }
    }

    pub fn new(sample_period_us: u32) -> Self {
        let shortest_us = NOMINAL_INTERVAL_US - NOMINAL_INTERVAL_US / 1_000;
        let samples = (shortest_us + sample_period_us.saturating_sub(1)).checked_div(sample_period_us).unwrap_or(0);
        Self { interval_us: samples * sample_period_us }
    }

    pub fn interval_s(self) -> f32 {
        self.interval_us as f32 * 1e-6
    }

    /// Increments in `seconds`, to the nearest, at least one.
    pub fn increments_in(self, seconds: f32) -> usize {
        let n = libm::roundf(seconds / self.interval_s()) as usize;
        if n == 0 { 1 } else { n }
    }
}

/// Means over one interval of the grid, valid at its middle.
///
/// The mean of a body vector over 20 ms stands for the vector at the middle with an error of second order in the angle turned
/// (0.05 % of its length at 300 deg/s); direction errors are odd in time and cancel for a steady rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Increment {
    /// Mean raw rate, rad/s; `None` when a sample of the interval was clipped or the interval is empty.
    pub rate: Option<Vector3<f32>>,
    /// Mean gravity direction vector G = minus specific force, m/s^2, calibrated.
    pub gravity: Option<Vector3<f32>>,
    /// Mean field, microtesla, calibrated.
    pub field: Option<Vector3<f32>>,
}

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

    /// Stores an increment and returns what of it could be: a vector beyond the range is none.
    pub fn push(&mut self, increment: &Increment) -> Increment {
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
        let kept = |vector: Option<Vector3<f32>>, [first, ..]: [i16; 3]| vector.filter(|_| first != NONE);
        Increment {
            rate: kept(increment.rate, stored.rate),
            gravity: kept(increment.gravity, stored.gravity),
            field: kept(increment.field, stored.field),
        }
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

/// Sums samples into the increment of their grid interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accumulator {
    end_us: u64,
    rate: Vector3<f32>,
    gravity: Vector3<f32>,
    field: Vector3<f32>,
    rates: u16,
    gravities: u16,
    fields: u16,
    rate_clipped: bool,
    gravity_clipped: bool,
    field_clipped: bool,
    /// Mean rates of the last two intervals; `None` until there are, and after one that had to be bridged.
    last_rates: Option<[Vector3<f32>; 2]>,
}

/// A sensor's part of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// No reading: the others of the interval stand for it.
    Missing,
    /// At full scale, or not to be believed: the interval's mean would be biased, so the interval has none.
    Clipped,
    /// Raw rate, or a vector sensor's calibrated reading.
    Good(Vector3<f32>),
}

impl Accumulator {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            end_us: 0,
            rate: zero,
            gravity: zero,
            field: zero,
            rates: 0,
            gravities: 0,
            fields: 0,
            rate_clipped: false,
            gravity_clipped: false,
            field_clipped: false,
            last_rates: None,
        }
    }

    /// The mean rate of the interval. One interval without any reading is bridged by a straight line through the two before it: of a
    /// rate that swings at 0.25 Hz by 180 deg/s a line misses 0.2 deg/s over 20 ms. One that was clipped is not.
    fn rate(&self) -> Option<Vector3<f32>> {
        match (self.rate_clipped, self.rates) {
            (true, _) => None,
            (false, 0) => self.last_rates.map(|[before, last]| last * 2.0 - before),
            (false, count) => Some(self.rate / f32::from(count)),
        }
    }

    /// Begins a new grid whose first interval holds the sample at `t_us`, half a sample period after its beginning.
    pub fn start(&mut self, t_us: u64, grid: Grid, sample_period_us: u32) {
        *self = Self::zero();
        self.end_us = t_us.wrapping_add(u64::from(grid.interval_us) - u64::from(sample_period_us / 2));
    }

    /// The increment that ends before `t_us`, if one does. Call until `None` before adding the sample of `t_us`.
    pub fn close_before(&mut self, t_us: u64, grid: Grid) -> Option<Increment> {
        // The end is never farther off than a gap, so a wrapped difference tells before from after at every 64-bit time.
        if t_us.wrapping_sub(self.end_us).cast_signed() < 0 {
            return None;
        }
        let mean = |sum: Vector3<f32>, n: u16| if n == 0 { None } else { Some(sum / f32::from(n)) };
        let increment = Increment {
            rate: self.rate(),
            gravity: if self.gravity_clipped { None } else { mean(self.gravity, self.gravities) },
            field: if self.field_clipped { None } else { mean(self.field, self.fields) },
        };
        let read = increment.rate.filter(|_| self.rates > 0);
        let last_rates = read.map(|rate| [self.last_rates.map_or(rate, |[_, last]| last), rate]);
        *self = Self { end_us: self.end_us.wrapping_add(u64::from(grid.interval_us)), last_rates, ..Self::zero() };
        Some(increment)
    }

    /// Adds one sample: raw rate, calibrated gravity and field.
    pub fn add(&mut self, rate: Reading, gravity: Reading, field: Reading) {
        let add = |reading, sum: &mut Vector3<f32>, count: &mut u16, clipped: &mut bool| match reading {
            Reading::Good(vector) => {
                *sum += vector;
                *count += 1;
            }
            Reading::Clipped => *clipped = true,
            Reading::Missing => {}
        };
        add(rate, &mut self.rate, &mut self.rates, &mut self.rate_clipped);
        add(gravity, &mut self.gravity, &mut self.gravities, &mut self.gravity_clipped);
        add(field, &mut self.field, &mut self.fields, &mut self.field_clipped);
    }
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
    fn samples_fall_into_their_interval_and_one_empty_one_is_bridged() {
        let grid = Grid::new(5_000);
        assert_eq!(grid.interval_us, 20_000);
        let mut accumulator = Accumulator::zero();
        accumulator.start(1_000_000, grid, 5_000);
        let mut closed = 0;
        for k in 0..12_u64 {
            let t = 1_000_000 + 5_000 * k;
            while let Some(increment) = accumulator.close_before(t, grid) {
                // Samples 0..4, 4..8: the mean of k is 1.5, 5.5.
                assert_eq!(increment.rate, Some(Vector3::repeat(1.5 + 4.0 * closed as f32)));
                closed += 1;
            }
            accumulator.add(Reading::Good(Vector3::repeat(k as f32)), Reading::Missing, Reading::Missing);
        }
        assert_eq!(closed, 2);
        assert!(accumulator.close_before(1_060_000, grid).is_some_and(|i| i.rate.is_some()));
        // 1.5, 5.5, 9.5: a straight line bridges one empty interval, and none after it.
        let empty = accumulator.close_before(1_080_000, grid).unwrap();
        assert_eq!(empty.rate, Some(Vector3::repeat(13.5)));
        assert_eq!(accumulator.close_before(1_100_000, grid).unwrap().rate, None);
    }

    #[test]
    fn a_missing_reading_is_stood_for_by_the_others_and_a_clipped_one_is_not() {
        let grid = Grid::new(5_000);
        let rate_of = |odd: Reading| {
            let mut accumulator = Accumulator::zero();
            accumulator.start(0, grid, 5_000);
            for reading in [Reading::Good(Vector3::x()), odd, Reading::Good(Vector3::x() * 2.0), Reading::Missing] {
                accumulator.add(reading, Reading::Missing, Reading::Missing);
            }
            accumulator.close_before(20_000, grid).unwrap().rate
        };
        assert_eq!(rate_of(Reading::Missing), Some(Vector3::x() * 1.5));
        assert_eq!(rate_of(Reading::Clipped), None);
    }

    #[test]
    fn a_vector_beyond_the_range_is_dropped_and_leaves_no_trace() {
        let mut ring = IncrementRing::<4>::zero();
        ring.start(Scales::new(40.0, 160.0, 1000.0));
        let good = Vector3::new(1.0, 2.0, 3.0);
        for bad in [1e30, f32::INFINITY, f32::NAN, 41.0] {
            let bad = Vector3::new(0.0, bad, 0.0);
            let kept = ring.push(&Increment { rate: Some(bad), gravity: Some(good), field: None });
            assert_eq!(kept, Increment { rate: None, gravity: Some(good), field: None });
        }
        assert_eq!(ring.get(3).rate, None);
        ring.push(&Increment { rate: Some(good), gravity: None, field: None });
        assert!(ring.get(4).rate.is_some_and(|rate| (rate - good).amax() < 1e-3));
    }

    #[test]
    fn grid_is_a_whole_number_of_samples_and_never_shorter_than_the_ring_is_sized_for() {
        for (period, interval) in
            [(3_500, 21_000), (3_333, 19_998), (10_000, 20_000), (15_000, 30_000), (33_333, 33_333)]
        {
            assert_eq!(Grid::new(period).interval_us, interval);
        }
        assert_eq!(Grid::new(3_500).increments_in(1.0), 48);
        for period in 100..=20_000 {
            let interval = Grid::new(period).interval_us;
            assert!(interval.is_multiple_of(period) && (19_980..40_000).contains(&interval), "{period}");
        }
    }

    #[test]
    fn intervals_close_at_the_ends_of_time_too() {
        let grid = Grid::new(10_000);
        for start in [0, 4_999, u64::MAX - 100_000, u64::MAX - 5_000, u64::MAX] {
            let mut accumulator = Accumulator::zero();
            accumulator.start(start, grid, 10_000);
            let mut closed = 0;
            for t in (0..8).map_while(|k| start.checked_add(10_000 * k)) {
                while accumulator.close_before(t, grid).is_some() {
                    closed += 1;
                }
            }
            assert!(closed <= 3, "{closed}");
        }
    }
}
