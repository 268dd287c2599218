//! A second flight on the host that reads the estimator at each of its steps.

use meerkat_mwd::{
    Probe,
    estimator::{MovedByRows, WidthEvidence},
};

use testbed::trace::Trace;

/// Number of kinds of rows that move P.
pub(super) const KINDS: usize = 4;

/// Change of P's elements by kind of rows.
pub(super) type Moved = [[f64; 9]; KINDS];

/// State of the estimator when an update was asked for.
pub(super) struct Update {
    /// Time of its last sample, microseconds.
    pub t_us: u64,
    /// Evidence about the widths of the vector sensors' errors.
    pub evidence: WidthEvidence,
    /// Change of P since the start by the rows of each kind: field, velocity, position, rest.
    pub moved: Moved,
}

/// Flies the samples and collects every update. The results equal those of any other flight: they do not
/// depend on how the work is sliced.
pub(super) fn updates(mut probe: Box<Probe>, trace: &Trace) -> Vec<Update> {
    let mut updates = Vec::new();
    let mut moved = [[0.0; 9]; KINDS];
    for sample in trace.samples() {
        if probe.push(&sample).is_none() {
            continue;
        }
        // Step by step, with at least as much work as the chip does.
        for _ in 0..probe.poll_budget() {
            if !probe.poll_one() {
                break;
            }
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
