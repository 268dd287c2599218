use super::{bias_step::BiasStep, stream::SampleStream};
use crate::{
    compensation::effect::{Moment, REFERENCE_TEMPERATURE_C},
    rotation::{IDENTITY, exp_quaternion, matrix, middle_to_middle, renormalised},
};
use nalgebra::{Matrix3, Quaternion, Vector3};

/// What one increment holds for the diagnosis.
pub(super) struct Instant {
    /// Takes a body vector into the frame of the walk's beginning.
    pub rotation: Matrix3<f32>,
    /// Raw rate, rad/s.
    pub raw_rad_s: Vector3<f32>,
    pub moment: Moment,
    /// Whether rate, specific force and field were read; where they were not, the moment holds the last ones.
    pub read: [bool; 3],
}

/// Walks through a window's increments with one gyro model.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    attitude: Quaternion<f32>,
    /// Compensated rates of the increments before, of this one and of the next.
    rates: [Vector3<f32>; 3],
    raws: [Vector3<f32>; 2],
    rate_read: [bool; 2],
    force: Vector3<f32>,
    field: Vector3<f32>,
}

impl Walk {
    #[inline(always)]
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            attitude: Quaternion::from_vector(nalgebra::Vector4::new(0.0, 0.0, 0.0, 0.0)),
            rates: [zero; 3],
            raws: [zero; 2],
            rate_read: [false; 2],
            force: zero,
            field: zero,
        }
    }

    /// Begins at increment `from`.
    pub fn start(&mut self, stream: &SampleStream, from: u32, (p, c, step): (&Matrix3<f32>, &Vector3<f32>, &BiasStep)) {
        *self = Self { attitude: IDENTITY, ..Self::zero() };
        let first = stream.read(from).rate;
        let raw = first.unwrap_or_default();
        self.rates = [p * raw - c + step.correction_rad_s(from); 3];
        self.raws = [raw; 2];
        self.rate_read = [first.is_some(); 2];
    }

    /// Turns to increment `index`, the next one. Its derivative of the rate takes a look at the one after it.
    pub fn advance(
        &mut self,
        (stream, to): (&SampleStream, u32),
        index: u32,
        (p, c, step): (&Matrix3<f32>, &Vector3<f32>, &BiasStep),
    ) -> Instant {
        let increment = stream.read(index);
        // What comes after the end may be there already or not.
        let next = if index + 1 < to { stream.read(index + 1).rate } else { None };
        let [_, raw] = self.raws;
        let raw_next = next.unwrap_or(raw);
        let [_, before, now] = self.rates;
        let after = p * raw_next - c + step.correction_rad_s(index + 1);
        let [_, read] = self.rate_read;
        let interval_s = stream.grid.interval_s();
        let earlier = self.rates.first().copied().unwrap_or(before);
        let turn = middle_to_middle([&earlier, &before, &now], interval_s);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&turn)));
        let acceleration = (after - before) / (2.0 * interval_s);
        self.rates = [before, now, after];
        self.raws = [raw, raw_next];
        self.rate_read = [read, next.is_some()];
        // Specific force is minus gravity's reading.
        self.force = increment.gravity.map_or(self.force, |gravity| -gravity);
        self.field = increment.field.unwrap_or(self.field);
        let surroundings = stream.surroundings.get(index);
        Instant {
            rotation: matrix(&self.attitude),
            raw_rad_s: raw,
            moment: Moment {
                rate_rad_s: now,
                acceleration_rad_s2: acceleration,
                force_m_s2: self.force,
                square_force_m2_s4: surroundings.square_force_m2_s4,
                field_ut: self.field,
                warming_k: surroundings.temperature_c.map_or(0.0, |t| t - REFERENCE_TEMPERATURE_C),
            },
            read: [read, increment.gravity.is_some(), increment.field.is_some()],
        }
    }
}
