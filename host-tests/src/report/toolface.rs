//! Which angles of an attitude hold.

use meerkat_mwd::attitude::{Attitude, AttitudeFlags};

/// The toolface that applies, radians.
pub(crate) fn toolface_rad(attitude: &Attitude) -> f32 {
    if is_vertical(attitude) { attitude.magnetic_toolface_rad } else { attitude.gravity_toolface_rad }
}

/// Returns true if the hole is so near the vertical that the magnetic toolface applies.
pub(crate) fn is_vertical(attitude: &Attitude) -> bool {
    attitude.flags.contains(AttitudeFlags::NEAR_VERTICAL)
}

/// Returns true if north has been seen, so that azimuth means something.
pub(crate) fn has_north(attitude: &Attitude) -> bool {
    !attitude.flags.contains(AttitudeFlags::NO_HEADING)
}
