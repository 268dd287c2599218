//! Frames of a part, and bursts of them.

/// Largest number of frames in one burst.
pub const BURST_FRAMES: usize = 8;

/// Codes that a part's registers or FIFO held for one time, in the part's own axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<const V: usize> {
    /// Code of each axis of each vector sensor; `None` if that sensor is not in this frame.
    pub codes: [Option<[i32; 3]>; V],
    /// Code of the thermometer.
    pub temperature: Option<i32>,
}

impl<const V: usize> Default for Frame<V> {
    fn default() -> Self {
        Self { codes: [None; V], temperature: None }
    }
}

/// Frames that one burst took out of a part.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Burst<const V: usize> {
    frames: heapless::Vec<Frame<V>, BURST_FRAMES>,
    /// Number of frames still in the part.
    pub left: u16,
    /// True if the FIFO has run over since the last burst: older frames are lost, and those in it are the
    /// newest.
    pub overrun: bool,
    /// Number of frames with a wrong tag, parity or checksum. A corrupt frame among others is still pushed, without
    /// the sensor's codes, because times are counted by frames.
    pub corrupt: u16,
}

impl<const V: usize> Burst<V> {
    /// Appends the next newer frame; one without room counts as corrupt.
    pub fn push(&mut self, frame: Frame<V>) {
        if self.frames.push(frame).is_err() {
            self.corrupt = self.corrupt.saturating_add(1);
        }
    }

    /// Frames, oldest first.
    #[must_use]
    pub fn frames(&self) -> &[Frame<V>] {
        &self.frames
    }
}

/// Next action after a step of a part's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum StartStep {
    /// Do the next step after this many microseconds.
    After(u32),
    /// Do nothing: the part measures.
    Done,
}
