/// What has gone wrong with a source since it was made. They stop at the largest number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counters {
    /// Readings handed out.
    pub readings: u32,
    /// Transactions that the bus failed.
    pub bus_errors: u32,
    /// Starts at which the part did not say who it is.
    pub wrong_identity: u32,
    /// Starts that failed otherwise.
    pub failed_starts: u32,
    /// Starts after the first.
    pub restarts: u32,
    /// The part had lost its settings.
    pub resets: u32,
    /// The part's FIFO had run over.
    pub overruns: u32,
    /// The part had put nothing out for long.
    pub silences: u32,
    /// A sensor, or an axis of one, had become frozen.
    pub frozen: u32,
    /// Readings of one sensor that jumped, repeated themselves or read zero as no motion makes them: flagged missing.
    pub implausible: u32,
    /// Frames that the part must have measured by its rate, and that never came. A lower bound for a part without a FIFO that is polled more slowly
    /// than it measures: there one in seven cannot be told from an irregular poll.
    pub lost_frames: u32,
    /// Frames, or sensors of a frame, with a wrong tag, parity or checksum: flagged missing, or dropped.
    pub corrupt_frames: u32,
    /// Frames that came sooner after the last than the part can measure, and were dropped.
    pub early_frames: u32,
    /// Times at which the settings read back wrong, and right when they were read again: the bus had flipped a bit.
    pub doubtful_settings: u32,
}

/// How a source is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Condition {
    /// The part is being started.
    #[default]
    Starting,
    /// It measures, and nothing is wrong.
    Running,
    /// It measures, but a sensor of it is frozen; the readings say which.
    Frozen,
    /// The part is left alone for a while before it is started again.
    Pausing,
}
