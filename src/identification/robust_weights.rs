use super::graduation::Graduation;
use crate::{
    algebra::quantile,
    window::{Equations, MAGNETIC, SampleStream, TESTS, TestEquations, gyro_part},
};

/// Quantile of the squared norm of three standard normal components below which a quarter of them lie (chi-square, 3 degrees of
/// freedom).
const QUARTER: f32 = 1.212_5;

/// Below this share of the field's weight the equations agree to within their sensor's noise hardly anywhere.
const LEAST_AGREEMENT: f32 = 0.2;

/// Margin on the field's noise: a scale that is too small costs more than one that is too large (half: 10 points of success under
/// contamination, double: 1).
const NOISE_MARGIN: f32 = 1.44;

/// Weights of a window's test windows, for gravity and field, by graduated non-convexity: windows that a casing joint, a shock train or a
/// saturated gyro bends lose their weight, without a first solution that has to be good.
pub(crate) struct RobustWeights {
    /// What each has lost of its weight, in 255ths.
    disregard: [[u8; 2]; TESTS],
    graduation: Graduation,
    /// Variance of one equation of a clean window: gravity, field.
    variances: [f32; 2],
}

impl RobustWeights {
    pub const fn zero() -> Self {
        Self { disregard: [[0; 2]; TESTS], graduation: Graduation::Over, variances: [0.0; 2] }
    }

    /// All ones.
    pub fn start(&mut self) {
        *self = Self::zero();
    }

    pub fn of(&self, number: u32) -> [f32; 2] {
        let stored = self.disregard.get(number as usize % TESTS).copied().unwrap_or([255; 2]);
        stored.map(|lost| f32::from(255 - lost) / 255.0)
    }

    /// From the residuals of the unweighted solution: the scales, and whether there is anything to weigh down.
    pub fn measure(
        &mut self,
        stream: &SampleStream,
        numbers: core::ops::Range<u32>,
        theta: &[f32; 12],
        x: &[f32; MAGNETIC],
    ) {
        let mut squares = [[0.0_f32; TESTS]; 2];
        let mut noise = [0.0_f32; TESTS];
        let mut counts = [0_usize; 2];
        for test in numbers.filter_map(|number| stream.test(number)) {
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
        self.variances = [own(gravity, counts[0]), NOISE_MARGIN * stream.noise_gain() * sensor_noise];
        self.begin(largest);
    }

    /// Begins the graduation by the largest of the field's squared residuals. Gravity's do not ask for one: shocks are many and
    /// harmless.
    fn begin(&mut self, largest: f32) {
        let [_, variance] = self.variances;
        self.graduation = Graduation::from(if variance > 0.0 { largest / variance } else { 0.0 });
    }

    /// Mean of the field's weights.
    fn field_agreement(&self, stream: &SampleStream, numbers: core::ops::Range<u32>) -> f32 {
        let seen = |number: &u32| stream.test(*number).is_some_and(|test| test.field.is_some());
        let (mut sum, mut count) = (0.0, 0.0);
        for [_, field] in numbers.filter(seen).map(|number| self.of(number)) {
            sum += field;
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 1.0 }
    }

    /// Whether there is a round to go.
    pub const fn is_running(&self) -> bool {
        !matches!(self.graduation, Graduation::Over)
    }

    /// Weighs some test windows anew by their residuals at a solution, in `sum` too.
    pub fn weigh(
        &mut self,
        stream: &SampleStream,
        numbers: impl Iterator<Item = u32>,
        theta: &[f32; 12],
        x: &[f32; MAGNETIC],
        sum: &mut Equations,
    ) {
        let graduation = self.graduation;
        for number in numbers {
            let (Some(test), Some(stored)) = (stream.test(number), self.disregard.get_mut(number as usize % TESTS))
            else {
                continue;
            };
            let mut weights = [1.0; 2];
            for ((weight, square), variance) in weights.iter_mut().zip(squares_of(test, theta, x)).zip(self.variances) {
                if let Some(square) = square {
                    *weight = graduation.weight(if variance > 0.0 { square / variance } else { 0.0 });
                }
            }
            // A fault of the gyro spoils both, but only the sharp field shows it.
            let [gravity, field] = weights;
            let new =
                [if field < gravity { field } else { gravity }, field].map(|w| 255 - libm::roundf(255.0 * w) as u8);
            let change = [0, 1].map(|sensor: usize| {
                let of = |weights: &[u8; 2]| weights.get(sensor).copied().map_or(0.0, f32::from);
                (of(stored) - of(&new)) / 255.0
            });
            sum.add(test, theta, change);
            *stored = new;
        }
    }

    /// To the next round, after a solution. Where the field agrees hardly anywhere, what bends it is no disturbance here and there but the
    /// rule: then all test windows weigh the same again, and the graduation is over.
    pub fn advance(&mut self, stream: &SampleStream, numbers: core::ops::Range<u32>) -> Round {
        let graduated = matches!(self.graduation, Graduation::GemanMcClure { .. });
        if graduated && self.field_agreement(stream, numbers) < LEAST_AGREEMENT {
            self.start();
            return Round::Again;
        }
        self.graduation = self.graduation.next();
        if self.is_running() { Round::Next } else { Round::Done }
    }
}

/// What comes after a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Round {
    Next,
    /// Every weight is 1 again, and the sums have to be made anew.
    Again,
    Done,
}

