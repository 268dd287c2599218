//! Times as text, in seconds.

/// Microseconds as seconds with six decimals.
pub const fn seconds(t_us: u64) -> Seconds {
    Seconds(t_us)
}

/// A time that prints as seconds; see [`seconds`].
pub struct Seconds(u64);

impl std::fmt::Display for Seconds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{:06}", self.0 / 1_000_000, self.0 % 1_000_000)
    }
}
