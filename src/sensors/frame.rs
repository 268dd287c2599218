/// Frames that one burst takes out of a part at most.
pub const BURST_FRAMES: usize = 8;

/// What a part's registers or FIFO held for one time: codes, in the part's own axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<const V: usize> {
    /// The code of each axis of each vector sensor; `None`: that sensor is not in this frame.
    pub codes: [Option<[i32; 3]>; V],
    /// The thermometer's code.
    pub temperature: Option<i32>,
}

impl<const V: usize> Default for Frame<V> {
    fn default() -> Self {
        Self { codes: [None; V], temperature: None }
    }
}

/// What one burst took out of a part.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Burst<const V: usize> {
    frames: heapless::Vec<Frame<V>, BURST_FRAMES>,
    /// Frames that are still in the part.
    pub left: u16,
    /// The FIFO has run over since the last burst: older frames are lost, and those in it are the newest.
    pub overrun: bool,
    /// What was taken out and cannot be believed: wrong tag, parity or checksum. Where it had its place among others, a frame without that
    /// sensor keeps the place, for times are counted by frames.
    pub corrupt: u16,
}

impl<const V: usize> Burst<V> {
    /// Appends the next newer frame; one that has no room counts as corrupt.
    pub fn push(&mut self, frame: Frame<V>) {
        if self.frames.push(frame).is_err() {
            self.corrupt = self.corrupt.saturating_add(1);
        }
    }

    /// The frames, oldest first.
    #[must_use]
    pub fn frames(&self) -> &[Frame<V>] {
        &self.frames
    }
}

/// What comes after a step of a part's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum StartStep {
    /// The next step, after so many microseconds.
    After(u32),
    /// Nothing: the part measures.
    Done,
}
