//! Every kind of fault of a sensor and its wire, at every transaction of two seconds; and the load of the
//! wire without a fault.

use crate::bus_faults::{
    Bus, Motion, Outcome, RUN_US, Run,
    kinds::{KINDS, Part},
    run as run_once, sweep,
};
use meerkat_mwd::{
    emulation::{ism330dhcx, rm3100},
    sensors::BURST_FRAMES,
};
use testbed::study::{Cell, Effort, Table};

/// Stride over transactions in a quick run.
const QUICK_STRIDE: usize = 17;
const PARTS: [(Part, [&str; 2]); 2] =
    [(Part::Ism330dhcx, ["ISM330DHCX, SPI", "ISM330DHCX, I2C"]), (Part::Rm3100, ["RM3100, SPI", "RM3100, I2C"])];

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let stride = if effort == Effort::Full { 1 } else { QUICK_STRIDE };
    let motion = Motion::new(RUN_US, 1);
    let clean = [Bus::Spi, Bus::I2c].map(|bus| run_once(&motion, bus, None));
    let mut outcomes: Vec<(&str, &str, Outcome)> = Vec::new();
    for (part, names) in PARTS {
        for (clean, name) in clean.iter().zip(names) {
            outcomes.extend(KINDS.iter().map(|kind| (name, kind.name, sweep(&motion, clean, part, kind, stride))));
        }
    }
    let [on_spi, _] = &clean;
    Ok(vec![faults(&outcomes, stride), payloads(&outcomes), traffic(on_spi)])
}

fn milliseconds(us: u64) -> Cell {
    Cell::number(us as f64 * 1e-3, 0)
}

fn count(number: usize) -> Cell {
    Cell::number(number as f64, 0)
}

fn faults(outcomes: &[(&str, &str, Outcome)], stride: usize) -> Table {
    let every = if stride == 1 { "every transaction".to_owned() } else { format!("every {stride}th transaction") };
    let mut table = Table::new(
        format!("One fault in two seconds of 208 Hz, at {every}: longest times, ms"),
        &[
            "part",
            "fault",
            "runs",
            "of these without any effect",
            "detected after",
            "all good after its end",
            "not recovered",
            "runs with wrong samples unflagged",
            "most of them, and by how many times the noise",
        ],
    );
    for (part, kind, outcome) in outcomes {
        let wrong = match outcome.wrong_samples {
            0 => Cell::from("0"),
            samples => format!("{samples}, {:.1}", outcome.wrong_noises).into(),
        };
        table.row([
            (*part).into(),
            (*kind).into(),
            count(outcome.runs),
            count(outcome.without_effect),
            milliseconds(outcome.detection_us),
            milliseconds(outcome.recovery_us),
            count(outcome.not_recovered),
            count(outcome.wrong_runs),
            wrong,
        ]);
    }
    table
}

fn payloads(outcomes: &[(&str, &str, Outcome)]) -> Table {
    let mut table = Table::new(
        "Payloads spoilt on the wire by less than the innovation limit: no part here has a checksum over them",
        &["part", "fault", "runs", "one reading spoilt and believed", "largest error of attitude from it, deg"],
    );
    for (part, kind, outcome) in outcomes.iter().filter(|(_, _, outcome)| outcome.spoilt_payloads > 0) {
        table.row([
            (*part).into(),
            (*kind).into(),
            count(outcome.runs),
            count(outcome.spoilt_payloads),
            Cell::number(outcome.attitude_deg, 3),
        ]);
    }
    table
}

/// Nominal time of a sample at 200 Hz, microseconds.
const SAMPLE_US: f64 = 5_000.0;

fn traffic(clean: &Run) -> Table {
    let mut table = Table::new(
        format!("The wires without a fault, watermark of one frame (a burst takes up to {BURST_FRAMES}), a sample"),
        &["part", "SPI clock, MHz", "transactions", "bytes", "time on the wire, us", "of 5 ms, %"],
    );
    let samples = clean.samples.len() as f64;
    let clocks = [ism330dhcx::SPI_CLOCK_HZ, rm3100::SPI_CLOCK_HZ];
    let mut total_us = 0.0;
    for (((_, [name, _]), clock), (transactions, bytes)) in
        PARTS.iter().zip(clocks).zip(clean.transactions.iter().zip(clean.bytes))
    {
        let us = bytes as f64 * 8e6 / f64::from(clock) / samples;
        total_us += us;
        table.row([
            (*name).into(),
            Cell::number(f64::from(clock) * 1e-6, 0),
            Cell::number(f64::from(*transactions) / samples, 2),
            Cell::number(bytes as f64 / samples, 1),
            Cell::number(us, 1),
            Cell::percent(us / SAMPLE_US, 2),
        ]);
    }
    let blank = || Cell::from("");
    table.row([
        "both".into(),
        blank(),
        blank(),
        blank(),
        Cell::number(total_us, 1),
        Cell::percent(total_us / SAMPLE_US, 2),
    ]);
    table
}
