//! Reports of the probe about itself.

use super::{Application, Board, Statics, log::info};
use crate::telemetry::{Boot, Health};

impl<B: Board> Application<'_, B> {
    /// Notes that the pipeline has started afresh: a boot is to be reported.
    pub(super) fn restarted(&mut self) {
        self.first_sequence = self.next_sequence;
        self.statics.line.want_boot();
    }

    /// Sends the boot, at a start and for a recording.
    #[inline(never)]
    pub(super) fn report_boot(&mut self, now_us: u64) {
        let Statics { probe, line, memory, .. } = &mut self.statics;
        let boot = Boot {
            probe: self.board.identity(),
            reset: self.board.reset_reason(),
            watchdog_resets: self.board.watchdog_resets(),
            restored_model: memory.as_ref().and_then(|memory| memory.restored()),
            goes_on_after_s: memory.as_ref().and_then(|memory| memory.goes_on_after_s()),
            first_sample: self.first_sequence,
            flies: memory.as_ref().and_then(|memory| memory.flies(probe)),
            ..Boot::new(*probe.config())
        };
        info!("{} from sample {=u32}, stored model {}", boot.reset, boot.first_sample, boot.restored_model);
        line.boot(now_us, &boot);
    }

    #[inline(never)]
    pub(super) fn report_health(&mut self, now_us: u64) {
        let [stack_used_bytes, stack_size_bytes] = self.board.stack_bytes();
        let acquisition = self.board.acquisition();
        let commands = self.statics.commands.counters();
        let [models_stored, storage_failures] =
            self.statics.memory.as_ref().map_or([0; 2], |memory| memory.stored_and_failed());
        let health = Health {
            probe: self.board.identity(),
            t_us: now_us,
            counters: self.statics.probe.counters(),
            samples_acquired: acquisition.acquired(),
            sample_overruns: acquisition.queue_full(),
            missed_ticks: acquisition.missed_ticks(),
            sensor_faults: acquisition.faults(),
            worst_delay_us: self.counts.delays.worst_us,
            late_attitudes: self.counts.delays.late,
            stack_used_bytes,
            stack_size_bytes,
            watchdog_resets: self.board.watchdog_resets(),
            results_lost: self.statics.line.results_lost(),
            sent: self.statics.line.counters(),
            received: self.statics.commands.link(),
            commands_accepted: commands.accepted,
            commands_refused: commands.refused,
            models_stored,
            storage_failures,
            self_test: self.statics.commands.self_test.pop(),
            ..Health::default()
        };
        self.statics.line.health(now_us, &health);
    }
}
