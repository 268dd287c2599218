//! Part, a sensor chip: the interface that its driver or adapter implements (docs/sensors.md).

use super::bisync;
use crate::sensors::{Burst, PartData, StartError, StartStep};

/// Adapter of a part with `V` vector sensors (2: gyro and accelerometer; 1: magnetometer): its start, and the reading
/// of its registers. [`Supervised`](super::Supervised) adds times, units, mounting, clipping, faults and recovery.
#[bisync]
#[allow(async_fn_in_trait)] // As in embedded-hal-async: the bus decides if a future is `Send`.
pub trait Part<const V: usize> {
    /// Error of the bus.
    type Error;

    /// Range, rate, latency, noise and FIFO, at the settings that [`start`](Self::start) makes.
    fn data(&self) -> PartData<V>;

    /// Does step `step` (0, 1, 2 ...) of the start, from any state of the part. Returns how long to wait
    /// before the next step, or that this was the last. Never waits itself.
    ///
    /// # Errors
    /// The start failed: it begins again with step 0, after a pause.
    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<Self::Error>>;

    /// Takes at most [`BURST_FRAMES`](crate::sensors::BURST_FRAMES) frames out of the part, oldest first, in
    /// one burst: it does not wait for more.
    ///
    /// # Errors
    /// The bus failed; the burst is then dropped.
    async fn read(&mut self, burst: &mut Burst<V>) -> Result<(), Self::Error>;

    /// Returns true if the registers still hold what [`start`](Self::start) wrote. Called after each burst,
    /// before its frames are believed: a part that was reset in between returns false.
    ///
    /// # Errors
    /// The bus failed.
    async fn is_configured(&mut self) -> Result<bool, Self::Error>;
}
