//! Error of a configuration.

/// Reason to refuse a [`Config`](super::Config): the field, and what it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub struct ConfigError {
    /// Path of the field, for instance `identification.window_s`.
    pub field: &'static str,
    /// Values that the field may have.
    pub must_be: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "configuration: {} must be {}", self.field, self.must_be)
    }
}

impl core::error::Error for ConfigError {}

/// Names the field unless its value is `ok`.
pub(crate) const fn check(ok: bool, field: &'static str, must_be: &'static str) -> Result<(), ConfigError> {
    if ok { Ok(()) } else { Err(ConfigError { field, must_be }) }
}

/// Names the first field whose value is not finite and positive. The names are an argument of their own, so that they
/// are stored as a constant.
pub(super) fn all_positive<const N: usize>(values: [f32; N], names: &[&'static str; N]) -> Result<(), ConfigError> {
    each_positive(&values, names)
}

#[inline(never)]
fn each_positive(values: &[f32], names: &[&'static str]) -> Result<(), ConfigError> {
    for (value, field) in values.iter().zip(names) {
        if !(value.is_finite() && *value > 0.0) {
            return Err(ConfigError { field, must_be: "finite and positive" });
        }
    }
    Ok(())
}
