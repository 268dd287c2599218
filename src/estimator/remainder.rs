//! Remainder: innovations that no effect explains, and the quantities that they go with (docs/effects.md, "The
//! verdict").

mod conditions;
mod correlate;
mod correlation;
mod whiteness;
#[cfg(test)]
mod tests;

use crate::compensation::Snapshot;
use conditions::Conditions;
pub use correlate::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
use correlation::{COUNT, Moments};
use nalgebra::{Matrix3, Vector3};
use whiteness::Whiteness;

/// Nodes over which innovations are averaged: a minute.
pub(super) const INNOVATIONS: u16 = 120;

/// Rate of false alarms on a white remainder, all tests together. Half of it is for its memory, half is divided among
/// the quantities (Bonferroni).
const FALSE_ALARMS: f32 = 0.01;

/// Rate of false alarms of the memory's test.
const LIMIT_OF_MEMORY: f32 = FALSE_ALARMS / 2.0;

/// Rate of false alarms of one quantity's test.
const LIMIT: f32 = FALSE_ALARMS / (2 * COUNT) as f32;

/// Sums, of fixed size, of the latest nodes' innovations and conditions.
pub(super) struct Remainder {
    conditions: Conditions,
    moments: Moments,
    whiteness: Whiteness,
    nodes: u16,
    seconds: f32,
    /// Nodes whose field contradicted everything known.
    contradicted: u16,
    /// Mean square of a component of the field's innovations, over the latest minute.
    dispersion: f32,
    /// Number of nodes that the dispersion is of.
    dispersed: u16,
}

impl Remainder {
    pub const fn zero() -> Self {
        Self {
            conditions: Conditions::zero(),
            moments: Moments::zero(),
            whiteness: Whiteness::zero(),
            nodes: 0,
            seconds: 0.0,
            contradicted: 0,
            dispersion: 0.0,
            dispersed: 0,
        }
    }

    /// Begins as new.
    pub fn forget(&mut self) {
        (self.dispersion, self.dispersed) = (0.0, 0);
        self.start();
    }

    /// Begins anew, but keeps the dispersion.
    pub fn start(&mut self) {
        *self = Self { dispersion: self.dispersion, dispersed: self.dispersed, ..Self::zero() };
    }

    /// Takes the conditions of an increment, turned by `rotation` into the frame of the earth.
    pub fn watch(&mut self, moment: &Snapshot, rotation: &Matrix3<f32>) {
        self.conditions.take(moment, rotation);
    }

    /// Begins a node: the conditions to come are its own.
    pub fn start_node(&mut self) {
        self.conditions.start();
    }

    /// Ends a node with the field's innovations, as turns about the axes of the body and as vectors of the earth, in
    /// units of their deviations.
    pub fn add(&mut self, seconds: f32, [body, earth]: [Vector3<f32>; 2]) {
        self.moments.add(&self.conditions.of_node(self.seconds), &[body, earth]);
        self.whiteness.add(self.nodes, &body);
        self.dispersed = if self.dispersed < INNOVATIONS { self.dispersed + 1 } else { INNOVATIONS };
        // All three components: a turn leaves out the one along the field.
        self.dispersion += (earth.norm_squared() / 3.0 - self.dispersion) / f32::from(self.dispersed);
        self.nodes = self.nodes.saturating_add(1);
        self.seconds += seconds;
    }

    /// Counts a node whose field was left out because it contradicted everything known.
    pub fn contradict(&mut self) {
        self.contradicted = self.contradicted.saturating_add(1);
    }

    /// Returns true if more fields contradicted than the one in 10,000 that does by chance: two in a window happen by
    /// chance in one of 20,000 windows.
    pub const fn is_contradicted(&self) -> bool {
        self.contradicted > 1
    }

    /// Variance of the field's innovations over the latest minute, over the one that they should have: 1 if the noise
    /// is stated right.
    pub const fn dispersion(&self) -> f32 {
        self.dispersion
    }

    /// Returns the quantities that the remainder goes with.
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
        let node_s = if self.nodes > 0 { self.seconds / f32::from(self.nodes) } else { 0.0 };
        report.memory = self.whiteness.memory(&mean, self.moments.scatter_in_body(), node_s);
        report.has_memory = report.memory.p_value <= LIMIT_OF_MEMORY;
        report
    }
}

/// Returns true if a finding is less likely to be chance; of two that cannot be chance at all, if it explains more.
fn is_clearer(a: &GoesWith, b: &GoesWith) -> bool {
    a.p_value < b.p_value || (a.p_value <= b.p_value && a.share > b.share)
}
