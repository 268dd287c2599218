//! Outcome of a call.

/// Outcome of a call. Errors are below zero: the probe is then as it was, and what a call writes means nothing.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MwdStatus {
    /// Done.
    Ok = 0,
    /// Nothing to give: no report is ready, no survey was taken, or the sample was not taken because of its time.
    Nothing = 1,
    /// A pointer is NULL.
    ErrorNull = -1,
    /// A pointer is not aligned for what it leads to.
    ErrorMisaligned = -2,
    /// The memory that was given is too small.
    ErrorTooSmall = -3,
    /// The configuration is of another version of the header.
    ErrorVersion = -4,
    /// A field of the configuration cannot be used; `mwd_config_validate` says which and why.
    ErrorConfig = -5,
    /// It is not configured yet.
    ErrorNotConfigured = -6,
    /// A number of an argument stands for nothing.
    ErrorArgument = -7,
}
