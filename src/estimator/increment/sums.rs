//! Sums of the increment in progress, which begin anew with each increment as one value.

use super::Increment;
use crate::{
    compensation::GyroModel,
    estimator::real::{M3, Real, V3, identity, norm, rotation, rotation_vector, square, widened, zero3, zero33},
    sample::BEYOND_ANY_ACCEL_M_S2,
    units::STANDARD_GRAVITY_M_S2,
};

/// Specific force that may be missing in the mean of an increment with a clipped reading: the full scale of 16 g of the
/// parts for drilling.
const CLIPPED_M_S2: f32 = 16.0 * STANDARD_GRAVITY_M_S2;

/// The gyro model that rotations are composed with.
#[derive(Clone, Copy)]
pub struct Composition<T> {
    p: M3<T>,
    inverse: M3<T>,
    bias: V3<T>,
}

impl<T: Real> Composition<T> {
    pub const fn zero() -> Self {
        Self { p: zero33(), inverse: zero33(), bias: zero3() }
    }

    /// `None` where P has no inverse.
    pub fn new(model: &GyroModel) -> Option<Self> {
        let p = model.p_matrix();
        let inverse = p.try_inverse()?;
        let wide = |m: &nalgebra::Matrix3<f32>| M3::from_fn(|i, j| m.get((i, j)).map_or(T::ZERO, |x| T::of(*x)));
        Some(Self { p: wide(&p), inverse: wide(&inverse), bias: widened(&V3::from(model.b_rad_s)) })
    }
}

/// Sums of the increment in progress. Vectors are those of its beginning.
#[derive(Clone, Copy)]
pub(super) struct Sums<T> {
    with: Composition<T>,
    pub samples: u16,
    pub seconds: T,
    /// Sum of the angles, rad.
    pub turned: T,
    /// Rotation from the present to the beginning.
    pub rotation: M3<T>,
    /// Sum of the specific forces, and their number.
    pub force: V3<T>,
    pub forces: u16,
    field: V3<T>,
    fields: u16,
    /// Squares of the specific force's steps from sample to sample, and their number.
    steps: T,
    pairs: u16,
    /// Rates less the bias, and their squares.
    pub rates: V3<T>,
    pub squares: V3<T>,
    square_force: T,
    square_peak: T,
    pub unread_turn: T,
    pub unread_velocity: T,
}

impl<T: Real> Sums<T> {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self {
            with: Composition::zero(),
            samples: 0,
            seconds: T::ZERO,
            turned: T::ZERO,
            rotation: zero33(),
            force: zero3(),
            forces: 0,
            field: zero3(),
            fields: 0,
            steps: T::ZERO,
            pairs: 0,
            rates: zero3(),
            squares: zero3(),
            square_force: T::ZERO,
            square_peak: T::ZERO,
            unread_turn: T::ZERO,
            unread_velocity: T::ZERO,
        }
    }

    /// Sums of an increment that begins now; `with` is what its rotations are composed with.
    pub fn begun(with: &Composition<T>) -> Self {
        Self { with: *with, rotation: identity(), ..Self::zero() }
    }

    /// Begins after a gap. A blow in the gap is one at its end: a step of the bias is looked for there.
    pub fn begin_after_gap(&mut self, with: &Composition<T>) {
        let square_peak = self.square_peak;
        *self = Self { square_peak, ..Self::begun(with) };
    }

    /// Notes the size of a specific force, also of one beside which there is no rate.
    pub fn note_peak(&mut self, force: &V3<T>) {
        let square = square(force);
        self.square_peak = if square > self.square_peak { square } else { self.square_peak };
    }

    /// A raw rate less the bias, and the turn that it makes in some seconds.
    pub fn turn(&self, rate: &V3<T>, seconds: T) -> [V3<T>; 2] {
        let centred = rate - self.with.bias;
        [centred, self.with.p * centred * seconds]
    }

    /// Turns on. Returns the rotation at which the readings stand: in the middle of the turn for readings of an
    /// instant, else at its end.
    pub fn go_on(&mut self, turn: &V3<T>, is_instant: bool) -> M3<T> {
        if is_instant {
            let half = rotation(&(turn * T::of(0.5)));
            let middle = self.rotation * half;
            self.rotation = middle * half;
            middle
        } else {
            self.rotation *= rotation(turn);
            self.rotation
        }
    }

    /// Notes a clipped specific force: a blow beyond the full scale, for as long as a sample stands for.
    pub fn lose_force(&mut self, period_s: T) {
        self.square_peak = T::of(BEYOND_ANY_ACCEL_M_S2 * BEYOND_ANY_ACCEL_M_S2);
        self.unread_velocity += square(&V3::new(T::of(CLIPPED_M_S2) * period_s, T::ZERO, T::ZERO));
    }

    /// Adds a sample: its rate less the bias and its turn, and the readings, which stand at the rotation `at`.
    pub fn add(
        &mut self,
        seconds: T,
        [centred, turn]: [&V3<T>; 2],
        at: &M3<T>,
        [force_before, force]: [Option<V3<T>>; 2],
        field: Option<V3<T>>,
    ) {
        // A sensor's reading is a mean as the gyro's is, over a sample period: what turns through it is shorter by
        // angle^2 / 24 across the axis.
        let turned = |read: &V3<T>| at * (read - turn.cross(&turn.cross(read)) * T::of(1.0 / 24.0));
        if let Some(force) = force {
            self.force += turned(&force);
            self.forces += 1;
            if let Some(before) = force_before {
                self.steps += square(&(force - before));
                self.pairs += 1;
            }
            self.square_force += square(&force);
        }
        if let Some(field) = field {
            self.field += turned(&field);
            self.fields += 1;
        }
        self.rates += centred;
        self.squares += centred.component_mul(centred);
        self.samples += 1;
        self.seconds += seconds;
        self.turned += norm(turn);
    }

    /// Returns the increment that ends now; `warming_k`: temperature over the effects' reference temperature, K.
    pub fn end(&self, end_us: u64, warming_k: Option<T>) -> Increment<T> {
        let turned = rotation_vector(&self.rotation);
        let back = rotation(&(turned * T::of(-0.5)));
        let mean = |sum: &V3<T>, count: u16| (count > 0).then(|| back * (sum / T::of(f32::from(count))));
        let n = T::of(f32::from(self.samples));
        let rates = self.rates / n;
        Increment {
            end_us,
            seconds: self.seconds,
            rate: self.with.inverse * turned / self.seconds + self.with.bias,
            force: mean(&self.force, self.forces),
            field: mean(&self.field, self.fields),
            // The difference of two samples has twice the variance, and there are three axes.
            vibration: if self.pairs > 0 { self.steps / T::of(6.0 * f32::from(self.pairs)) } else { T::ZERO },
            mean_rate: rates + self.with.bias,
            rate_variance: self.squares / n - rates.component_mul(&rates),
            square_force: if self.forces > 0 { self.square_force / T::of(f32::from(self.forces)) } else { T::ZERO },
            peak: self.square_peak.root(),
            warming_k,
            unread_turn: self.unread_turn,
            unread_velocity: self.unread_velocity,
        }
    }
}
