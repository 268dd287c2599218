use std::f64::consts::TAU;

use super::random::Random;

/// A sum of sinusoids of equal amplitude with random frequencies and phases: an irregular oscillation in a
/// band, whose value and slope are known in closed form at any instant.
pub(super) struct Multisine {
    amplitude: f64,
    /// Angular frequency, rad/s, and phase, rad, of each sinusoid.
    terms: Vec<(f64, f64)>,
}

impl Multisine {
    /// `count` sinusoids, one in each equal part of the band, of joint rms `rms`.
    pub(super) fn new(random: &mut Random, count: u32, band_hz: [f64; 2], rms: f64) -> Self {
        let [low, high] = band_hz;
        let part = (high - low) / f64::from(count);
        let terms = (0..count)
            .map(|i| (TAU * (low + part * (f64::from(i) + random.uniform())), TAU * random.uniform()))
            .collect();
        Self { amplitude: rms * libm::sqrt(2.0 / f64::from(count)), terms }
    }

    /// Value and its derivative by time at `t_s`.
    pub(super) fn at(&self, t_s: f64) -> (f64, f64) {
        let (value, slope) = self.terms.iter().fold((0.0, 0.0), |(value, slope), &(frequency, phase)| {
            let (sine, cosine) = libm::sincos(frequency * t_s + phase);
            (value + sine, slope + frequency * cosine)
        });
        (self.amplitude * value, self.amplitude * slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_mean_square_and_slope_are_as_stated() {
        let wave = Multisine::new(&mut Random::new(2), 5, [0.1, 0.5], 3.0);
        let n = 200_000;
        let square: f64 = (0..n).map(|i| wave.at(f64::from(i) * 0.05).0.powi(2)).sum::<f64>() / f64::from(n);
        assert!((square.sqrt() - 3.0).abs() < 0.02, "{}", square.sqrt());
        for t in [0.0, 1.7, 123.4] {
            let difference = (wave.at(t + 1e-5).0 - wave.at(t - 1e-5).0) / 2e-5;
            assert!((difference - wave.at(t).1).abs() < 1e-6);
        }
    }
}
