//! What a residual that no candidate explains goes with.

mod conditions;
mod correlate;
mod correlation;
mod whiteness;
#[cfg(test)]
mod tests;

pub use correlate::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub(in crate::diagnosis) use correlation::chance_of_ratio;

use super::{
    walk::Instant,
    weak_columns::{GYRO, Rows},
};
use conditions::Conditions;
use correlation::{COUNT, Moments};
use nalgebra::Vector3;
use whiteness::Whiteness;

/// Rate at which anything is said of a white remainder. Half of it is for its memory, half is shared out among the quantities (Bonferroni).
const FALSE_ALARMS: f32 = 0.01;

/// The same of the memory.
const LIMIT_OF_MEMORY: f32 = FALSE_ALARMS / 2.0;

/// The same of one quantity.
const LIMIT: f32 = FALSE_ALARMS / (2 * COUNT) as f32;

/// Sums over the test windows of one pass, of fixed size.
pub(super) struct Remainder {
    conditions: Conditions,
    moments: Moments,
    whiteness: Whiteness,
    hop_s: f32,
    /// Of the test window in progress: the pull on a bias, the information about it, and the field's residual.
    pull: Vector3<f32>,
    information: f32,
    field: Option<Vector3<f32>>,
}

impl Remainder {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            conditions: Conditions::zero(),
            moments: Moments::zero(),
            whiteness: Whiteness::zero(),
            hop_s: 0.0,
            pull: Vector3::new(0.0, 0.0, 0.0),
            information: 0.0,
            field: None,
        }
    }

    /// Begins a pass whose test windows begin every `hop` increments.
    #[inline(never)]
    pub fn start(&mut self, hop: usize, interval_s: f32) {
        self.conditions.start(hop);
        self.moments = Moments::zero();
        self.whiteness.start();
        self.hop_s = hop as f32 * interval_s;
        self.begin_test();
    }

    fn begin_test(&mut self) {
        self.pull = Vector3::zeros();
        self.information = 0.0;
        self.field = None;
    }

    /// Takes the conditions of the next instant.
    pub fn watch(&mut self, instant: &Instant) {
        self.conditions.take(instant);
    }

    /// Takes gravity's (0) or the field's (1) residual of a test window, with its rows and its weight.
    #[inline(never)]
    pub fn add(&mut self, vector: usize, rows: &Rows, residual: &[f32; 3], weight: f32) {
        for (row, r) in rows.iter().zip(residual) {
            let of_bias = row.iter().skip(GYRO - 3).take(3);
            for (pull, a) in self.pull.iter_mut().zip(of_bias) {
                *pull += weight * a * r;
                self.information += weight * a * a;
            }
        }
        if vector == 1 {
            self.field = Some(Vector3::from(*residual) * libm::sqrtf(weight));
        }
    }

    /// Ends the test window, the `number`th. Without a field it does not count: the verdict is about the field's.
    #[inline(never)]
    pub fn end_test(&mut self, number: usize) {
        if let Some(field) = self.field.filter(|_| self.information > 0.0) {
            let pull = self.pull / libm::sqrtf(self.information);
            self.moments.add(&self.conditions.of_window(number), &[pull, field]);
            self.whiteness.add(number, &pull);
        }
        self.begin_test();
    }

    /// What the remainder of the pass goes with.
    #[inline(never)]
    pub fn report(&self) -> RemainderReport {
        let mut report = RemainderReport::default();
        let tests = self.moments.tests();
        for slot in 0..MOST_NAMED {
            let others = tests.iter().flatten().filter(|test| test.p_value <= LIMIT);
            let not_named = others.filter(|test| report.named().all(|named| named.correlate != test.correlate));
            let clearest = not_named.copied().reduce(|a, b| if is_clearer(&b, &a) { b } else { a });
            let (Some(found), Some(slot)) = (clearest, report.goes_with.get_mut(slot)) else { break };
            *slot = found;
            report.count += 1;
        }
        let mean = self.moments.mean_in_body();
        report.memory = self.whiteness.memory(&mean, self.moments.scatter_in_body(), self.hop_s);
        report.has_memory = report.memory.p_value <= LIMIT_OF_MEMORY;
        report
    }
}

/// Whether a finding is less likely to be chance; of two that cannot be it at all, whether it takes more.
fn is_clearer(a: &GoesWith, b: &GoesWith) -> bool {
    a.p_value < b.p_value || (a.p_value <= b.p_value && a.share > b.share)
}
