use heapless::VecView;

use super::bisync;
use crate::sensors::{Condition, Counters, InertialData, InertialReading, MagneticData, MagneticReading, ReadError};

/// A gyro and an accelerometer that are read in bursts.
#[bisync]
#[allow(async_fn_in_trait)] // As in embedded-hal-async: whether a future is `Send` is its bus's matter.
pub trait InertialSource {
    /// The bus's error.
    type Error;

    /// Range, rate, latency, noise and FIFO of the part, at the settings that it is used with.
    fn data(&self) -> InertialData;

    /// What has gone wrong so far.
    fn counters(&self) -> &Counters;

    /// Takes what the part has measured and not yet handed out, oldest first, times strictly increasing, and appends it to `out` as far as there is room;
    /// the rest stays in the part. Also starts the part, and starts it anew when it fails: that takes several calls, none of which waits.
    ///
    /// `now_us`: when the watermark or data-ready interrupt came, microseconds, or the time of the call where there is no interrupt. Never
    /// less than in the call before.
    ///
    /// # Errors
    /// The bus failed or the part misbehaved; the readings appended before that are good. Call again at the usual time.
    async fn read(
        &mut self,
        now_us: u64,
        out: &mut VecView<InertialReading>,
    ) -> Result<Condition, ReadError<Self::Error>>;
}

/// A magnetometer that is read in bursts, or one reading at a time where it has no FIFO.
#[bisync]
#[allow(async_fn_in_trait)]
pub trait MagneticSource {
    /// The bus's error.
    type Error;

    /// Range, rate, latency, noise and FIFO of the part, at the settings that it is used with.
    fn data(&self) -> MagneticData;

    /// What has gone wrong so far.
    fn counters(&self) -> &Counters;

    /// As [`InertialSource::read`].
    ///
    /// # Errors
    /// As [`InertialSource::read`].
    async fn read(
        &mut self,
        now_us: u64,
        out: &mut VecView<MagneticReading>,
    ) -> Result<Condition, ReadError<Self::Error>>;
}
