//! The exit status of the program: 0 done, 1 a defect, 2 bad input or usage, 3 something is missing.

use std::io;

use meerkat_mwd::config::ConfigError;

use crate::target::error::EmulateError;
use testbed::{failure::Failure, simulate::ScenarioError, trace::TraceError};

/// Bad input or usage.
const BAD_INPUT: u8 = 2;
/// A port, a key, an answer or a tool is not there.
const MISSING: u8 = 3;
/// A defect of the program or of its surroundings: every other error.
const DEFECT: u8 = 1;

/// Exit status of an error: that of the first cause in its chain that has one, else a defect's.
#[must_use]
pub fn exit_status(error: &anyhow::Error) -> u8 {
    error
        .chain()
        .find_map(|cause| {
            // An error of the standard output holds its failure.
            let held = || cause.downcast_ref::<io::Error>()?.get_ref()?.downcast_ref::<Failure>();
            let failure = cause.downcast_ref::<Failure>().or_else(held).map(of_failure);
            let emulator = cause.downcast_ref::<EmulateError>().map(of_emulator);
            let input = cause.is::<TraceError>() || cause.is::<ConfigError>() || cause.is::<ScenarioError>();
            failure.or(emulator).or(input.then_some(BAD_INPUT))
        })
        .unwrap_or(DEFECT)
}

const fn of_failure(failure: &Failure) -> u8 {
    match failure {
        Failure::Missing(_) | Failure::Port { .. } | Failure::Key { .. } => MISSING,
        Failure::Config(_) | Failure::BadInput(_) | Failure::Unread { .. } | Failure::Output { .. } => BAD_INPUT,
    }
}

const fn of_emulator(error: &EmulateError) -> u8 {
    match error {
        EmulateError::Missing(_) => MISSING,
        EmulateError::Config(_) => BAD_INPUT,
        _ => DEFECT,
    }
}

#[cfg(test)]
mod tests {
    use anyhow::Context;
    use meerkat_mwd::Config;

    use super::*;
    use crate::target::missing::Missing;

    #[test]
    fn the_status_is_found_under_added_context_and_anything_else_is_a_defect() {
        let missing = EmulateError::from(Missing { what: "no emulator".into(), command: "install it".into() });
        let wrapped = Err::<(), _>(missing).context("while emulating").map_err(|e| exit_status(&e));
        assert_eq!(wrapped, Err(3));
        let unusable = Config { sample_period_us: 0, ..Config::default() };
        assert_eq!(unusable.validate().map_err(|e| exit_status(&e.into())), Err(2));
        assert_eq!(exit_status(&anyhow::anyhow!("no variant")), 1);
    }
}
