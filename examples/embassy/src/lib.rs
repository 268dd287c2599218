//! The two tasks of a probe under an executor: one reads the sensors, the other flies what they read.

#![cfg_attr(target_os = "none", no_std)]

mod modelled;

pub use modelled::{Parts, Played};

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, channel::Channel};
use meerkat_mwd::{
    Sample,
    attitude::Attitude,
    heapless::Vec,
    probe::AttitudeProbe,
    sensors::{
        BURST_FRAMES, Combiner, InertialReading, MagneticReading, Trigger,
        asynchronous::{InertialSource, MagneticSource},
    },
};

/// Samples that wait to be flown.
pub type Samples = Channel<CriticalSectionRawMutex, Sample, 16>;

/// The clock at whose ticks the sensors are read.
#[allow(async_fn_in_trait)] // One executor runs it.
pub trait Clock {
    /// Waits for the next tick. Returns its time, microseconds.
    async fn tick(&mut self) -> u64;
}

/// Reads the sensors at every tick. While a bus is busy other tasks run.
///
/// # Errors
/// A sample finds the queue full: who flies is too slow.
pub async fn acquire(
    clock: &mut impl Clock,
    inertial: &mut impl InertialSource,
    magnetic: &mut impl MagneticSource,
    samples: &Samples,
) -> Result<(), Sample> {
    let mut combiner = Combiner::new(inertial.data().period_us);
    loop {
        let now_us = clock.tick().await;
        // An error is counted by the source, which starts its part anew.
        let mut fields = Vec::<MagneticReading, BURST_FRAMES>::new();
        let _ = magnetic.read(now_us, Trigger::Polled, &mut fields).await;
        fields.into_iter().for_each(|reading| combiner.magnetic(reading));
        let mut rates = Vec::<InertialReading, BURST_FRAMES>::new();
        let _ = inertial.read(now_us, Trigger::Polled, &mut rates).await;
        for sample in rates.iter().filter_map(|reading| combiner.inertial(reading)) {
            samples.try_send(sample).map_err(|_| sample)?;
        }
    }
}

/// Flies samples, and returns the attitude after so many of them.
pub async fn fly(probe: &mut AttitudeProbe, samples: &Samples, most: u32) -> Option<Attitude> {
    let mut attitude = None;
    for _ in 0..most {
        attitude = probe.push(&samples.receive().await).and_then(|output| output.attitude);
    }
    attitude
}
