//! A stage that hangs is noticed; the probe restarts and reports it.

use super::{
    drilling::{LIMIT, PERIOD_US, drilling, everything},
    received::Received,
};
use crate::rig::emulator::toolchain;
use meerkat_mwd::telemetry::ResetReason;
use mwd::target::real_time::{RealTime, Stage};

#[test]
fn a_hang_in_any_stage_resets_and_the_probe_goes_on() {
    let Some(toolchain) = toolchain() else { return };
    let (config, samples) = drilling(10.0, 2);
    for stage in [Stage::Acquisition, Stage::Samples, Stage::Work, Stage::Telemetry] {
        let hang_at = 700;
        let run = RealTime { config, stream: everything(), hang: Some((stage, hang_at)), ..RealTime::default() };
        let landed = run.run(&toolchain, &samples, LIMIT).unwrap();
        let received = Received::of(&landed.serial);
        let resets: Vec<_> = received.boots.iter().map(|boot| (boot.reset, boot.watchdog_resets)).collect();
        assert_eq!(resets, [(ResetReason::PowerOn, 0), (ResetReason::Watchdog, 1)], "{stage:?}");
        assert!(received.boots.iter().all(|boot| boot.config == config), "{stage:?}");

        // A second without a sign of life while the sensors go on; then from the start again.
        let (before, after): (Vec<_>, Vec<_>) = {
            let restart = received.outputs.windows(2).position(|pair| pair[1].t_us < pair[0].t_us).unwrap() + 1;
            (received.outputs[..restart].to_vec(), received.outputs[restart..].to_vec())
        };
        assert!(before.len().abs_diff(hang_at as usize) < 10, "{stage:?}: {} before", before.len());
        assert_eq!(after[0].t_us, PERIOD_US, "{stage:?}");
        let silent = samples.len() - before.len() - after.len();
        assert!((190..220).contains(&silent), "{stage:?}: {silent} samples in the gap");
        println!("{stage:?}: {} before, {silent} samples without an attitude, {} after", before.len(), after.len());
    }
}
