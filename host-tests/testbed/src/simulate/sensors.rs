//! The sensors of a run: the gyro's 12 errors, noise, drift, resolution and full scales.

use meerkat_mwd::{Sample, SampleFlags, compensation::GyroModel};
use nalgebra::{Matrix3, Vector3};

use super::{random::Random, scenario::Scenario, vibration::STANDARD_GRAVITY_M_S2};

/// Truth over one sample interval, tool axes: the readings of ideal sensors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ideal {
    /// Inertial rate, rad/s.
    pub(super) rate_rad_s: Vector3<f64>,
    /// Specific force, m/s^2.
    pub(super) specific_force_m_s2: Vector3<f64>,
    /// Gravity, m/s^2; the rest of specific force is acceleration.
    pub(super) gravity_m_s2: Vector3<f64>,
    /// Magnetic flux density, microtesla.
    pub(super) field_ut: Vector3<f64>,
}

/// Standard deviations of the sensors' random errors, sample by sample.
#[derive(Clone, Copy, Debug)]
pub struct SensorNoise {
    /// White noise of a gyro reading, rad/s.
    pub gyro_rad_s: f64,
    /// Step of the bias from one sample to the next, rad/s.
    pub bias_step_rad_s: f64,
    /// White noise of an accelerometer reading, m/s^2.
    pub accel_m_s2: f64,
    /// White noise of a magnetometer reading, microtesla.
    pub mag_ut: f64,
}

impl SensorNoise {
    /// Noise of density n has the standard deviation n times the root of the sample rate, so that its
    /// integral walks n times the root of time.
    pub fn of(scenario: &Scenario) -> Self {
        let root_period = libm::sqrt(f64::from(scenario.sample_period_us) * 1e-6);
        Self {
            gyro_rad_s: scenario.gyro.noise_deg_s_rthz.to_radians() / root_period,
            bias_step_rad_s: scenario.gyro.bias_walk_deg_s_rts.to_radians() * root_period,
            accel_m_s2: scenario.accel.noise_ug_rthz * 1e-6 * STANDARD_GRAVITY_M_S2 / root_period,
            mag_ut: scenario.mag.noise_ut,
        }
    }
}

/// The three sensors of a run.
pub(super) struct Sensors {
    model: GyroModel,
    p_inverse: Matrix3<f64>,
    bias_rad_s: Vector3<f64>,
    bias_step_rad_s: f64,
    gyro: Output,
    accel: Output,
    mag: Output,
    random: Random,
}

