//! Steps of the samples' time: which of them is a gap, and which a time stamp alone is not believed.

/// Step of time that counts as a gap, in nominal sample periods; and refused samples in a row that do.
pub const GAP_PERIODS: u32 = 3;

/// Longest step, either way, that one time stamp is believed, microseconds. It leaves nothing of the attitude (half a
/// turn at the 0.3 rad/s that are assumed where no rate is read), so the sample that a longer one costs is worth
/// little, and a wrong stamp that is believed makes samples old for no longer than this.
pub(crate) const LONGEST_BELIEVED_US: u64 = 10_000_000;

/// Returns true if time went back so far that it is another clock's; a smaller step back is a late sample.
pub(crate) const fn is_another_clock(last_us: u64, t_us: u64) -> bool {
    last_us.saturating_sub(t_us) > LONGEST_BELIEVED_US
}

/// Returns true if a step is a gap at this nominal period.
pub(crate) fn is_gap(step_us: u64, period_us: u32) -> bool {
    step_us > u64::from(GAP_PERIODS) * u64::from(period_us)
}
