/// One vector sensor of a part as its data sheet describes it, at the settings that its driver makes.
/// SI: rad/s of a gyro, m/s^2 of an accelerometer, microtesla of a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorData {
    /// Full scale, either side, SI.
    pub full_scale: f32,
    /// SI units of one code.
    pub per_code: f32,
    /// A code of at least this size, either sign, is at the end of the range.
    pub clip_code: i32,
    /// How long the truth precedes the output, per axis of the part, seconds: its low-pass filter and its conversion, which some parts do
    /// one axis after the other.
    pub latency_s: [f32; 3],
    /// White noise, SI per square root of a hertz; `None`: not known to us.
    pub noise_density: Option<f32>,
}

impl SensorData {
    /// Group delay of a second-order Butterworth low-pass at low frequencies, seconds: sqrt(2) / (2 pi f). Data sheets state the bandwidth
    /// and not the delay.
    #[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "icm42688", feature = "bmi088"))]
    pub(super) const fn low_pass_latency_s(bandwidth_hz: f32) -> f32 {
        0.225_079 / bandwidth_hz
    }

    /// The mean of the axes' latencies, seconds: for [`Latency`](crate::config::Config::latency).
    #[must_use]
    pub fn mean_latency_s(&self) -> f32 {
        let [x, y, z] = self.latency_s;
        (x + y + z) / 3.0
    }
}

/// Temperature of a part: `offset_c + per_code_c code`, degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureData {
    /// What code zero means, degrees Celsius.
    pub offset_c: f32,
    /// Degrees Celsius of one code.
    pub per_code_c: f32,
}

/// A part of `V` vector sensors as its data sheet describes it, at the settings that its driver makes: two are a gyro and an
/// accelerometer, in this order; one is a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartData<const V: usize> {
    /// The part's name, as its maker writes it.
    pub name: &'static str,
    /// Where the figures are from: the data sheet and its sections.
    pub source: &'static str,
    /// Its vector sensors.
    pub sensors: [SensorData; V],
    /// Its thermometer, if it has one.
    pub temperature: Option<TemperatureData>,
    /// Nominal time from frame to frame, microseconds.
    pub period_us: u32,
    /// How far the part's own oscillator may be off, as a share of the period.
    pub period_tolerance: f32,
    /// Frames that its FIFO holds; 1: it has none, and keeps only the newest.
    pub fifo_frames: u16,
    /// Frames after which its FIFO raises the interrupt.
    pub watermark_frames: u16,
    /// Frames after a start that are not yet settled, and are not handed on.
    pub settling_frames: u16,
    /// A sensor's output that is the same, code by code on all axes, for more frames than this is frozen; on one axis, for three times as many.
    /// The noise of a sound sensor makes that impossible within its life.
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
