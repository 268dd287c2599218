//! What a user can do about an error, or after a result.

use meerkat_mwd::identification::{Decision, Refusal};

use crate::{
    flight::Flight,
    target::error::EmulateError,
    trace::{Fault, TraceError},
};

/// What can be done about an error, where something can that its message does not say.
#[must_use]
pub fn after_error(error: &anyhow::Error) -> Option<&'static str> {
    error.chain().find_map(|cause| {
        if let Some(trace) = cause.downcast_ref::<TraceError>() {
            return Some(after_trace_error(&trace.fault));
        }
        let emulator = cause.downcast_ref::<EmulateError>();
        let is_absent = matches!(emulator, Some(EmulateError::Missing(_) | EmulateError::Build(_)));
        is_absent.then_some("`cargo mwd replay` flies the same on this machine, without the emulator")
    })
}

const fn after_trace_error(fault: &Fault) -> &'static str {
    match fault {
        Fault::NotOpened(_) | Fault::NotRead(_) => {
            "check the path; host-tests/traces has recordings to try, and `cargo mwd simulate` makes one"
        }
        Fault::TruncatedGzip | Fault::DamagedGzip(_) => "copy the file anew from where it was recorded",
        Fault::NotWritten(_) => "check the folder, its permissions and the room on the disk",
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
        _ => "../verdicts",
    }
}

/// What to do after a flight whose report was, or was not, written.
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
