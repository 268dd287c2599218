//! Counters of a source's faults.

/// Counters of a source's faults since it was made. They stop at their largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counters {
    /// Readings handed out.
    pub readings: u32,
    /// Transactions that failed on the bus.
    pub bus_errors: u32,
    /// Starts at which the identity read was not the part's.
    pub wrong_identity: u32,
    /// Starts that failed otherwise.
    pub failed_starts: u32,
    /// Starts after the first.
    pub restarts: u32,
    /// Losses of the part's settings.
    pub resets: u32,
    /// Overruns of the part's FIFO.
    pub overruns: u32,
    /// Long times without output from the part, or from one of its sensors.
    pub silences: u32,
    /// Sensors, or axes of one, that froze.
    pub frozen: u32,
    /// Readings of one sensor that jumped, repeated themselves or read zero as no motion does: flagged
    /// missing.
    pub implausible: u32,
    /// Frames that the part must have measured by its rate and that never came. A lower bound for a part
    /// without a FIFO that is polled more slowly than it measures: one in seven cannot be told from an
    /// irregular poll there.
    pub lost_frames: u32,
    /// Frames, or sensors of a frame, with a wrong tag, parity or checksum: flagged missing, or dropped.
    pub corrupt_frames: u32,
    /// Frames that came sooner after the last than the part can measure, and were dropped.
    pub early_frames: u32,
    /// Settings that read back wrong, and right when read again: the bus had flipped a bit.
    pub doubtful_settings: u32,
}

/// Condition of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Condition {
    /// The part is being started.
    #[default]
    Starting,
    /// The part measures, and nothing is wrong.
    Running,
    /// The part measures, but one of its sensors is frozen or silent; the readings say which.
    Frozen,
    /// The part pauses before its next start.
    Pausing,
}
