//! `mwd diagnose`: the loop on one trace, told as an account: residual, candidates, what was added and why, what was refused and why,
//! error before and after, what remains.

mod account;
pub(crate) mod bench_mode;
mod html;
mod outcome;
mod remainder_text;
mod vector_residual;

use std::io;

pub use account::{print_account, sentences, verdict_name};
pub use html::page;
pub(crate) use html::{effect_estimates, effects, magnets, magnets_shaded_s, per_model, reference as reference_scores};
pub use outcome::{Diagnosed, Found, diagnosed};
pub use remainder_text::remainder_text;
pub use vector_residual::{BeforeAfter, ResidualOverTime, VectorResidual};

use meerkat_mwd::Config;

use crate::{
    cli::{DiagnoseArgs, ReplayArgs},
    flight::{Flight, started},
    page::write_page,
    replay::{fly_with_bar, prepare, settings},
    result_json::result_json,
    score,
    trace::Trace,
};

/// Flies the gyro of a trace against its reference attitude, and diagnoses all sensors.
///
/// # Errors
/// The trace has no reference, or the configuration cannot be used.
pub fn against_reference(trace: &Trace, config: &Config) -> anyhow::Result<(Flight, Diagnosed)> {
    bench_mode::diagnose(trace, config)
}

/// Diagnoses a trace and prints the account.
///
/// # Errors
/// Bad input or usage; see [`crate::failure::exit_status`].
pub fn run(args: &DiagnoseArgs) -> anyhow::Result<()> {
    let (trace, config) = prepare(&ReplayArgs::of_diagnose(args))?;
    let (flight, diagnosed) = if args.against_reference {
        against_reference(&trace, &config)?
    } else {
        let flight = fly_with_bar(started(&config, None)?, &trace);
        let diagnosed = diagnosed(&trace, &config, &flight);
        (flight, diagnosed)
    };
    let reference = score::score(&trace, &flight, &settings(&trace, &config));
    if let Some(path) = &args.json {
        result_json(&trace, &config, &flight, &diagnosed, reference).write(path)?;
    }
    if let Some(path) = &args.html {
        write_page(path, &page(&trace, &config, &diagnosed, reference.as_ref()))?;
    }
    print_account(&mut io::stdout().lock(), &trace, &config, &diagnosed, reference.as_ref())?;
    Ok(())
}
