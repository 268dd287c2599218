//! Emulated part that gives a frame in each sample period of a recording, whatever period its data sheet states.

use crate::sensors::{Burst, PartData, StartError, StartStep, blocking::Part};

/// A part that puts out a frame every `period_us`, whatever its data sheet says: with
/// [`Conversions::WithEverySample`](super::Conversions::WithEverySample) that is the period of the recording.
#[derive(Clone, Debug)]
pub struct AtPeriod<P> {
    /// The adapter.
    pub part: P,
    /// Time from frame to frame, microseconds.
    pub period_us: u32,
}

impl<const V: usize, P: Part<V>> Part<V> for AtPeriod<P> {
    type Error = P::Error;

    fn data(&self) -> PartData<V> {
        PartData { period_us: self.period_us, ..self.part.data() }
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<P::Error>> {
        self.part.start(step)
    }

    fn read(&mut self, burst: &mut Burst<V>) -> Result<(), P::Error> {
        self.part.read(burst)
    }

    fn is_configured(&mut self) -> Result<bool, P::Error> {
        self.part.is_configured()
    }
}