impl Sensors {
    /// Draws the gyro's errors from `truth` and its noise from `random`.
    pub(super) fn new(scenario: &Scenario, truth: &mut Random, random: Random) -> Self {
        let gyro = &scenario.gyro;
        let noise = SensorNoise::of(scenario);
        let drawn_p: [[f64; 3]; 3] = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                if row == column {
                    1.0 + truth.normal_off_centre(gyro.diagonal_sigma)
                } else {
                    truth.normal_off_centre(gyro.off_diagonal_sigma)
                }
            })
        });
        let drawn_bias = std::array::from_fn(|_| truth.normal_off_centre(gyro.bias_sigma_deg_s));
        // Rounded first, so that the reported truth is the simulated one.
        let model = GyroModel {
            p: gyro.p.unwrap_or(drawn_p).map(|row| row.map(|x| x as f32)),
            b_rad_s: gyro.bias_deg_s.unwrap_or(drawn_bias).map(|x| x.to_radians() as f32),
        };
        Self {
            model,
            // Cannot fail: scenarios are checked for it, and draws are a few percent. The identity would be a
            // perfect sensor.
            p_inverse: model.p_matrix().map(f64::from).try_inverse().unwrap_or_else(Matrix3::identity),
            bias_rad_s: Vector3::from(model.b_rad_s.map(f64::from)),
            bias_step_rad_s: noise.bias_step_rad_s,
            gyro: Output {
                noise: noise.gyro_rad_s,
                resolution: gyro.resolution_deg_s.map(f64::to_radians),
                full_scale: full_scales(scenario).gyro_rad_s,
                clipped: SampleFlags::GYRO_CLIPPED,
            },
            accel: Output {
                noise: noise.accel_m_s2,
                resolution: scenario.accel.resolution_m_s2,
                full_scale: full_scales(scenario).accel_m_s2,
                clipped: SampleFlags::ACCEL_CLIPPED,
            },
            mag: Output {
                noise: noise.mag_ut,
                resolution: scenario.mag.resolution_ut,
                full_scale: full_scales(scenario).mag_ut,
                clipped: SampleFlags::MAG_CLIPPED,
            },
            random,
        }
    }

    /// The gyro's true model; its bias is the one at the start of the run.
    pub(super) fn truth(&self) -> GyroModel {
        self.model
    }

    /// The bias in the next reading, rad/s.
    pub(super) fn bias_rad_s(&self) -> Vector3<f64> {
        self.bias_rad_s
    }

    /// Changes the bias at once.
    pub(super) fn step_bias(&mut self, step_rad_s: &Vector3<f64>) {
        self.bias_rad_s += step_rad_s;
    }

    /// The gyro's reading without bias, offsets and noise, rad/s along its own axes.
    pub(super) fn scaled_rate(&self, rate_rad_s: &Vector3<f64>) -> Vector3<f64> {
        self.p_inverse * rate_rad_s
    }

    /// The reading at `t_us`, with a momentary gyro offset beside the bias; call once for each sample, in
    /// order.
    pub(super) fn read(&mut self, t_us: u64, ideal: &Ideal, gyro_offset_rad_s: &Vector3<f64>) -> Sample {
        let mut sample = Sample { t_us, flags: SampleFlags::TEMPERATURE_MISSING, ..Sample::default() };
        let raw = self.scaled_rate(&ideal.rate_rad_s) + self.bias_rad_s + gyro_offset_rad_s;
        self.bias_rad_s += self.random.normal3() * self.bias_step_rad_s;
        sample.gyro_rad_s = self.gyro.read(&raw, &mut self.random, &mut sample.flags);
        sample.accel_m_s2 = self.accel.read(&ideal.specific_force_m_s2, &mut self.random, &mut sample.flags);
        sample.mag_ut = self.mag.read(&ideal.field_ut, &mut self.random, &mut sample.flags);
        sample
    }
}

/// Full scales in SI units and rounded to the readings' precision, so that a clipped reading equals its full
/// scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FullScales {
    pub(super) gyro_rad_s: Option<f64>,
    pub(super) accel_m_s2: Option<f64>,
    pub(super) mag_ut: Option<f64>,
}

pub(super) fn full_scales(scenario: &Scenario) -> FullScales {
    let rounded = |x: f64| f64::from(x as f32);
    FullScales {
        gyro_rad_s: scenario.gyro.full_scale_deg_s.map(|x| rounded(x.to_radians())),
        accel_m_s2: scenario.accel.full_scale_g.map(|x| rounded(x * STANDARD_GRAVITY_M_S2)),
        mag_ut: scenario.mag.full_scale_ut.map(rounded),
    }
}

/// A row-major matrix.
pub(super) fn matrix([a, b, c]: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_rows(&[a, b, c].map(|row| Vector3::from(row).transpose()))
}

/// Output stage of a sensor: noise, then full scale, then resolution.
struct Output {
    /// Standard deviation of each reading.
    noise: f64,
    resolution: Option<f64>,
    full_scale: Option<f64>,
    clipped: SampleFlags,
}

impl Output {
    fn read(&self, value: &Vector3<f64>, random: &mut Random, flags: &mut SampleFlags) -> [f32; 3] {
        let noisy = value + random.normal3() * self.noise;
        <[f64; 3]>::from(noisy).map(|x| {
            let x = self.resolution.map_or(x, |step| step * libm::round(x / step));
            match self.full_scale {
                Some(full_scale) if x.abs() >= full_scale => {
                    flags.insert(self.clipped);
                    full_scale.copysign(x) as f32
                }
                _ => x as f32,
            }
        })
    }
}
