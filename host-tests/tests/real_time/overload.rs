//! More work than the chip has time for: what it cannot fly is lost and counted, and nothing is reset.

use super::{
    drilling::{LIMIT, PERIOD_US, drilling_at, everything},
    received::Received,
};
use crate::rig::emulator::toolchain;
use mwd::target::{
    image,
    real_time::{Landed, RealTime},
};

/// A load: samples a second, and the part of the chip's speed that is there for them.
#[derive(Clone, Copy, Debug)]
struct Load {
    rate_hz: u64,
    /// Speed is halved so often.
    halvings: u8,
    duration_s: f64,
}

impl Load {
    /// Flies, and checks what holds of every load. Prints a row of docs/firmware.md.
    fn fly(self) -> Option<Landed> {
        let toolchain = toolchain()?;
        let Self { rate_hz, halvings, duration_s } = self;
        let (config, samples) = drilling_at(1_000_000 / rate_hz, duration_s, 2);
        let full = RealTime { config, stream: everything(), ..RealTime::default() };
        let run = RealTime { instruction_time: full.instruction_time + halvings, ..full };
        let landed = run.run(&toolchain, &samples, LIMIT).unwrap();
        let count = |name| landed.count(name).unwrap();
        let (acquired, processed, lost) = (count("acquired"), count("processed"), count("queue_full"));
        println!(
            "| {rate_hz} Hz, 1/{} of the speed | {} | {acquired} | {processed} | {lost} | {:.2} ms | {} | {} |",
            1 << halvings,
            (rate_hz << halvings) as f64 * PERIOD_US as f64 * 1e-6,
            count("delay_worst_us") as f64 * 1e-3,
            count("windows"),
            count("watchdog_resets")
        );
        assert_eq!(count("watchdog_resets"), 0);
        assert_eq!(Received::of(&landed.serial).boots.len(), 1);
        assert_eq!((acquired, count("missed_ticks")), (samples.len() as u64, 0));
        // All that were not lost are flown, but for those that still waited at the end.
        let rest = acquired - processed - lost;
        assert!(rest < 32, "{processed} and {lost} of {acquired}");
        assert_eq!(lost > 0, count("sequence_breaks") > 0);
        Some(landed)
    }
}

#[test]
fn at_its_rate_nothing_is_lost_and_every_attitude_is_in_time() {
    let Some(landed) = (Load { rate_hz: 200, halvings: 0, duration_s: 120.0 }).fly() else { return };
    assert_eq!(landed.count("queue_full"), Some(0));
    assert!(landed.count("windows") > Some(0) && landed.count("delay_worst_us") <= Some(image::DELAY_LIMIT_US));
}

#[test]
fn four_times_the_load_is_counted_and_resets_nothing() {
    for load in
        [Load { rate_hz: 800, halvings: 0, duration_s: 120.0 }, Load { rate_hz: 200, halvings: 2, duration_s: 120.0 }]
    {
        if load.fly().is_none() {
            return;
        }
    }
}

#[test]
fn overload_loses_samples_and_counts_them() {
    let Some(landed) = (Load { rate_hz: 2_000, halvings: 2, duration_s: 6.0 }).fly() else { return };
    let [acquired, processed, lost] = ["acquired", "processed", "queue_full"].map(|name| landed.count(name).unwrap());
    assert!(lost > acquired / 10, "{lost} of {acquired}: this is no overload");
    assert!(processed > acquired / 10, "{processed} of {acquired}");
}
