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

/// What a burst said beside its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct BurstStatus {
    /// Frames that are still in the part.
    pub left: u16,
    /// The FIFO has run over since the last burst.
    pub overrun: bool,
    /// Frames that were taken out and are no frames: wrong tag, parity or checksum.
    pub corrupt: u16,
}

/// What comes after a step of a part's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartStep {
    /// The next step, after so many microseconds.
    After(u32),
    /// Nothing: the part measures.
    Done,
}
