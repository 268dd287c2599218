//! A tool at rest whose sensors err as the ISCWSA MWD error model says.

use libm::{cos, sin};
use meerkat_mwd::{
    config::{Earth, SurveyConfig, SurveyErrors},
    survey::{SurveyInput, SurveyNews, SurveyReport, Surveyor},
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Sample period; an average has 500.
const STEP_US: u64 = 20_000;
/// Noise of single readings: 0.15 mg per root hertz over 25 Hz, and 0.3 microtesla.
const ACCEL_NOISE_M_S2: f64 = 0.0074;
const MAG_NOISE_UT: f64 = 0.3;

/// A seeded source of normal numbers.
pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Box and Muller.
    pub fn normal(&mut self) -> f64 {
        libm::sqrt(-2.0 * libm::log(1.0 - self.uniform())) * cos(core::f64::consts::TAU * self.uniform())
    }

    pub fn three(&mut self, sigma: f64) -> [f64; 3] {
        std::array::from_fn(|_| sigma * self.normal())
    }
}

/// The earth at a place: total field, dip.
#[derive(Clone, Copy)]
pub struct Place {
    pub name: &'static str,
    pub field_ut: f64,
    pub dip_deg: f64,
}

/// One tool's errors, the same in every survey.
pub struct Tool {
    accel_bias: [f64; 3],
    accel_scale: [f64; 3],
    mag_bias: [f64; 3],
    mag_scale: [f64; 3],
    axial_ut: f64,
    /// True less configured declination, radians, and total field and dip.
    pub declination_rad: f64,
    field_ut: f64,
    dip_rad: f64,
}

impl Tool {
    pub fn drawn(draw: &mut Draw, errors: &SurveyErrors, place: &Place) -> Self {
        let horizontal = place.field_ut * cos(place.dip_deg.to_radians());
        Self {
            accel_bias: draw.three(errors.accel_bias_m_s2.into()),
            accel_scale: draw.three(errors.accel_scale.into()),
            mag_bias: draw.three(errors.mag_bias_ut.into()),
            mag_scale: draw.three(errors.mag_scale.into()),
            axial_ut: f64::from(errors.axial_interference_ut) * draw.normal(),
            declination_rad: f64::from(errors.declination_rad) * draw.normal()
                + f64::from(errors.declination_rad_ut) / horizontal * draw.normal(),
            field_ut: f64::from(errors.total_field_ut) * draw.normal(),
            dip_rad: f64::from(errors.dip_rad) * draw.normal(),
        }
    }

    /// The stationary survey at an attitude (inclination, magnetic azimuth, toolface, radians).
    pub fn survey(&self, attitude: [f64; 3], place: &Place, config: &SurveyConfig, draw: &mut Draw) -> SurveyReport {
        let mut surveyor = Surveyor::new();
        let earth = Earth {
            magnetic_field_ut: Some(place.field_ut as f32),
            dip_rad: Some(place.dip_deg.to_radians() as f32),
            declination_rad: Some(0.0),
            ..Earth::default()
        };
        surveyor.configure(&earth, config).unwrap();
        let dip = place.dip_deg.to_radians() + self.dip_rad;
        let total = place.field_ut + self.field_ut;
        let force = into_tool([0.0, 0.0, -9.806_65], attitude);
        let field = into_tool([total * cos(dip), 0.0, total * sin(dip)], attitude);
        let mut t_us = 0;
        loop {
            t_us += STEP_US;
            let read =
                |k: usize, noise: f64| (force[k] * (1.0 + self.accel_scale[k]) + self.accel_bias[k] + noise) as f32;
            let axial = [0.0, 0.0, self.axial_ut];
            let sense = |k: usize, noise: f64| {
                (field[k] * (1.0 + self.mag_scale[k]) + self.mag_bias[k] + axial[k] + noise) as f32
            };
            let (accel_noise, mag_noise) = (draw.three(ACCEL_NOISE_M_S2), draw.three(MAG_NOISE_UT));
            let input = SurveyInput {
                t_us,
                rate_rad_s: Some([0.0; 3]),
                force_m_s2: Some(std::array::from_fn(|k| read(k, accel_noise[k]))),
                field_ut: Some(std::array::from_fn(|k| sense(k, mag_noise[k]))),
                ..SurveyInput::default()
            };
            if surveyor.push(&input).contains(SurveyNews::STATIONARY) {
                return *surveyor.stationary().unwrap();
            }
            assert!(t_us < 60_000_000, "no survey in a minute of rest");
        }
    }
}

/// A vector of magnetic NED in tool axes: turned by azimuth about down, inclination about the new y, toolface
/// about the tool axis.
pub fn into_tool(v: [f64; 3], [inclination, azimuth, toolface]: [f64; 3]) -> [f64; 3] {
    let about_z = |v: [f64; 3], a: f64| [cos(a) * v[0] + sin(a) * v[1], cos(a) * v[1] - sin(a) * v[0], v[2]];
    let v = about_z(v, azimuth);
    let (s, c) = (sin(inclination), cos(inclination));
    about_z([c * v[0] - s * v[2], v[1], c * v[2] + s * v[0]], toolface)
}
