use super::{
    super::{
        field_node::FieldNode,
        field_noise::{TURNING_RAD_S, at_most},
        hypothesis::Met,
    },
    STEADY_NODES,
};

/// One hypothesis is taken and the other dropped at this log ratio of their likelihoods: Wald's bound for one error in a million.
const DECIDED: f32 = 13.8;
/// At this log ratio, 20 to 1, an undecided change is likely enough one of the earth's field to be left to the attitude filter, which has
/// its own way with those.
const LIKELY: f32 = 3.0;
/// Most that one node may say for or against, so that no single one decides.
const MOST_OF_A_NODE: f32 = 5.0;
/// An offset must have been steady for so long, seconds: disturbances in passing last 2 s, and edges under 3 s apart are one.
const STEADY_S: f32 = 3.0;
/// Consecutive nodes as predicted after which a disturbance is over (1 s).
const QUIET_NODES: u8 = 5;
/// What cannot be told apart in this time of turning, seconds, is dropped; while the probe stands still it counts by a sixth. The same as
/// for a new field in the attitude filter.
const PATIENCE_S: f32 = 20.0;
const STILL_WEIGHT: f32 = 1.0 / 6.0;

/// How a change of the field ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    Iron,
    Earth,
    Passed,
    Untold,
}

/// The change that is being looked into.
#[derive(Clone, Copy)]
pub(super) struct Suspicion {
    /// First node that did not fit, and the last one of those after it in which an offset in the body did not stay, microseconds.
    pub first_us: u64,
    pub last_us: u64,
    /// Log likelihood of iron over that of the earth's field.
    log_ratio: f32,
    steady_s: f32,
    age_s: f32,
    quiet: u8,
    /// Nodes in which an offset in the body did not stay.
    jumps: u8,
    /// Whether the field was as predicted before.
    sudden: bool,
    /// Whether the offset in the body, if it is one, matters.
    matters: bool,
}

impl Suspicion {
    /// At its first node.
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

    /// Whether the field is better not used until this is told.
    pub fn is_doubtful(&self) -> bool {
        self.log_ratio > -LIKELY && self.matters && self.sudden
    }

    /// Takes a node as both hypotheses met it; `quiet`: it is as predicted if nothing has changed; `matters`: the offset in the body is of
    /// a size that does.
    pub fn weigh(
        &mut self,
        (t_us, node): (u64, &FieldNode),
        [iron, earth]: [&Met; 2],
        quiet: bool,
        matters: bool,
    ) -> Option<Verdict> {
        self.matters = matters;
        let ratio = iron.log_likelihood - earth.log_likelihood;
        self.log_ratio += at_most(if ratio > -MOST_OF_A_NODE { ratio } else { -MOST_OF_A_NODE }, MOST_OF_A_NODE);
        if iron.reopened {
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