/// Squared norms of the residuals of gravity and field.
fn squares_of(test: &TestEquations, theta: &[f32; 12], x: &[f32; MAGNETIC]) -> [Option<f32>; 2] {
    let gravity = test.gravity.is_some().then(|| test.gravity.misfits(theta, &[gyro_part(x)]));
    let field = test.field.is_some().then(|| test.field.misfits(theta, &[*x]));
    [gravity, field].map(|squares| squares.map(|[square]| square))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        compensation::GyroModel,
        config::IdentificationConfig,
        identification::{
            least_squares::{MagnetometerErrors, solve_with_variances},
            prior::{Prior, theta_of},
        },
        rotation::rotate_back,
        window::{Reading, RestLimits, Scales, StreamSettings},
    };
    use core::ops::Range;
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// Increments of 20 ms in 50 s, and from one test window to the next; one lasts four of these.
    const INCREMENTS: u64 = 2_500;
    const HOP: u32 = 25;

    /// White noise of an increment: a vibrating accelerometer, a quiet magnetometer.
    const GRAVITY_NOISE_M_S2: f32 = 1.0;
    const FIELD_NOISE_UT: f32 = 0.2;

    /// Raw rate, gravity and field of an increment.
    type Readings = [Vector3<f32>; 3];

    /// 50 s of a body that tumbles smoothly, with a gyro whose scale errs by some percent; `disturb` changes each increment.
    fn tumbling(disturb: impl Fn(u32, &mut Readings)) -> SampleStream {
        let mut stream = SampleStream::zero();
        stream.configure(&StreamSettings {
            sample_period_us: 20_000,
            rest_limits: RestLimits { deviation_rad_s: 0.01, bias_rad_s: 0.08 },
            bias_walk_rad_s_rts: 1e-5,
            gravity_m_s2: 9.81,
            scales: Scales::new(10.0, 100.0, 300.0),
        });
        stream.start(0, &theta_of(&GyroModel::IDENTITY));
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
        let mut normal = || (0..12).map(|_| generator.next_u32() as f32 / u32::MAX as f32).sum::<f32>() - 6.0;
        let mut q = Quaternion::<f64>::identity();
        for k in 0..=INCREMENTS {
            let mut means = [Vector3::zeros(); 3];
            for j in 0..20 {
                let t = (k as f64 + (f64::from(j) + 0.5) / 20.0) * 0.02;
                let sine = |f: f64, phase: f64| libm::sin(core::f64::consts::TAU * f * t + phase);
                let rate =
                    Vector3::new(1.2 * sine(0.21, 0.3) + 0.3, sine(0.17, 1.7) - 0.2, 1.5 * sine(0.13, 2.9) + 0.4);
                q = (q * UnitQuaternion::from_scaled_axis(rate * 0.001).into_inner()).normalize();
                let single = q.cast::<f32>();
                let rate = rate.cast::<f32>().component_mul(&Vector3::new(1.02, 0.97, 1.01));
                means[0] += rate / 20.0;
                means[1] += rotate_back(&single, &Vector3::new(0.0, 0.0, 9.81)) / 20.0;
                means[2] += rotate_back(&single, &Vector3::new(20.0, 0.0, 45.0)) / 20.0;
            }
            for (mean, sigma) in means.iter_mut().zip([1e-3, GRAVITY_NOISE_M_S2, FIELD_NOISE_UT]) {
                *mean += Vector3::new(normal(), normal(), normal()) * sigma;
            }
            disturb(k as u32, &mut means);
            let [rate, gravity, field] = means.map(Reading::Good);
            stream.push(20_000 * k, rate, gravity, field, None);
        }
        stream
    }

    /// What the graduation came to.
    struct Weighed {
        weights: RobustWeights,
        solution: [f32; MAGNETIC],
        rounds: usize,
        /// Whether it began again.
        again: bool,
    }

    const THETA: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

    fn numbers(stream: &SampleStream) -> Range<u32> {
        stream.tests_within(0, stream.increments.count())
    }

    fn summed(stream: &SampleStream, weights: &RobustWeights) -> Equations {
        let mut sum = Equations::zero();
        for number in numbers(stream) {
            sum.add(stream.test(number).unwrap(), &THETA, weights.of(number));
        }
        sum
    }

    /// Solves, measures and weighs until it is done.
    fn weighed(stream: &SampleStream) -> Weighed {
        let prior = Prior::new(&IdentificationConfig::default(), &GyroModel::IDENTITY, None);
        let solve =
            |sum: &Equations| solve_with_variances(sum, &prior, &THETA, MagnetometerErrors::LagAndIron).unwrap().0;
        let mut weights = RobustWeights::zero();
        weights.start();
        let mut sum = summed(stream, &weights);
        let mut solution = solve(&sum);
        weights.measure(stream, numbers(stream), &THETA, &solution);
        let (mut rounds, mut again) = (0, false);
        while weights.is_running() {
            weights.weigh(stream, numbers(stream), &THETA, &solution, &mut sum);
            solution = solve(&sum);
            rounds += 1;
            assert!(rounds < 100, "it ends");
            match weights.advance(stream, numbers(stream)) {
                Round::Next => {}
                Round::Again => {
                    assert!(!again, "once");
                    assert!(numbers(stream).all(|number| weights.of(number) == [1.0; 2]), "from the start");
                    again = true;
                    sum = summed(stream, &weights);
                    solution = solve(&sum);
                }
                Round::Done => break,
            }
        }
        // Taking in and out by differences comes to the same as adding with the weights.
        let anew = solve(&summed(stream, &weights));
        for (i, (x, y)) in solution.iter().zip(&anew).enumerate().take(12) {
            assert!((x - y).abs() < 2e-4, "{i}: {x} {y}");
        }
        Weighed { weights, solution, rounds, again }
    }

    /// Largest error of the scale factors and couplings found.
    fn p_error(solution: &[f32; MAGNETIC]) -> f32 {
        let truth: [f32; 9] = [1.0 / 1.02 - 1.0, 0.0, 0.0, 0.0, 1.0 / 0.97 - 1.0, 0.0, 0.0, 0.0, 1.0 / 1.01 - 1.0];
        solution.iter().zip(&truth).map(|(x, truth)| (x - truth).abs()).max_by(f32::total_cmp).unwrap()
    }

    /// Whether increment `k` lies in one of three stretches of four seconds.
    fn in_trouble(k: u32) -> bool {
        [400..600, 1_100..1_300, 1_900..2_100].iter().any(|stretch| stretch.contains(&k))
    }

    /// How much of a test window's sin^2 lies in trouble, 0 to 1.
    fn share_in_trouble(number: u32) -> f32 {
        let length = 4 * HOP;
        let weight = |k: u32| 1.0 - libm::cosf(core::f32::consts::TAU * (k as f32 + 0.5) / length as f32);
        (0..length).filter(|k| in_trouble(number * HOP + k)).map(weight).sum::<f32>() / length as f32
    }

    #[test]
    fn a_clean_window_keeps_every_weight_and_nothing_is_begun() {
        let stream = tumbling(|_, _| {});
        let clean = weighed(&stream);
        assert_eq!((clean.rounds, clean.again), (0, false));
        assert!(numbers(&stream).count() > 90);
        assert!(numbers(&stream).all(|number| clean.weights.of(number) == [1.0; 2]));
        assert!(p_error(&clean.solution) < 2e-3, "{:?}", clean.solution);
        assert_eq!(clean.weights.field_agreement(&stream, numbers(&stream)), 1.0);
    }

    /// Steel beside the tool: the field is another for some seconds.
    #[test]
    fn windows_that_another_field_bends_end_without_weight_and_the_others_keep_theirs() {
        let stream = tumbling(|k, [_, _, field]| {
            if in_trouble(k) {
                *field += Vector3::new(12.0, -9.0, 14.0);
            }
        });
        let found = weighed(&stream);
        assert!(!found.again && found.rounds > 8, "{}", found.rounds);
        let (mut bent, mut clean, mut kept) = (0, 0, 0);
        for number in numbers(&stream) {
            let [gravity, field] = found.weights.of(number);
            let share = share_in_trouble(number);
            if share > 0.05 && share < 0.95 {
                // Where the field changes.
                assert!(field < 0.05, "{number}: {field}");
                bent += 1;
            } else if share == 0.0 {
                clean += 1;
                kept += u32::from(gravity > 0.5 && field > 0.5);
                assert!(gravity > 0.1 && field > 0.1, "{number}: {gravity} {field}");
            }
            assert!(gravity <= field, "{number}");
        }
        assert!(bent > 15 && clean > 50 && 10 * kept > 9 * clean, "{bent} {clean} {kept}");
        assert!(p_error(&found.solution) < 3e-3, "{:?}", found.solution);
    }

    /// Three tenths of the test windows with a fault in them; gravity, which vibrates, hardly shows it.
    #[test]
    fn a_fault_of_the_gyro_that_only_the_field_shows_takes_gravitys_weight_too() {
        let fault = Vector3::new(0.06, -0.05, 0.05);
        let stream = tumbling(|k, [rate, _, _]| {
            if in_trouble(k) {
                *rate += fault;
            }
        });
        let found = weighed(&stream);
        assert!(!found.again);
        let (mut bent, mut shown_by_gravity) = (0, 0);
        for number in numbers(&stream) {
            let [gravity, field] = found.weights.of(number);
            if share_in_trouble(number) > 0.3 {
                assert!(gravity < 0.02 && field < 0.02, "{number}: {gravity} {field}");
                let [Some(square), _] = squares_of(stream.test(number).unwrap(), &THETA, &found.solution) else {
                    panic!("gravity was read")
                };
                bent += 1;
                shown_by_gravity += u32::from(Graduation::Tukey(0).weight(square / found.weights.variances[0]) == 0.0);
            } else if share_in_trouble(number) == 0.0 {
                assert!(gravity > 0.5 && field > 0.5, "{number}: {gravity} {field}");
            }
        }
        assert!(bent >= 24 && 2 * shown_by_gravity < bent, "{shown_by_gravity} of {bent}");
        assert!(p_error(&found.solution) < 3e-3, "{:?}", found.solution);
    }

    /// A soft iron bends every test window by more than the sensor's noise, a little or a lot: no disturbance of some.
    #[test]
    fn where_hardly_any_window_agrees_all_weigh_the_same_again() {
        for (x, z) in [(1.02, 0.985), (1.2, 0.85)] {
            let stream = tumbling(|_, [_, _, field]| field.component_mul_assign(&Vector3::new(x, 1.0, z)));
            let found = weighed(&stream);
            assert!(found.again && !found.weights.is_running());
            assert!(numbers(&stream).all(|number| found.weights.of(number) == [1.0; 2]));
        }
    }

    #[test]
    fn a_sensor_without_a_scale_begins_nothing() {
        let mut weights = RobustWeights::zero();
        weights.variances = [1.0, 0.0];
        weights.begin(1e9);
        assert!(!weights.is_running());
        weights.variances = [1.0; 2];
        weights.begin(f32::NAN);
        assert!(!weights.is_running());
    }
}
