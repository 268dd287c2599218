//! Recordings in progress, by hosts with and without the key.

/// Recordings of raw samples: end of those asked for with the key (owner) and without it (guest).
///
/// Hosts with and without the key are kept apart: nobody without the key ends or shortens a recording of one who has
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Recording {
    /// End of each recording, microseconds; 0 for none.
    owner_until_us: u64,
    guest_until_us: u64,
}

impl Recording {
    /// No recording.
    #[must_use]
    pub const fn new() -> Self {
        Self { owner_until_us: 0, guest_until_us: 0 }
    }

    /// Begins a recording of `for_s` seconds or, with `None`, until it is stopped.
    pub fn start(&mut self, now_us: u64, for_s: Option<u32>, authentic: bool) {
        let until_us = for_s.map_or(u64::MAX, |s| now_us.saturating_add(u64::from(s) * 1_000_000));
        *if authentic { &mut self.owner_until_us } else { &mut self.guest_until_us } = until_us;
    }

    /// Ends the recording of hosts without the key and, if `authentic`, also that of hosts with it.
    pub const fn stop(&mut self, authentic: bool) {
        self.guest_until_us = 0;
        if authentic {
            self.owner_until_us = 0;
        }
    }

    /// Returns true if anybody records.
    #[must_use]
    pub const fn is_on(&self, now_us: u64) -> bool {
        now_us < self.owner_until_us || now_us < self.guest_until_us
    }
}

#[cfg(test)]
mod tests;
