//! Where the samples come from: register models of the sensors, played the recording, and the adapters on them; or the recording itself.

use super::{
    fault::Fault,
    instruction_counter::{InstructionCounter, Tally, ticks},
    trace_reader::TraceReader,
};
use core::mem::MaybeUninit;
use meerkat_mwd::{
    Sample,
    sensor_models::{Conversions, ModelledParts, Recording, RecordingPlayer, WireMeter},
};
use semihosting::println;

/// Depth of the FIFO that is modelled: the same as on the host.
const WORDS: usize = 16;

/// What stands for the hardware.
pub type Parts = MaybeUninit<ModelledParts<WORDS>>;
/// The adapters on it.
pub type Player = MaybeUninit<RecordingPlayer<'static, WORDS>>;

pub struct Sensors {
    played: Option<(&'static ModelledParts<WORDS>, &'static mut RecordingPlayer<'static, WORDS>)>,
    tally: Tally,
}

impl Sensors {
    /// Without a `Recording` the samples are handed over as they are.
    #[inline(never)]
    pub fn new(recording: Option<Recording>, parts: &'static mut Parts, player: &'static mut Player) -> Self {
        let played = recording.map(|recording| {
            let parts = &*parts.write(ModelledParts::new(Conversions::WithEverySample));
            parts.meter.set(Some(WireMeter { count: ticks, spent: 0 }));
            (parts, player.write(RecordingPlayer::new(parts, recording)))
        });
        Self { played, tally: Tally::default() }
    }

    /// The next sample; `None`: the trace is over.
    pub fn next(&mut self, trace: &mut TraceReader, counter: &InstructionCounter) -> Result<Option<Sample>, Fault> {
        while let Some(truth) = trace.next::<Sample>()? {
            let Some((_, player)) = &mut self.played else { return Ok(Some(truth)) };
            player.pass_to(&truth);
            let (sample, ticks) = counter.measure(|| service(player));
            self.tally.add(ticks);
            if sample.is_some() {
                return Ok(sample);
            }
        }
        Ok(self.played.as_mut().and_then(|(_, player)| player.finish()))
    }

    /// Prints what it took; the host reads it.
    pub fn print(&self, counter: &InstructionCounter) {
        let Some((parts, player)) = &self.played else { return };
        let cost = counter.cost(&self.tally);
        let wires = counter.instructions(parts.meter.get().map_or(0, |meter| meter.spent));
        let counts = player.counts();
        println!(
            "sampling truths {} instructions {} most {} wires {wires} samples {} lost {} stamp_error_us {}",
            cost.calls, cost.instructions, cost.instructions_max, counts.samples, counts.lost, counts.stamp_error_us
        );
    }
}

/// A function of its own, so that what is measured is the call.
#[inline(never)]
fn service(player: &mut RecordingPlayer<'static, WORDS>) -> Option<Sample> {
    player.service()
}
