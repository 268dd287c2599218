//! `mwd emulate`: flies a trace by the firmware on the emulated chip.

use std::io::Write;

use clap::Args;

use super::{
    next_step::after_flight,
    replay::{self, ReplayArgs},
};
use crate::{
    report::flight_notes::add_flight_notes,
    target::{
        emulate::{Feed, fly_emulated},
        error::EmulateError,
    },
};
use testbed::{
    console::told,
    failure::Failure,
    flight::{configuration::frozen_from_us, fly_on, started, through_sensors},
    trace::Trace,
};

/// Options of `emulate`.
#[derive(Debug, Clone, Args)]
pub struct EmulateArgs {
    /// Options that `replay` has too.
    #[command(flatten)]
    pub replay: ReplayArgs,
    /// Give the samples to the firmware as recorded, without the sensor models
    #[arg(long, conflicts_with = "through_sensors")]
    pub direct: bool,
}

/// Flies the trace on the emulated chip, delivers what `replay` delivers and prints what the flight cost.
///
/// # Errors
/// Bad input or usage, or whatever keeps the emulator from a whole flight.
pub fn run(EmulateArgs { replay: args, direct }: &EmulateArgs) -> anyhow::Result<()> {
    if args.model.is_some() {
        return Err(Failure::BadInput("--model: the emulated chip starts with the factory's model".to_owned()).into());
    }
    let (mut trace, config) = replay::prepare(args, Trace::read)?;
    let feed = if *direct { Feed::Direct } else { Feed::ThroughSensors };
    let recorded = if *direct { trace.samples.clone() } else { through_sensors::each_field_once(&trace.samples) };
    let freeze_at_us = frozen_from_us(&trace, args.hold_out, args.config.as_deref())?;
    let mut emulated = fly_emulated(&config, freeze_at_us, &recorded, feed)?;
    let played = (!direct).then(|| through_sensors::play(&recorded, config.sample_period_us));
    if let Some(played) = &played {
        let (there, here) = (emulated.sampling.map(|sampling| sampling.counts), played.counts);
        if there != Some(here) {
            return Err(EmulateError::Sensors { there, here }.into());
        }
        trace.samples.clone_from(&played.samples);
    }
    // The chip tells its windows only.
    emulated.flight.completed_by(fly_on(started(&config, freeze_at_us, None)?, &trace, |_| {}));
    add_flight_notes(&mut trace, &config, &emulated.flight);
    replay::deliver(args, &trace, &config, &emulated.flight, "by the firmware on the emulated Cortex-M4F")?;
    let mut out = told();
    for line in emulated.cost_lines() {
        writeln!(out, "{line}")?;
    }
    if let Some(played) = &played {
        through_sensors::report(&mut out, &config, &recorded, played)?;
    }
    writeln!(out, "next     {}", after_flight(&emulated.flight, args.html.as_deref()))?;
    Ok(())
}
