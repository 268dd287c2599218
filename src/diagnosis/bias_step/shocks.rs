use crate::{
    algebra::quantile,
    diagnosis::stream::{SHARED, SampleStream},
};

/// Most fifths of a second of one diagnosis.
const MOST: usize = 263;

/// By how many of their quartiles' distances a largest specific force of a fifth of a second has to be over their median to be a shock.
/// Largest values of vibration are Gumbel-distributed: with quartiles at 0.327, -0.367 and -1.246 scales from its mode, one in a hundred is
/// so large, two of a diagnosis. A short shock is diluted by the sample period; each time that is thought of raises the threshold.
const SHOCK: f32 = (4.600 - 0.367) / (1.246 + 0.327);

/// The hardest shaking in every fifth of a second of a diagnosis.
#[derive(Clone, Copy)]
pub(in crate::diagnosis) struct Shocks {
    from: u32,
    to: u32,
    /// Specific force from which it is a shock, m^2/s^4.
    least_square: f32,
    count: u32,
}

impl Shocks {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { from: 0, to: 0, least_square: 0.0, count: 0 }
    }

    /// Those within increments `from..to`.
    #[inline(never)]
    pub fn new(stream: &SampleStream, from: u32, to: u32) -> Self {
        let mut shocks = Self { from, to, least_square: f32::INFINITY, count: 0 };
        let mut forces = [0.0; MOST];
        let mut known = 0;
        for (force, until) in forces.iter_mut().zip(shocks.times()) {
            *force = libm::sqrtf(square(stream, until));
            known += 1;
        }
        let forces = forces.get_mut(..known).unwrap_or_default();
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|share| quantile(forces, share));
        let least = middle + SHOCK * (high - low);
        shocks.least_square = least * least;
        shocks.count = shocks.times().filter(|until| shocks.is_shock(stream, *until)).count() as u32;
        shocks
    }

    /// The middles of the fifths of a second, in increments.
    pub fn times(&self) -> impl Iterator<Item = u32> + use<> {
        let first = self.from / SHARED + 1;
        // What comes after the end may be there already or not.
        (first..(self.to / SHARED).saturating_sub(1)).map(|shared| shared * SHARED + SHARED / 2)
    }

    /// Whether it shook beyond what vibration does, and no less before and after.
    #[inline(never)]
    pub fn is_shock(&self, stream: &SampleStream, until: u32) -> bool {
        let [before, own, after] = [until.saturating_sub(SHARED), until, until + SHARED].map(|t| square(stream, t));
        own > self.least_square && own >= before && own >= after
    }

    pub const fn count(&self) -> u32 {
        self.count
    }
}

/// Square of the hardest specific force of the fifth of a second that a time is in the middle of, m^2/s^4.
fn square(stream: &SampleStream, until: u32) -> f32 {
    // That of the fifth before an increment is given.
    stream.surroundings.get(until + SHARED).largest_square_m2_s4
}
