//! Figures of a part from its data sheet.

/// Vector sensor of a part, by its data sheet, at the settings that its driver makes. SI: rad/s of a gyro,
/// m/s^2 of an accelerometer, microtesla of a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorData {
    /// Full scale, either side, SI.
    pub full_scale: f32,
    /// Value of one code, SI.
    pub per_code: f32,
    /// Code, either sign, from which an axis is at the end of its range. Where the range is beyond the word, it is the
    /// word's end: 32,767 of a word of 16 bits.
    pub clip_code: i32,
    /// Latency: time by which the truth precedes the output, per axis of the part, seconds. It is the
    /// low-pass filter and the conversion, which some parts do one axis after the other. Where the data sheet has the
    /// bandwidth f alone: a second-order low-pass delays by 0.225 / f.
    pub latency_s: [f32; 3],
    /// White noise, SI per square root of a hertz; `None` if unknown.
    pub noise_density: Option<f32>,
}

impl SensorData {
    /// Group delay of a second-order Butterworth low-pass at low frequencies, seconds: sqrt(2) / (2 pi f).
    /// Data sheets state the bandwidth and not the delay.
    #[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "icm42688", feature = "bmi088"))]
    pub(super) const fn low_pass_latency_s(bandwidth_hz: f32) -> f32 {
        0.225_079 / bandwidth_hz
    }

    /// Mean of the axes' latencies, seconds.
    #[must_use]
    pub fn mean_latency_s(&self) -> f32 {
        let [x, y, z] = self.latency_s;
        (x + y + z) / 3.0
    }
}

/// Thermometer of a part: `offset_c + per_code_c code`, degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureData {
    /// Temperature of code zero, degrees Celsius.
    pub offset_c: f32,
    /// Value of one code, degrees Celsius.
    pub per_code_c: f32,
}

/// Part with `V` vector sensors, by its data sheet, at the settings that its driver makes. `V` = 2: a gyro and an
/// accelerometer, in this order; `V` = 1: a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartData<const V: usize> {
    /// Name of the part, as its maker writes it.
    pub name: &'static str,
    /// Source of the figures: the data sheet and its sections.
    pub source: &'static str,
    /// Vector sensors.
    pub sensors: [SensorData; V],
    /// Thermometer, if the part has one.
    pub temperature: Option<TemperatureData>,
    /// Nominal time between frames, microseconds.
    pub period_us: u32,
    /// Tolerance of the part's own oscillator, as a share of the period.
    pub period_tolerance: f32,
    /// Capacity of the part's FIFO, frames; 1 means no FIFO: the part keeps only the newest frame.
    pub fifo_frames: u16,
    /// Frames after which the part's FIFO raises the interrupt.
    pub watermark_frames: u16,
    /// Unsettled frames after a start, which are dropped.
    pub settling_frames: u16,
    /// Frames of equal codes on all axes after which a sensor is frozen; three times as many on one axis. The
    /// noise of a sound sensor makes that impossible within its life.
    pub frozen_frames: u16,
}

/// Data of a gyro and an accelerometer, in this order.
pub type InertialData = PartData<2>;
/// Data of a magnetometer.
pub type MagneticData = PartData<1>;

impl<const V: usize> PartData<V> {
    /// Nominal output rate, hertz.
    #[must_use]
    pub fn rate_hz(&self) -> f32 {
        1e6 / self.period_us as f32
    }
}
