//! Reports of the probe about itself.

use super::{Board, Delays, Statics, log::info};
use crate::telemetry::{Boot, Health};

/// Sends the boot, at a start and for a recording. `first_sample`: number of the first one since the start.
#[inline(never)]
pub(super) fn boot<B: Board>(board: &B, statics: &mut Statics<'_, B::Flash>, first_sample: u32, now_us: u64) {
    let config = statics.config();
    let Statics { probe, line, memory, .. } = statics;
    let boot = Boot {
        probe: board.identity(),
        reset: board.reset_reason(),
        watchdog_resets: board.watchdog_resets(),
        restored_model: memory.as_ref().and_then(|memory| memory.restored()),
        goes_on_after_s: memory.as_ref().and_then(|memory| memory.goes_on_after_s()),
        first_sample,
        flies: memory.as_ref().and_then(|memory| memory.flies(probe)),
        ..Boot::new(config)
    };
    info!("{} from sample {=u32}, stored model {}", boot.reset, boot.first_sample, boot.restored_model);
    line.boot(now_us, &boot);
}

/// Sends the health, every few seconds and with the answer to a self-test.
#[inline(never)]
pub(super) fn health<B: Board>(board: &B, statics: &mut Statics<'_, B::Flash>, delays: &Delays, now_us: u64) {
    let Statics { probe, line, commands, memory, .. } = statics;
    let [stack_used_bytes, stack_size_bytes] = board.stack_bytes();
    let acquisition = board.acquisition();
    let [models_stored, storage_failures] = memory.as_ref().map_or([0; 2], |memory| memory.stored_and_failed());
    let health = Health {
        probe: board.identity(),
        t_us: now_us,
        counters: probe.counters(),
        samples_acquired: acquisition.acquired(),
        sample_overruns: acquisition.queue_full(),
        missed_ticks: acquisition.missed_ticks(),
        sensor_faults: acquisition.faults(),
        worst_delay_us: delays.worst_us,
        late_attitudes: delays.late,
        stack_used_bytes,
        stack_size_bytes,
        watchdog_resets: board.watchdog_resets(),
        model_since_us: probe.model_since_us(),
        results_lost: line.results_lost(),
        sent: line.counters(),
        received: commands.link(),
        commands_accepted: commands.counters().accepted,
        commands_refused: commands.counters().refused,
        models_stored,
        storage_failures,
        self_test: commands.self_test.pop(),
    };
    line.health(now_us, &health);
}

/// Sends which program runs, where another one can be received.
#[inline(never)]
pub(super) fn program<B: Board>(board: &mut B, statics: &mut Statics<'_, B::Flash>, now_us: u64) {
    if let Some(report) = board.program_update().map(|update| update.report()) {
        statics.line.program(now_us, &report);
    }
}
