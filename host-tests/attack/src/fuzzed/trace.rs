//! A recording that somebody else has written.

use testbed::trace::Trace;

/// A trace as text. In one that is read time goes forward.
///
/// # Panics
/// It does not.
pub fn trace(bytes: &[u8]) {
    if let Ok(trace) = Trace::of_bytes(bytes) {
        assert!(trace.samples.is_sorted_by(|before, after| before.t_us < after.t_us));
    }
}
