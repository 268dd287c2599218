//! Steps of time from sample to sample: limits beyond which one is a gap, or is not believed of a single stamp.

/// Longest step of time that is no gap, in nominal sample periods; also the most refused samples in a row that are
/// none.
pub const GAP_PERIODS: u32 = 3;

/// Longest step, forward or back, that a single time stamp is believed, microseconds. A gap of this length leaves
/// nothing of the attitude (half a turn at the 0.3 rad/s that are assumed where no rate is read), so refusing the
/// sample after a longer one costs little; and a wrong stamp that is believed has samples refused as old for no longer
/// than this.
pub(crate) const LONGEST_BELIEVED_US: u64 = 10_000_000;

/// Returns true if time went back so far that another clock gave it; a smaller step back is a late sample.
pub(crate) const fn is_another_clock(last_us: u64, t_us: u64) -> bool {
    last_us.saturating_sub(t_us) > LONGEST_BELIEVED_US
}

/// Returns true if a step is a gap at this nominal period.
pub(crate) fn is_gap(step_us: u64, period_us: u32) -> bool {
    step_us > u64::from(GAP_PERIODS) * u64::from(period_us)
}
