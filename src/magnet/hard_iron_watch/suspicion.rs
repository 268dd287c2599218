//! Suspicion of a magnet: two filters are compared, one with a jump of the offset in the body, one with a jump of the
//! earth's field (Wald's sequential test).

use super::{
    super::{field_node::FieldNode, field_noise::at_most, hypothesis::Outcome},
    STEADY_NODES,
};
use crate::change::TURNING_RAD_S;

/// Log likelihood ratio that decides between the hypotheses: Wald's bound for one error in a million.
const DECIDED: f32 = 13.8;
/// Log likelihood ratio, 20 to 1. For the earth's field: an undecided change is left to the attitude filter, which
/// rejects such fields itself. For iron: an undecided change is held, for it may be told by how it leaves.
const LIKELY: f32 = 3.0;
/// Largest contribution of one node to the ratio, so that no single node decides.
const MOST_OF_A_NODE: f32 = 5.0;
/// Time for which an offset must have been steady, seconds: passing disturbances last 2 s, and changes under 3 s apart
/// count as one.
const STEADY_S: f32 = 3.0;
/// Consecutive nodes with a field as predicted that end a disturbance (1 s).
const QUIET_NODES: u8 = 5;
/// Time of turning after which an undecided change is dropped, seconds, the same as for a new field in the
/// attitude filter; time at rest counts by a sixth.
const PATIENCE_S: f32 = 20.0;
const STILL_WEIGHT: f32 = 1.0 / 6.0;

/// Outcome of a suspicion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    Iron,
    Earth,
    Passed,
    Untold,
}

/// Change of the field under examination.
#[derive(Clone, Copy)]
pub(super) struct Suspicion {
    /// Time of the first node that did not fit the prediction, and of the last one after it at which the body-fixed
    /// offset jumped again, microseconds.
    pub first_us: u64,
    pub last_us: u64,
    /// Log likelihood of new iron over that of a new earth field.
    log_ratio: f32,
    steady_s: f32,
    age_s: f32,
    quiet: u8,
    /// Nodes at which the body-fixed offset jumped again.
    jumps: u8,
    /// True if the field was as predicted before the change.
    sudden: bool,
    /// True if the change, as a body-fixed offset, is large enough to matter.
    matters: bool,
}

impl Suspicion {
    /// Starts at the first node that did not fit the prediction.
    pub const fn new(t_us: u64, sudden: bool) -> Self {
        Self {
            first_us: t_us,
            last_us: t_us,
            log_ratio: 0.0,
            steady_s: 0.0,
            age_s: 0.0,
            quiet: 0,
            jumps: 0,
            sudden,
            matters: false,
        }
    }

    /// Returns true while the field should be withheld until the verdict.
    pub fn is_doubtful(&self) -> bool {
        self.log_ratio > -LIKELY && self.matters && self.sudden
    }

    /// Returns true if new iron is likelier than a new earth field, though not decided.
    pub fn is_likely_iron(&self) -> bool {
        self.log_ratio > LIKELY
    }

    /// Weighs a node by both hypotheses. `quiet`: the node is as predicted without a change; `matters`: the
    /// body-fixed offset is large enough to matter.
    pub fn weigh(
        &mut self,
        (t_us, node): (u64, &FieldNode),
        [iron, earth]: [&Outcome; 2],
        quiet: bool,
        matters: bool,
    ) -> Option<Verdict> {
        self.matters = matters;
        let ratio = iron.log_likelihood - earth.log_likelihood;
        self.log_ratio += at_most(if ratio > -MOST_OF_A_NODE { ratio } else { -MOST_OF_A_NODE }, MOST_OF_A_NODE);
        if iron.jumped {
            (self.last_us, self.steady_s) = (t_us, 0.0);
            self.jumps = self.jumps.saturating_add(1);
        } else {
            self.steady_s += node.time_s;
        }
        let rate_rad_s = node.angle_rad / node.time_s;
        self.age_s += node.time_s * if rate_rad_s > TURNING_RAD_S { 1.0 } else { STILL_WEIGHT };
        self.quiet = if quiet { self.quiet.saturating_add(1) } else { 0 };
        self.verdict()
    }

    fn verdict(&self) -> Option<Verdict> {
        let steady = self.steady_s > STEADY_S;
        if self.log_ratio > DECIDED && steady {
            Some(Verdict::Iron)
        } else if self.log_ratio < -DECIDED {
            Some(Verdict::Earth)
        } else if !self.matters && steady {
            Some(if self.log_ratio > 0.0 { Verdict::Iron } else { Verdict::Earth })
        } else if self.quiet >= QUIET_NODES {
            Some(Verdict::Passed)
        } else if self.age_s > PATIENCE_S || self.jumps > STEADY_NODES {
            Some(Verdict::Untold)
        } else {
            None
        }
    }
}
