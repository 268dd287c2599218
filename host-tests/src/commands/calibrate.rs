//! `mwd calibrate`: accelerometer and magnetometer models from rests and turns, as a factory record with its
//! account.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{hold_out::hold_out, same_file::none_overwritten};
use crate::{
    calibrate::{calibrate, print_account, record, result},
    import::plausible::checked_raw,
    layout::Layout,
    report::html::{Sources, calibration::page, write_page},
};
use testbed::{console::told, failure::Failure, flight::configuration::of_file, trace::Trace};

/// Options of `calibrate`.
#[derive(Debug, Clone, Args)]
pub struct CalibrateArgs {
    /// Traces of one probe, .csv or .csv.gz
    #[arg(required = true, value_name = "TRACE")]
    pub traces: Vec<PathBuf>,
    /// Where to write the models, for --config
    #[arg(short, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Write the result as JSON
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures as HTML
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Configuration that overrides the traces' headers; its sensor models are the values to improve on
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Keep the last fraction F of each trace out of the fit and check the models there
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
}

/// Calibrates, prints the account and writes the files asked for.
///
/// # Errors
/// Bad input or usage; see [`crate::commands::exit_status::exit_status`].
pub fn run(args: &CalibrateArgs) -> anyhow::Result<()> {
    check_outputs(args)?;
    let traces = args.traces.iter().map(|path| Trace::read(path)).collect::<Result<Vec<_>, _>>()?;
    for trace in &traces {
        checked_raw(trace, &of_file(trace, args.config.as_deref())?)?;
    }
    let calibration = calibrate(&traces, args.config.as_deref(), args.hold_out)?;
    print_account(&mut told(), Layout::of_told(), &calibration)?;
    if let Some(path) = &args.json {
        result::write(&calibration, path)?;
    }
    if let Some(path) = &args.html {
        let mut sources = Sources::program();
        for trace in &args.traces {
            sources = sources.file("recording", trace);
        }
        if let Some(fraction) = args.hold_out {
            sources = sources.known("held out", format!("the last {fraction} of each recording"));
        }
        if let Some(config) = &args.config {
            sources = sources.file("configuration's file", config);
        }
        for (trace, of) in traces.iter().zip(&args.traces) {
            let config = of_file(trace, args.config.as_deref())?;
            let text = toml::to_string_pretty(&config).unwrap_or_default();
            sources = sources.configuration(&format!("The configuration of {}", of.display()), &text);
        }
        write_page(path, &page(&calibration, &sources))?;
    }
    if let Some(path) = &args.output {
        record::write(&calibration, path)?;
    }
    let next = args.output.as_ref().map_or_else(
        || "-o calibration.toml saves what is calibrated".to_owned(),
        |path| format!("`cargo mwd replay TRACE --config {}` flies with it", path.display()),
    );
    writeln!(told(), "\nNext: {next}; guide/src/calibration.md says how to move for a good one.")?;
    Ok(())
}

/// Refuses to overwrite an input, and to write two results to one file.
fn check_outputs(args: &CalibrateArgs) -> Result<(), Failure> {
    let outputs: Vec<&Path> = [&args.output, &args.json, &args.html].into_iter().flatten().map(AsRef::as_ref).collect();
    let inputs: Vec<&Path> = args.traces.iter().chain(&args.config).map(AsRef::as_ref).collect();
    none_overwritten(&outputs, &inputs)
}
