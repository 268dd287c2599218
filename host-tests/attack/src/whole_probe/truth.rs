//! Motion of the tool, stretches of drilling and stops, and what ideal sensors would read.

use super::proportions::Proportions;
use meerkat_mwd::{Sample, SampleFlags};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::TAU;
use testbed::simulate::Random;

/// Gravity, m/s^2; total field, microtesla; dip, radians.
const GRAVITY_M_S2: f64 = 9.80665;
pub const FIELD_UT: f64 = 50.0;
pub const DIP_RAD: f64 = 1.134;
/// Inclinations, azimuths and toolfaces that are drawn, radians.
const DIRECTIONS: [(f64, f64); 3] = [(0.2, 1.5), (0.0, 6.2), (0.0, 6.2)];
/// Time in which the rotation starts or stops, seconds.
const RAMP_S: f64 = 0.4;
/// Noise of a reading: rad/s, m/s^2, microtesla.
const NOISE: [f64; 3] = [1.2e-3, 0.03, 0.2];

/// True angles of the tool at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Angles {
    /// Inclination, azimuth and gravity toolface, radians.
    pub radians: [f64; 3],
}

/// A stretch of drilling.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from_s: f64,
    to_s: f64,
    rate_rad_s: f64,
    vibration_m_s2: f64,
}

/// The tool's motion since the day began. It goes on while the probe has no power.
pub struct Truth {
    random: Random,
    period_s: f64,
    t_s: f64,
    /// In order of time, with rests between them, and one before the first.
    drilling: Vec<Stretch>,
    /// The stretch that is next, or has begun.
    current: usize,
    angles: Angles,
    /// Change of inclination and azimuth while the tool drills, rad/s.
    curve_rad_s: [f64; 2],
    /// Inverse of P, and b.
    gyro: (Matrix3<f64>, Vector3<f64>),
}

impl Truth {
    /// A hole, a gyro and a day, drawn at random.
    pub fn new(mut random: Random, period_us: u32, proportions: &Proportions) -> Self {
        let [inclination, azimuth, toolface] = DIRECTIONS.map(|(a, b)| random.between(a, b));
        let p = Matrix3::identity() + Matrix3::from_fn(|_, _| 0.01 * random.normal());
        let bias = random.normal3() * 0.01;
        let mut drilling = Vec::new();
        let &Proportions { length_s, first_rest_s, drilling_s, rest_s, hole_curves, .. } = proportions;
        let between = |random: &mut Random, [low, high]: [f64; 2]| random.between(low, high);
        let mut from_s = between(&mut random, first_rest_s);
        while from_s < length_s {
            let to_s = from_s + between(&mut random, drilling_s);
            let rate_rad_s = random.sign() * random.between(2.0, 9.0);
            drilling.push(Stretch { from_s, to_s, rate_rad_s, vibration_m_s2: random.between(0.3, 2.0) });
            from_s = to_s + between(&mut random, rest_s);
        }
        let curve_rad_s = if hole_curves {
            let all_s: f64 = drilling.iter().map(|stretch: &Stretch| stretch.to_s - stretch.from_s).sum();
            let (low, high) = DIRECTIONS[0];
            [random.between(low, high) - inclination, random.between(-1.0, 1.0)].map(|change| change / all_s)
        } else {
            [0.0; 2]
        };
        Self {
            random,
            period_s: f64::from(period_us) * 1e-6,
            t_s: 0.0,
            drilling,
            current: 0,
            angles: Angles { radians: [inclination, azimuth, toolface] },
            curve_rad_s,
            gyro: (p.try_inverse().unwrap_or_else(Matrix3::identity), bias),
        }
    }

    /// Times at which the tool begins to drill, seconds.
    pub fn begins_s(&self) -> Vec<f64> {
        self.drilling.iter().map(|stretch| stretch.from_s).collect()
    }

    /// The stretch that goes on now.
    fn stretch(&self) -> Option<&Stretch> {
        self.drilling.get(self.current).filter(|stretch| stretch.from_s <= self.t_s)
    }

    /// For how long the tool has been moving without a pause, seconds; 0 at rest.
    pub fn drilling_for_s(&self) -> f64 {
        self.stretch().map_or(0.0, |stretch| self.t_s - stretch.from_s)
    }

    /// Angles now.
    pub const fn angles(&self) -> Angles {
        self.angles
    }

    /// Time passes by a sample period.
    pub fn step(&mut self) {
        let before = self.rate();
        self.t_s += self.period_s;
        if self.stretch().is_some_and(|stretch| self.t_s >= stretch.to_s) {
            self.current += 1;
        }
        let toolface = self.angles.radians[2] + 0.5 * (before + self.rate()) * self.period_s;
        self.angles.radians[2] = libm::fmod(toolface, TAU);
        let curve = self.curve();
        for (angle, change) in self.angles.radians.iter_mut().zip(curve) {
            *angle += change * self.period_s;
        }
    }

    /// Rotation about the tool's axis, rad/s, with stick-slip.
    fn rate(&self) -> f64 {
        let Some(stretch) = self.stretch() else { return 0.0 };
        let (since_s, left_s) = (self.t_s - stretch.from_s, stretch.to_s - self.t_s);
        stretch.rate_rad_s * (since_s.min(left_s) / RAMP_S).clamp(0.0, 1.0) * (1.0 + 0.5 * libm::sin(3.0 * since_s))
    }

    /// Change of inclination and azimuth now, rad/s.
    fn curve(&self) -> [f64; 2] {
        if self.stretch().is_some() { self.curve_rad_s } else { [0.0; 2] }
    }

    /// Readings of the sensors now; the time is the caller's.
    pub fn sample(&mut self) -> Sample {
        let [inclination, azimuth, toolface] = self.angles.radians;
        let to_ned = Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), inclination)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), toolface);
        let (down, north) = libm::sincos(DIP_RAD);
        let vibration = self.stretch().map_or(0.0, |stretch| stretch.vibration_m_s2);
        let [gyro, accel, mag] = NOISE;
        let [build, walk] = self.curve();
        let (sine, cosine) = libm::sincos(toolface);
        let curve = to_ned.inverse() * Vector3::new(0.0, 0.0, walk) + Vector3::new(sine, cosine, 0.0) * build;
        let turn = Vector3::new(0.0, 0.0, self.rate()) + curve;
        let rate = self.gyro.0 * turn + self.gyro.1 + self.random.normal3() * gyro;
        let force =
            to_ned.inverse() * Vector3::new(0.0, 0.0, -GRAVITY_M_S2) + self.random.normal3() * (accel + vibration);
        let field = to_ned.inverse() * Vector3::new(north, 0.0, down) * FIELD_UT + self.random.normal3() * mag;
        let f32s = |v: Vector3<f64>| <[f32; 3]>::from(v.map(|x| x as f32));
        Sample {
            t_us: 0,
            gyro_rad_s: f32s(rate),
            accel_m_s2: f32s(force),
            mag_ut: f32s(field),
            temperature_c: 40.0,
            flags: SampleFlags::empty(),
        }
    }
}
