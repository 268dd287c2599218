//! Stages of the application, and which of them have come to their end since the watchdog was fed.

/// Stage that has to go on for the probe to be alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The interrupt that reads the sensors.
    Acquisition,
    /// Samples to attitudes.
    Samples,
    /// Identification and diagnosis.
    Work,
    /// Frames out, commands in.
    Telemetry,
}

impl Stage {
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

const ALL: u8 = Stage::Acquisition.bit() | Stage::Samples.bit() | Stage::Work.bit() | Stage::Telemetry.bit();

/// Stages that have made progress.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress(u8);

impl Progress {
    pub const fn made(&mut self, stage: Stage) {
        self.0 |= stage.bit();
    }

    /// Returns true if every stage has made progress since the last call that returned true.
    pub const fn take_if_whole(&mut self) -> bool {
        let whole = self.0 == ALL;
        if whole {
            self.0 = 0;
        }
        whole
    }
}
