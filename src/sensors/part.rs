use super::bisync;
use crate::sensors::{Burst, PartData, StartError, StartStep};

/// What an adapter has to know of a part with `V` vector sensors (2: gyro and accelerometer; 1: magnetometer): how it is started,
/// and how its registers are read. Everything else (times, units, mounting, clipping, faults, recovery) is [`Supervised`](super::Supervised)'s.
#[bisync]
#[allow(async_fn_in_trait)] // As in embedded-hal-async: whether a future is `Send` is its bus's matter.
pub trait Part<const V: usize> {
    /// The bus's error.
    type Error;

    /// Range, rate, latency, noise and FIFO, at the settings that [`start`](Self::start) makes.
    fn data(&self) -> PartData<V>;

    /// Does step `step` (0, 1, 2 ...) of the start, from whatever state the part is in, and says how long to wait before the next, or that
    /// it was the last. It never waits itself.
    ///
    /// # Errors
    /// The start failed: it begins again with step 0, after a pause.
    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<Self::Error>>;

    /// Takes at most [`BURST_FRAMES`](crate::sensors::BURST_FRAMES) frames out of the part, oldest first. One burst: it does not wait for more.
    ///
    /// # Errors
    /// The bus failed; the burst is then dropped.
    async fn read(&mut self, burst: &mut Burst<V>) -> Result<(), Self::Error>;

    /// Whether the registers still hold what [`start`](Self::start) wrote. Asked after each burst and before its frames are believed: a part
    /// that was reset in between says no.
    ///
    /// # Errors
    /// The bus failed.
    async fn is_configured(&mut self) -> Result<bool, Self::Error>;
}
