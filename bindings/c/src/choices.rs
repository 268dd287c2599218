//! Choices of a configuration, each by its number.

use crate::config_fault::ConfigFault;
use meerkat_mwd::config::{Motion, OptimizerKind};

/// Motion by a hand that turns and swings the probe.
pub const MWD_MOTION_HAND: u32 = 0;
/// Motion in a drill string, or on a rig that turns the probe without carrying it about. The default.
pub const MWD_MOTION_DRILL_STRING: u32 = 1;
/// Search by the improved meerkat optimisation algorithm. The default.
pub const MWD_SEARCH_IMOA: u32 = 0;
/// Search by Levenberg-Marquardt.
pub const MWD_SEARCH_LM: u32 = 1;
/// No search: the estimator's mean itself.
pub const MWD_SEARCH_LS: u32 = 2;

pub(crate) fn truth(number: u32, field: &'static str) -> Result<bool, ConfigFault> {
    match number {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(ConfigFault::Choice { field, must_be: "0 or 1" }),
    }
}

pub(crate) fn motion_number(motion: Motion) -> u32 {
    match motion {
        Motion::Hand => MWD_MOTION_HAND,
        _ => MWD_MOTION_DRILL_STRING,
    }
}

pub(crate) fn motion(number: u32, field: &'static str) -> Result<Motion, ConfigFault> {
    match number {
        MWD_MOTION_HAND => Ok(Motion::Hand),
        MWD_MOTION_DRILL_STRING => Ok(Motion::DrillString),
        _ => Err(ConfigFault::Choice { field, must_be: "MWD_MOTION_HAND or MWD_MOTION_DRILL_STRING" }),
    }
}

/// The baselines of `baseline-searches` are not in this library.
pub(crate) fn search_number(search: OptimizerKind) -> u32 {
    match search {
        OptimizerKind::Lm => MWD_SEARCH_LM,
        OptimizerKind::Ls => MWD_SEARCH_LS,
        _ => MWD_SEARCH_IMOA,
    }
}

pub(crate) fn search(number: u32, field: &'static str) -> Result<OptimizerKind, ConfigFault> {
    match number {
        MWD_SEARCH_IMOA => Ok(OptimizerKind::Imoa),
        MWD_SEARCH_LM => Ok(OptimizerKind::Lm),
        MWD_SEARCH_LS => Ok(OptimizerKind::Ls),
        _ => Err(ConfigFault::Choice { field, must_be: "MWD_SEARCH_IMOA, MWD_SEARCH_LM or MWD_SEARCH_LS" }),
    }
}
