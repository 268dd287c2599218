//! An output as bytes of a temporary file.

use meerkat_mwd::{
    attitude::{Attitude, AttitudeFlags},
    probe::Output,
};

use crate::trace::spool::{Bytes, Fixed, put_numbers};

impl Fixed for Output {
    const SIZE: usize = 8 + 12 + 1 + 44 + 2;

    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.t_us.to_le_bytes());
        put_numbers(bytes, &self.rate_rad_s);
        bytes.push(u8::from(self.attitude.is_some()));
        let Some(attitude) = &self.attitude else {
            bytes.extend([0; 46]);
            return;
        };
        put_numbers(bytes, &attitude.q);
        put_numbers(
            bytes,
            &[
                attitude.inclination_rad,
                attitude.azimuth_rad,
                attitude.gravity_toolface_rad,
                attitude.magnetic_toolface_rad,
                attitude.sigma_inclination_rad,
                attitude.sigma_azimuth_rad,
                attitude.sigma_toolface_rad,
            ],
        );
        bytes.extend(attitude.flags.bits().to_le_bytes());
    }

    fn take(bytes: &mut Bytes) -> Self {
        let (t_us, rate_rad_s) = (u64::from_le_bytes(bytes.take_bytes()), bytes.numbers());
        let [is_there] = bytes.take_bytes();
        let attitude = Attitude {
            q: bytes.numbers(),
            inclination_rad: bytes.number(),
            azimuth_rad: bytes.number(),
            gravity_toolface_rad: bytes.number(),
            magnetic_toolface_rad: bytes.number(),
            sigma_inclination_rad: bytes.number(),
            sigma_azimuth_rad: bytes.number(),
            sigma_toolface_rad: bytes.number(),
            flags: AttitudeFlags::from_bits_retain(u16::from_le_bytes(bytes.take_bytes())),
        };
        Self { t_us, rate_rad_s, attitude: (is_there != 0).then_some(attitude) }
    }
}
