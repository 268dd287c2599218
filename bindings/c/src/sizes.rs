//! Sizes of the objects that a caller gives memory for.

use crate::{MwdAttitudeFilter, MwdMountingCheck, MwdProbe, MwdSurveyor};

/// Bytes of storage for an `MwdProbe`.
pub const MWD_PROBE_SIZE: usize = 96256;
/// Alignment of that storage, bytes: an array of `uint64_t` has it.
pub const MWD_PROBE_ALIGN: usize = 8;
/// Bytes of storage for an `MwdSurveyor`.
pub const MWD_SURVEYOR_SIZE: usize = 2048;
/// Alignment of that storage, bytes.
pub const MWD_SURVEYOR_ALIGN: usize = 8;
/// Bytes of storage for an `MwdAttitudeFilter`.
pub const MWD_ATTITUDE_FILTER_SIZE: usize = 2048;
/// Alignment of that storage, bytes.
pub const MWD_ATTITUDE_FILTER_ALIGN: usize = 8;
/// Bytes of storage for an `MwdMountingCheck`.
pub const MWD_MOUNTING_CHECK_SIZE: usize = 1024;
/// Alignment of that storage, bytes.
pub const MWD_MOUNTING_CHECK_ALIGN: usize = 8;

// A macro that is too small does not compile; one that is a KiB too large fails a test.
const _: () = assert!(size_of::<MwdProbe>() <= MWD_PROBE_SIZE, "raise MWD_PROBE_SIZE");
const _: () = assert!(size_of::<MwdSurveyor>() <= MWD_SURVEYOR_SIZE, "raise MWD_SURVEYOR_SIZE");
const _: () = assert!(size_of::<MwdAttitudeFilter>() <= MWD_ATTITUDE_FILTER_SIZE, "raise MWD_ATTITUDE_FILTER_SIZE");
const _: () = assert!(size_of::<MwdMountingCheck>() <= MWD_MOUNTING_CHECK_SIZE, "raise MWD_MOUNTING_CHECK_SIZE");
const _: () = assert!(align_of::<MwdProbe>() <= MWD_PROBE_ALIGN);
const _: () = assert!(align_of::<MwdSurveyor>() <= MWD_SURVEYOR_ALIGN);
const _: () = assert!(align_of::<MwdAttitudeFilter>() <= MWD_ATTITUDE_FILTER_ALIGN);
const _: () = assert!(align_of::<MwdMountingCheck>() <= MWD_MOUNTING_CHECK_ALIGN);
