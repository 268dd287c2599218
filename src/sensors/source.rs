//! Sources: interfaces that give the readings of a part in bursts.

use heapless::VecView;

use super::bisync;
use crate::sensors::{
    Condition, Counters, InertialData, InertialReading, MagneticData, MagneticReading, ReadError, Trigger,
};

/// Source of a gyro and an accelerometer, read in bursts.
#[bisync]
#[allow(async_fn_in_trait)] // As in embedded-hal-async: the bus decides if a future is `Send`.
pub trait InertialSource {
    /// Error of the bus.
    type Error;

    /// Range, rate, latency, noise and FIFO of the part, at its settings in use.
    fn data(&self) -> InertialData;

    /// Counters of the faults so far.
    fn counters(&self) -> &Counters;

    /// Takes the part's measurements that were not handed out yet, oldest first, times strictly increasing,
    /// and appends them to `out` while it has room for [`BURST_FRAMES`](crate::sensors::BURST_FRAMES) more; the rest
    /// stays in the part. Also starts the part, and restarts it when it fails: that takes several calls, none of which
    /// waits.
    ///
    /// `now_us` is the time of the watermark or data-ready interrupt, microseconds, or without one that of the call;
    /// `trigger` tells which. It must never be less than in the call before.
    ///
    /// # Errors
    /// The bus failed or the part misbehaved; the readings appended before that are good. Call again at the
    /// usual time.
    async fn read(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<InertialReading>,
    ) -> Result<Condition, ReadError<Self::Error>>;
}

/// Source of a magnetometer, read in bursts, or one reading at a time without a FIFO.
#[bisync]
#[allow(async_fn_in_trait)]
pub trait MagneticSource {
    /// Error of the bus.
    type Error;

    /// Range, rate, latency, noise and FIFO of the part, at its settings in use.
    fn data(&self) -> MagneticData;

    /// Counters of the faults so far.
    fn counters(&self) -> &Counters;

    /// Takes measurements as [`InertialSource::read`] does.
    ///
    /// # Errors
    /// Fails as [`InertialSource::read`] does.
    async fn read(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<MagneticReading>,
    ) -> Result<Condition, ReadError<Self::Error>>;
}
