//! Order of rows in time: which row repeats, goes back, or was far ahead of the rows behind it.

/// Step of time after which a row is only believed when the next one is not before it, microseconds: as the probe does,
/// which refuses such a sample.
const FAR_AHEAD_US: i128 = 10_000_000;

/// Times of rows that have been kept, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowOrder {
    last_us: Option<i128>,
    /// Time of the row before the last, if the last is far ahead of it.
    before_us: Option<i128>,
}

/// Place of a row among those that have been kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowPlace {
    /// It is the next one.
    Next,
    /// It has the time of the row before.
    Repeated,
    /// It is before that row.
    Late,
}

impl RowOrder {
    /// Returns true if this time, microseconds, shows that the last row's was ahead of its own: the caller drops that
    /// row, which is forgotten here.
    pub fn shows_last_ahead(&mut self, t_us: impl Into<i128>) -> bool {
        let (Some(before_us), Some(last_us)) = (self.before_us, self.last_us) else { return false };
        let is_between = (before_us + 1..last_us).contains(&t_us.into());
        if is_between {
            (self.last_us, self.before_us) = (Some(before_us), None);
        }
        is_between
    }

    /// Places a row by its time, microseconds; the next one is remembered.
    pub fn place(&mut self, t_us: impl Into<i128>) -> RowPlace {
        let t_us = t_us.into();
        match self.last_us {
            Some(last_us) if t_us == last_us => RowPlace::Repeated,
            Some(last_us) if t_us < last_us => RowPlace::Late,
            before_us => {
                self.last_us = Some(t_us);
                self.before_us = before_us.filter(|before_us| t_us - before_us > FAR_AHEAD_US);
                RowPlace::Next
            }
        }
    }

    /// Returns true if the next row may show that the last one's time is ahead of its own.
    #[must_use]
    pub const fn is_in_doubt(&self) -> bool {
        self.before_us.is_some()
    }
}
