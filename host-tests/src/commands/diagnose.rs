//! `mwd diagnose`: which effect a trace's residual shows, as an account: residual, candidates, what was taken
//! out and why, what was refused and why, error before and after, what remains.

use std::path::PathBuf;

use clap::Args;

use super::{
    hold_out::hold_out,
    next_step::after_flight,
    replay::{HEAD, ReplayArgs, fly_with_bar, prepare},
};
use crate::{
    diagnosis::{against_reference, diagnosed},
    report::{
        account::print_account,
        attitude_at_end,
        flight_notes::add_flight_notes,
        hidden_in_p_b::hidden_text,
        html::{Told, diagnosis::page, write_page},
        json::result_json,
        plain_words,
        window_note::missing,
    },
};
use testbed::{
    console::told,
    flight::{configuration::frozen_from_us, started, surveys, watched},
    score::{self, AttitudeRms},
    trace::Trace,
};

/// Options of `diagnose`.
#[derive(Debug, Clone, Args)]
pub struct DiagnoseArgs {
    /// The trace, .csv or .csv.gz; - reads the standard input
    pub trace: PathBuf,
    /// Test gyro and vectors each against the reference columns, as on a bench with an external truth
    #[arg(long)]
    pub against_reference: bool,
    /// Score the last fraction F of the trace
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
    /// Configuration that overrides the trace's header
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Write the result as JSON
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures as HTML
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Fly a trace whose units, signs or axes cannot be; nothing is identified from it
    #[arg(long)]
    pub force: bool,
}

impl DiagnoseArgs {
    /// Options of the replay that is diagnosed: those that both commands have.
    fn as_replay(&self) -> ReplayArgs {
        ReplayArgs {
            trace: self.trace.clone(),
            attitude: None,
            rates: None,
            surveys: None,
            dynamics: None,
            burst: None,
            json: self.json.clone(),
            html: self.html.clone(),
            hold_out: self.hold_out,
            config: self.config.clone(),
            model: None,
            optimizer: None,
            seed: None,
            no_effects: false,
            explain: false,
            through_sensors: false,
            strict: false,
            force: self.force,
        }
    }
}

/// Diagnoses a trace and prints the account.
///
/// # Errors
/// Bad input or usage; see [`crate::commands::exit_status::exit_status`].
pub fn run(args: &DiagnoseArgs) -> anyhow::Result<()> {
    let (mut trace, config) = prepare(&args.as_replay(), Trace::read)?;
    let freeze_at_us = frozen_from_us(&trace, args.hold_out, args.config.as_deref())?;
    let (flight, diagnosed, flown_with) = if args.against_reference {
        against_reference(&trace, &config, freeze_at_us)?
    } else {
        let flight = fly_with_bar(started(&config, freeze_at_us, None)?, &trace);
        let diagnosed = diagnosed(&trace, &config, &flight);
        (flight, diagnosed, config)
    };
    add_flight_notes(&mut trace, &flown_with, &flight);
    let mut reference = score::score(&trace, &flight, &score::Settings::of(&trace, &config, &flight));
    if let Some(reference) = reference.as_mut().filter(|_| args.against_reference) {
        // The attitude came from the reference's own vertical and north.
        reference.attitude_rms_deg = AttitudeRms::default();
    }
    if let Some(path) = &args.json {
        let mut taken = surveys(started(&config, freeze_at_us, None)?, &trace)?;
        taken.iter_mut().for_each(|report| trace.grade(report));
        result_json(&trace, &flown_with, &flight, &diagnosed, reference).with_surveys(&taken).write(path)?;
    }
    if let Some(path) = &args.html {
        // On the bench the vectors are the reference's: those of the recording did not fly.
        let place = if args.against_reference { "against the reference" } else { "on this machine" };
        let seen = watched(started(&config, freeze_at_us, None)?, &trace)?;
        write_page(
            path,
            &page(&Told {
                trace: &trace,
                config: &flown_with,
                flight: &flight,
                diagnosed: &diagnosed,
                reference: reference.as_ref(),
                watched: Some(&seen).filter(|_| !args.against_reference),
                place,
            }),
        )?;
    }
    let mut out = told();
    writeln!(out, "{HEAD}{}{HEAD:#}", plain_words::diagnosis(&diagnosed).sentence)?;
    let [angles, totals] = attitude_at_end::lines(&config, &flight, &diagnosed.totals);
    writeln!(out, "attitude  {angles}\n          {totals}")?;
    if let Some(missing) = missing(&trace, &config, &flight, &diagnosed) {
        writeln!(out, "missing   {missing}")?;
    }
    if let Some(hidden) = hidden_text(&trace, &flight, &diagnosed) {
        writeln!(out, "hidden    {hidden}")?;
    }
    print_account(&mut out, &trace, &flight, &diagnosed, reference.as_ref())?;
    writeln!(out, "next      {}", after_flight(&flight, args.html.as_deref()))?;
    Ok(())
}
