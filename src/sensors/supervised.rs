//! Supervised part: a source with times, units, flags and restarts.

use heapless::VecView;

use super::{InertialSource, MagneticSource, Part, bisync};
use crate::sensors::{
    BURST_FRAMES, Burst, Condition, Counters, InertialData, InertialReading, MagneticData, MagneticReading, Mounting,
    ReadError, Scaled, StartStep, Trigger,
    recovery::Next,
    supervision::{Supervision, add},
};

/// Supervised part, a source: frames get times, units, mounting and flags, and the part is restarted when it
/// fails.
///
/// | fault | what happens |
/// |---|---|
/// | the bus fails | the burst is dropped; after five in a row the part is left alone for 10 ms, then started anew |
/// | wrong identity, failed start | started anew after a pause that doubles from 10 ms to 5 s |
/// | the part was reset | settings are read back after each burst: burst dropped, part started anew at once |
/// | the FIFO ran over | what it holds is stamped from its newest frame back; what is lost is counted |
/// | no frame for ten periods | started anew after a pause |
/// | no codes of a sensor in 50 frames | the sensor is flagged missing; the part is started anew after a pause |
/// | an output that does not change | the sensor is flagged missing until it moves again; started anew after a pause |
/// | data-ready stuck | frames that come too soon after the last, and the same reading again, are dropped |
#[derive(Clone, Debug)]
#[bisync]
pub struct Supervised<P, const V: usize> {
    part: P,
    supervision: Supervision<V>,
}

#[bisync]
impl<P: Part<V>, const V: usize> Supervised<P, V> {
    /// Wraps a part; touches no bus. `mounting` turns the part's axes into the body's.
    pub fn new(part: P, mounting: Mounting) -> Self {
        let supervision = Supervision::new(part.data(), mounting);
        Self { part, supervision }
    }

    /// Returns the part, and with it the bus.
    pub fn release(self) -> P {
        self.part
    }

    async fn bursts<R: From<Scaled<V>>>(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<R>,
    ) -> Result<Condition, ReadError<P::Error>> {
        match self.supervision.recovery.next(now_us) {
            Next::Wait => Ok(Condition::Starting),
            Next::Pause => Ok(Condition::Pausing),
            Next::Step(step) => self.step(now_us, step).await,
            Next::Read => {
                let mut condition = Condition::Running;
                // At most as many bursts as the FIFO holds, whatever number of frames the part says is left.
                for _ in 0..=self.supervision.data.fifo_frames as usize / BURST_FRAMES {
                    if out.capacity() - out.len() < BURST_FRAMES {
                        break;
                    }
                    let left;
                    (condition, left) = self.burst(now_us, trigger, out).await?;
                    if left == 0 {
                        break;
                    }
                }
                Ok(condition)
            }
        }
    }

    async fn step(&mut self, now_us: u64, step: u8) -> Result<Condition, ReadError<P::Error>> {
        match self.part.start(step).await {
            Ok(StartStep::After(after_us)) => {
                self.supervision.recovery.stepped(now_us, step, after_us);
                Ok(Condition::Starting)
            }
            Ok(StartStep::Done) => {
                self.supervision.started(now_us);
                Ok(Condition::Starting)
            }
            Err(error) => {
                self.supervision.start_failed(now_us, &error);
                Err(ReadError::Start(error))
            }
        }
    }

    /// Reads one burst. Returns the source's condition, and how many frames are left in the part.
    async fn burst<R: From<Scaled<V>>>(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<R>,
    ) -> Result<(Condition, u16), ReadError<P::Error>> {
        let mut burst = Burst::default();
        if let Err(error) = self.part.read(&mut burst).await {
            self.supervision.bus_failed(now_us);
            return Err(ReadError::Bus(error));
        }
        if (!burst.frames().is_empty() || self.supervision.is_overdue(now_us)) && !self.is_configured(now_us).await? {
            self.supervision.was_reset();
            return Err(ReadError::Reset);
        }
        let condition = self.supervision.take(now_us, trigger, &burst, |scaled| {
            // The caller has checked that a burst has room.
            let _ = out.push(scaled.into());
        });
        if burst.frames().is_empty() && self.supervision.is_silent(now_us) {
            return Err(ReadError::Silent);
        }
        Ok((condition, burst.left))
    }

    /// Checks the part's settings, twice if necessary: a bit flipped on the bus shows a wrong setting in one reading
    /// only.
    async fn is_configured(&mut self, now_us: u64) -> Result<bool, ReadError<P::Error>> {
        match self.part.is_configured().await {
            Ok(true) => return Ok(true),
            Ok(false) => {}
            Err(_) => add(&mut self.supervision.counters.bus_errors, 1),
        }
        match self.part.is_configured().await {
            Ok(true) => {
                add(&mut self.supervision.counters.doubtful_settings, 1);
                Ok(true)
            }
            Ok(false) => Ok(false),
            Err(error) => {
                self.supervision.bus_failed(now_us);
                Err(ReadError::Bus(error))
            }
        }
    }
}

#[bisync]
impl<P: Part<2>> InertialSource for Supervised<P, 2> {
    type Error = P::Error;

    fn data(&self) -> InertialData {
        self.supervision.data
    }

    fn counters(&self) -> &Counters {
        &self.supervision.counters
    }

    async fn read(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<InertialReading>,
    ) -> Result<Condition, ReadError<P::Error>> {
        self.bursts(now_us, trigger, out).await
    }
}

#[bisync]
impl<P: Part<1>> MagneticSource for Supervised<P, 1> {
    type Error = P::Error;

    fn data(&self) -> MagneticData {
        self.supervision.data
    }

    fn counters(&self) -> &Counters {
        &self.supervision.counters
    }

    async fn read(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        out: &mut VecView<MagneticReading>,
    ) -> Result<Condition, ReadError<P::Error>> {
        self.bursts(now_us, trigger, out).await
    }
}
