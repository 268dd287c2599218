//! A cost of one's own: the amplitude, decay, frequency and phase of a damped oscillation from 200 noisy readings. A
//! population search finds the right hill among the frequencies, Levenberg-Marquardt its top.
//!
//! `cargo run --example own_cost`

use meerkat_mwd::optimizer::{
    Cost, Found, Imoa, ImoaSettings, LeastSquaresCost, LevenbergMarquardt, Optimizer, OptimizerError, Packed, Progress,
    SearchSpace,
};

/// Readings y(t) of amplitude e^(-decay t) cos(frequency t + phase).
struct Oscillation {
    /// Time in seconds and reading in volts.
    readings: Vec<(f32, f32)>,
}

/// Amplitude (V), decay (1/s), angular frequency (rad/s), phase (rad).
pub(crate) const TRUE: [f32; 4] = [1.4, 0.35, 6.1, 0.8];

fn reading(x: &[f32; 4], t: f32) -> f32 {
    let [amplitude, decay, frequency, phase] = *x;
    amplitude * libm::expf(-decay * t) * libm::cosf(frequency * t + phase)
}

impl Oscillation {
    /// 10 seconds at 20 Hz with an error of up to 50 mV, drawn from a multiplicative congruence.
    fn measure() -> Self {
        let mut state = 12_345_u32;
        let readings = (0..200_u8).map(|i| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let error = 0.05 * ((state >> 8) as f32 / 8_388_608.0 - 1.0);
            let t = f32::from(i) * 0.05;
            (t, reading(&TRUE, t) + error)
        });
        Self { readings: readings.collect() }
    }
}

impl Cost<4> for Oscillation {
    fn evaluate(&self, x: &[f32; 4]) -> f32 {
        self.readings.iter().map(|(t, y)| (y - reading(x, *t)) * (y - reading(x, *t))).sum()
    }
}

/// Only Levenberg-Marquardt asks for this.
impl LeastSquaresCost<4, 10> for Oscillation {
    fn normal_equations(&self, x: &[f32; 4], normal: &mut Packed<4, 10>, descent: &mut [f32; 4]) {
        *normal = Packed::zero();
        *descent = [0.0; 4];
        let [amplitude, decay, frequency, phase] = *x;
        for &(t, y) in &self.readings {
            let envelope = libm::expf(-decay * t);
            let (sine, cosine) = libm::sincosf(frequency * t + phase);
            let row = [
                envelope * cosine,
                -t * amplitude * envelope * cosine,
                -t * amplitude * envelope * sine,
                -amplitude * envelope * sine,
            ];
            normal.add_outer(&row, 1.0);
            for (sum, slope) in descent.iter_mut().zip(&row) {
                *sum += slope * (y - reading(x, t));
            }
        }
    }
}

/// Fits and returns the parameters.
pub(crate) fn fit() -> Result<[f32; 4], OptimizerError> {
    let cost = Oscillation::measure();
    let space = SearchSpace::within([0.1, 0.0, 1.0, -3.2], [5.0, 2.0, 12.0, 3.2])?;
    let mut search = Imoa::<4, 24>::new(&space, ImoaSettings::new(6_000), 1)?;
    // In slices, as a program does that has something more urgent to do between them.
    let mut slices = 1;
    while search.run(&cost, 50) == Progress::Running {
        slices += 1;
    }
    let (found, sum) = search.best();
    println!("search:   {found:.4?}, sum of squares {sum:.5}, {slices} slices");

    let mut polish = LevenbergMarquardt::<4, 10>::new(*found, 50);
    polish.run(&cost, 100);
    let (found, sum) = polish.best();
    println!("polished: {found:.4?}, sum of squares {sum:.5}, {} evaluations", polish.evaluations());
    println!("true:     {TRUE:.4?}");
    Ok(*found)
}

pub(crate) fn main() -> Result<(), OptimizerError> {
    fit().map(|_| ())
}
