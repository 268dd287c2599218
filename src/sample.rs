//! Samples: one reading of all sensors, as a driver or a recorded trace gives it.

use nalgebra::Vector3;

bitflags::bitflags! {
    /// Known faults of a [`Sample`]; no bit set means none.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct SampleFlags: u16 {
        /// The gyro gave no reading; `gyro_rad_s` is not to be used.
        const GYRO_MISSING = 1;
        /// The accelerometer gave no reading; `accel_m_s2` is not to be used.
        const ACCEL_MISSING = 1 << 1;
        /// The magnetometer gave no reading; `mag_ut` is not to be used.
        const MAG_MISSING = 1 << 2;
        /// There is no temperature; `temperature_c` is not to be used.
        const TEMPERATURE_MISSING = 1 << 3;
        /// A gyro axis is at its full scale.
        const GYRO_CLIPPED = 1 << 4;
        /// An accelerometer axis is at its full scale.
        const ACCEL_CLIPPED = 1 << 5;
        /// A magnetometer axis is at its full scale.
        const MAG_CLIPPED = 1 << 6;
        /// The driver reported a bus or device fault: no reading of this sample is used.
        const FAULT = 1 << 7;
    }
}

impl SampleFlags {
    /// Flag of a sensor that gave no reading.
    pub(crate) const fn missing(sensor: Sensor) -> Self {
        match sensor {
            Sensor::Gyro => Self::GYRO_MISSING,
            Sensor::Accelerometer => Self::ACCEL_MISSING,
            Sensor::Magnetometer => Self::MAG_MISSING,
        }
    }

    /// Flag of a sensor at its full scale.
    pub(crate) const fn clipped(sensor: Sensor) -> Self {
        match sensor {
            Sensor::Gyro => Self::GYRO_CLIPPED,
            Sensor::Accelerometer => Self::ACCEL_CLIPPED,
            Sensor::Magnetometer => Self::MAG_CLIPPED,
        }
    }
}

bitflags::bitflags! {
    /// Turns about the probe's axes, as gyro and accelerometer and as gyro and magnetometer agree on them.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct TurnFlags: u16 {
        /// A turn about x, by gravity.
        const X_BY_ACCEL = 1;
        /// A turn about y, by gravity.
        const Y_BY_ACCEL = 1 << 1;
        /// A turn about z, by gravity.
        const Z_BY_ACCEL = 1 << 2;
        /// A turn about x, by the field.
        const X_BY_MAG = 1 << 3;
        /// A turn about y, by the field.
        const Y_BY_MAG = 1 << 4;
        /// A turn about z, by the field.
        const Z_BY_MAG = 1 << 5;
    }
}

/// As bits: the names as text would take 3 KB.
#[cfg(all(feature = "defmt", target_os = "none"))]
impl defmt::Format for TurnFlags {
    fn format(&self, to: defmt::Formatter<'_>) {
        defmt::write!(to, "{=u16:b}", self.bits());
    }
}

/// A vector sensor of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Sensor {
    /// Gyro: rate, rad/s.
    Gyro,
    /// Accelerometer: specific force, m/s^2.
    Accelerometer,
    /// Magnetometer: field, microtesla.
    Magnetometer,
}

impl Sensor {
    /// All three sensors, in the order of a [`Sample`]'s fields.
    pub(crate) const ALL: [Self; 3] = [Self::Gyro, Self::Accelerometer, Self::Magnetometer];
}

/// One sensor's part of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// No reading: the mean of an interval is that of its other readings.
    Missing,
    /// A reading that is clipped; a rate or field that is stale or of a dead axis. The mean of an interval with it
    /// would be biased, so such an interval has none.
    Unusable,
    /// Raw rate, or a vector sensor's calibrated reading.
    Usable(Vector3<f32>),
}

/// Bounds per axis beyond any sensor: gyro 57,000 deg/s, accelerometer 1,000 g, magnetometer 10 millitesla. A larger
/// number is a defect of the driver. Squares of numbers below the bounds stay far inside an f32.
pub(crate) const BEYOND_ANY_GYRO_RAD_S: f32 = 1e3;
pub(crate) const BEYOND_ANY_ACCEL_M_S2: f32 = 1e4;
pub(crate) const BEYOND_ANY_MAG_UT: f32 = 1e4;
/// Lowest and highest temperature of a probe's electronics, degrees Celsius: storage limits of parts for drilling
/// (silicon-on-insulator parts end at 225 to 250).
pub(crate) const TEMPERATURES_C: [f32; 2] = [-65.0, 250.0];

/// Returns true for a temperature that a probe's electronics can have; a NaN is none.
pub(crate) fn is_temperature(celsius: f32) -> bool {
    let [coldest, hottest] = TEMPERATURES_C;
    (coldest..=hottest).contains(&celsius)
}

/// One reading of all sensors in SI units, in the body frame, uncompensated.
///
/// The body frame is right-handed: z along the tool axis, down-hole; x across it, at the highside where
/// toolfaces are counted from. Hanging at rest in a vertical hole the tool reads a specific force of (0, 0,
/// -9.8) m/s^2. A driver turns its sensor's axes into these.
///
/// A sensor that did not read has its `*_MISSING` flag set and zeros in its field. The fields of an unflagged
/// sensor are finite: [`Sample::sanitised`] ensures it at the entry of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// Time of acquisition in microseconds; strictly increasing from sample to sample.
    pub t_us: u64,
    /// Angular rate, rad/s.
    pub gyro_rad_s: [f32; 3],
    /// Specific force, m/s^2: at rest it points up, norm about 9.8.
    pub accel_m_s2: [f32; 3],
    /// Magnetic flux density, microtesla.
    pub mag_ut: [f32; 3],
    /// Temperature of the inertial sensor, degrees Celsius.
    pub temperature_c: f32,
    /// Known faults of this sample.
    pub flags: SampleFlags,
}

impl Sample {
    /// Stored reading of one sensor; zeros if it is missing.
    pub(crate) const fn vector(&self, sensor: Sensor) -> [f32; 3] {
        match sensor {
            Sensor::Gyro => self.gyro_rad_s,
            Sensor::Accelerometer => self.accel_m_s2,
            Sensor::Magnetometer => self.mag_ut,
        }
    }

    /// Returns the sample with every field that is not finite, or beyond any sensor, zeroed and flagged missing, so
    /// that no NaN enters a state and no infinity arises in one. A sample with a fault loses all its readings.
    #[must_use]
    pub fn sanitised(mut self) -> Self {
        let fault = self.flags.contains(SampleFlags::FAULT);
        let guard = |v: &mut [f32; 3], limit: f32, missing: SampleFlags, flags: &mut SampleFlags| {
            // A NaN fails this comparison, too.
            if fault || !v.iter().all(|x| libm::fabsf(*x) < limit) || flags.contains(missing) {
                *v = [0.0; 3];
                flags.insert(missing);
            }
        };
        guard(&mut self.gyro_rad_s, BEYOND_ANY_GYRO_RAD_S, SampleFlags::GYRO_MISSING, &mut self.flags);
        guard(&mut self.accel_m_s2, BEYOND_ANY_ACCEL_M_S2, SampleFlags::ACCEL_MISSING, &mut self.flags);
        guard(&mut self.mag_ut, BEYOND_ANY_MAG_UT, SampleFlags::MAG_MISSING, &mut self.flags);
        if !is_temperature(self.temperature_c) || self.flags.contains(SampleFlags::TEMPERATURE_MISSING) {
            self.temperature_c = 0.0;
            self.flags.insert(SampleFlags::TEMPERATURE_MISSING);
        }
        self
    }
}

#[cfg(test)]
mod tests;
