//! Source of the samples: register models of the sensors, played the recording, and the adapters on them; or the
//! recording itself.

use super::{
    fault::Fault,
    instruction_counter::{InstructionCounter, Tally, ticks},
    trace_reader::TraceReader,
};
use crate::console::{
    Word::{Number, Text},
    print,
};
use core::mem::MaybeUninit;
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, ModelledParts, Recording, RecordingPlayer, WireMeter},
};

/// Depth of the FIFO that is modelled: the same as on the host.
const WORDS: usize = 16;

/// Memory of the models that stand for the hardware.
pub type Parts = MaybeUninit<ModelledParts<WORDS>>;
/// Memory of the adapters on the models.
pub type Player = MaybeUninit<RecordingPlayer<'static, WORDS>>;

pub struct Sensors {
    played: Option<(&'static ModelledParts<WORDS>, &'static mut RecordingPlayer<'static, WORDS>)>,
    settled: bool,
    tally: Tally,
}

impl Sensors {
    /// Without a `Recording` the samples are handed over as they are.
    #[inline(never)]
    pub fn new(recording: Option<Recording>, parts: &'static mut Parts, player: &'static mut Player) -> Self {
        let played = recording.map(|recording| {
            let parts = &*parts.write(ModelledParts::new(Conversions::WithEverySample));
            (parts, player.write(RecordingPlayer::new(parts, recording)))
        });
        Self { played, settled: false, tally: Tally::default() }
    }

    /// The next sample; `None`: the trace is over.
    pub fn next(&mut self, trace: &mut TraceReader, counter: &InstructionCounter) -> Result<Option<Sample>, Fault> {
        let truth = trace.next::<Sample>()?;
        let (Some(truth), Some((parts, player))) = (&truth, &mut self.played) else { return Ok(truth) };
        if !self.settled {
            self.settled = true;
            player.settle(truth);
            // The ticks of a flight are counted from here on.
            parts.meter.set(Some(WireMeter { count: ticks, spent: 0 }));
        }
        player.pass_to(truth);
        let (sample, ticks) = counter.measure(|| service(player));
        self.tally.add(ticks);
        Ok(Some(sample))
    }

    /// Prints the instructions and losses of the sampling; the host reads the line.
    pub fn print(&self, counter: &InstructionCounter) {
        let Some((parts, player)) = &self.played else { return };
        let cost = counter.cost(&self.tally);
        let wires = counter.instructions(parts.meter.get().map_or(0, |meter| meter.spent));
        let counts = player.counts();
        print(&[
            Text("sampling truths "),
            Number(cost.calls),
            Text(" instructions "),
            Number(cost.instructions),
            Text(" most "),
            Number(cost.instructions_max),
            Text(" wires "),
            Number(wires),
            Text(" samples "),
            Number(counts.samples.into()),
            Text(" lost "),
            Number(counts.lost.into()),
            Text(" stamp_error_us "),
            Number(counts.stamp_error_us),
        ]);
    }
}

/// A function of its own, so that what is measured is the call.
#[inline(never)]
fn service(player: &mut RecordingPlayer<'static, WORDS>) -> Sample {
    player.service()
}
