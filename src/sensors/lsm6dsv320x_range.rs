//! Range of an LSM6DSV320X.

/// Accelerometer that is read, out of the two of an LSM6DSV320X.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Lsm6dsv320xRange {
    /// Range to 16 g, at 240 Hz.
    #[default]
    G16,
    /// Range to 320 g for shocks, in steps of 10 mg, at its slowest rate, 480 Hz.
    G320,
}
