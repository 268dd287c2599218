//! Frames from the FIFO of ST's inertial modules.

use super::{BusOperation, bisync};
use crate::sensors::{
    BURST_FRAMES, Burst,
    st_fifo::{StFifo, WORD},
};

/// Takes a burst of frames out of the FIFO of one of ST's inertial modules, which holds `level` words. The two
/// registers are the thermometer's first and the FIFO's tag.
#[bisync]
pub(super) async fn take_frames<B: BusOperation>(
    bus: &mut B,
    fifo: &mut StFifo,
    level: u16,
    [out_temp, fifo_tag]: [u8; 2],
    burst: &mut Burst<2>,
) -> Result<(), B::Error> {
    let mut words = [0; 2 * BURST_FRAMES * WORD];
    let taken = usize::from(level).min(2 * BURST_FRAMES);
    if let Some(words) = words.get_mut(..taken * WORD).filter(|words| !words.is_empty()) {
        if fifo.temperature_is_due() {
            let mut temperature = [0; 2];
            bus.read_from_register(out_temp, &mut temperature).await?;
            fifo.set_temperature(i16::from_le_bytes(temperature).into());
        }
        fifo.count_burst();
        // The address wraps from the last axis to the tag: one transaction, however many words.
        let read = bus.read_from_register(fifo_tag, words).await;
        read.inspect_err(|_| fifo.interrupted())?;
        fifo.take(words, level - taken as u16, burst);
    }
    Ok(())
}
