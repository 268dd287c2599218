//! The flight once more, on the host, with an eye on the estimator at each of its steps.

use meerkat_mwd::{
    Probe, Sample,
    estimator::{MovedByRows, WidthEvidence},
};

/// Kinds of rows that move P.
pub(super) const KINDS: usize = 4;

/// Elements of P by kind of rows.
pub(super) type Moved = [[f64; 9]; KINDS];

/// What the estimator rested on when an update was asked for.
pub(super) struct Update {
    /// Last sample of it, microseconds.
    pub t_us: u64,
    /// About the widths of the vector sensors' errors.
    pub evidence: WidthEvidence,
    /// By how much the rows of each kind have moved P since the start: field, velocity, position, rest.
    pub moved: Moved,
}

/// Flies the samples. The results are those of any other flight over them: how the work is sliced does not change them.
pub(super) fn updates(mut probe: Box<Probe>, samples: &[Sample]) -> Vec<Update> {
    let mut updates = Vec::new();
    let mut moved = [[0.0; 9]; KINDS];
    for sample in samples {
        if probe.push(sample).is_none() {
            continue;
        }
        // One step at a time, and at least as much work as the chip does.
        for _ in 0..probe.poll_budget() {
            probe.poll(1);
            if let Some(by) = probe.estimator().moved_by_rows() {
                add(&mut moved, &by);
            }
            if let Some(evidence) = probe.estimator().width_evidence() {
                updates.push(Update { t_us: sample.t_us, evidence, moved });
            }
        }
        probe.take_diagnosis();
    }
    updates
}

fn add(sum: &mut Moved, by: &MovedByRows) {
    for (sum, by) in sum.iter_mut().zip([by.field, by.velocity, by.position, by.rest]) {
        for (sum, by) in sum.iter_mut().zip(by) {
            *sum += f64::from(by);
        }
    }
}
