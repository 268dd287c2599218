//! Steps that a user can take about an error, or after a result.

use meerkat_mwd::{
    config::ConfigError,
    identification::{Decision, Refusal},
};

use crate::target::error::EmulateError;
use testbed::{
    failure::{Failure, NOT_UTF8},
    flight::Flight,
    simulate::ScenarioError,
    trace::{Fault, TraceError},
};

/// Step that can be taken about an error of a command; at least where its options are explained.
#[must_use]
pub fn after_error(error: &anyhow::Error, command: Option<&str>) -> String {
    let known = error.chain().find_map(|cause| {
        if let Some(trace) = cause.downcast_ref::<TraceError>() {
            return Some(after_trace_error(&trace.fault));
        }
        if let Some(failure) = cause.downcast_ref::<Failure>() {
            return after_failure(failure, command);
        }
        if cause.is::<ScenarioError>() {
            return Some("host-tests/scenarios has scenarios to begin with, with every field explained");
        }
        if cause.is::<ConfigError>() {
            return Some(OF_CONFIG);
        }
        let emulator = cause.downcast_ref::<EmulateError>();
        let is_absent = matches!(emulator, Some(EmulateError::Missing(_) | EmulateError::Build(_)));
        is_absent.then_some("`cargo mwd replay` flies the same on this machine, without the emulator")
    });
    known.map_or_else(
        || match command {
            Some(command) => format!("`cargo mwd {command} --help` explains its options, with an example"),
            None => "`cargo mwd --help` lists the commands, with examples".to_owned(),
        },
        str::to_owned,
    )
}

const OF_CONFIG: &str = "leave that field out, or see `Config` in the library's documentation (`cargo doc --no-deps -p meerkat-mwd --open`)";

fn after_failure(failure: &Failure, command: Option<&str>) -> Option<&'static str> {
    match (failure, command) {
        (Failure::Unread { .. }, Some("fleet")) => Some(
            "check the path; `cargo mwd batch RECORDINGS -o RESULTS.parquet` writes such a table, and two beside it",
        ),
        (Failure::Unread { why, .. }, _) if why == NOT_UTF8 => Some("save it as plain text (CSV, TOML) in UTF-8"),
        (Failure::Unread { .. }, _) => Some("check the path, and that the file may be read"),
        (Failure::Port { .. }, _) => Some(
            "check the cable, the name (`ls /dev/tty*`) and that you may use it; without a probe, a captured file does in its place",
        ),
        (Failure::Key { .. }, _) => Some(
            "draw one by `openssl rand -hex 32 > probe.key`, and write it into the probe by `cargo mwd provision PORT --key probe.key`",
        ),
        (Failure::Missing(_), Some("survey")) => {
            Some("see that something listens there, and that its port is the one named")
        }
        (Failure::Missing(_), _) => Some(
            "see that the probe has power and that the baud rate is its own: `cargo mwd monitor PORT --once` counts frames",
        ),
        (Failure::Output { .. }, _) => Some(OF_FOLDER),
        (Failure::Config(_), _) => Some(OF_CONFIG),
        (Failure::BadInput(_), _) => None,
    }
}

const OF_FOLDER: &str = "check the folder, its permissions and the room on the disk";

const fn after_trace_error(fault: &Fault) -> &'static str {
    match fault {
        Fault::NotOpened(_) | Fault::NotRead(_) => {
            "check the path; host-tests/traces has recordings to try, and `cargo mwd simulate` makes one"
        }
        Fault::TruncatedGzip | Fault::DamagedGzip(_) => "copy the file anew from where it was recorded",
        Fault::NotWritten(_) => OF_FOLDER,
        Fault::BadKey { .. } => "correct that line; docs/commands.md has a trace's keys and their units",
        _ => {
            "`cargo mwd import FILE -o TRACE.csv.gz` makes a trace of a foreign file; docs/commands.md has a trace's columns and keys"
        }
    }
}

/// Page of the guide about a refusal.
#[must_use]
pub const fn page_of(refusal: &Refusal) -> &'static str {
    match refusal {
        Refusal::NotEnoughMotion { .. } => "not_enough_motion",
        Refusal::Overrun => "overrun",
        Refusal::NoAccelerometer => "no_accelerometer",
        Refusal::GyroUnusable { .. } => "gyro_unusable",
        Refusal::Diverged { .. } => "diverged",
        Refusal::NoMagnetometer { .. } => "no_magnetometer",
        Refusal::Implausible { .. } => "implausible",
        Refusal::MagnetometerUncalibrated { .. } => "magnetometer_uncalibrated",
        Refusal::WrongMounting { .. } => "wrong_mounting",
        _ => "../verdicts",
    }
}

/// Step to take after a flight whose report was, or was not, written.
#[must_use]
pub fn after_flight(flight: &Flight, report: Option<&std::path::Path>) -> String {
    let see = report.map_or_else(
        || "--html report.html draws it".to_owned(),
        |path| format!("open {} in a browser", path.display()),
    );
    match flight.reports.last().map(|report| report.decision) {
        Some(Decision::Refused(refusal)) => {
            format!("{see}; guide/src/refusals/{}.md says what to do about the refusal", page_of(&refusal))
        }
        _ => format!("{see}; guide/src/verdicts.md says how to read it"),
    }
}
