//! A simulated run of one tool: a hole, sensors with errors of the error model's sizes, stations with known truth.

use std::f64::consts::{FRAC_PI_2, TAU};

use libm::{cos, sin};
use meerkat_mwd::{
    config::SurveyErrors,
    survey::multi_station::{MultiStationSettings, PARAMETERS, Parameter, Station, StationReference},
};
use testbed::simulate::Random;

/// Settings of a simulated run.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Number of stations, 30 m apart.
    pub stations: usize,
    /// Standard deviations from which the sensors' and the reference's errors are drawn.
    pub errors: SurveyErrors,
    /// Noise of single stations.
    pub noise: MultiStationSettings,
    /// Largest factor of a station's noise: each station draws its own, from 1 on.
    pub noise_factor: f64,
    /// Share of stations beside something magnetic: 2 microtesla on each axis.
    pub disturbed: f64,
    /// Standard deviation of the angles by which the magnetometer is turned against the accelerometer, radians: an
    /// error that the analysis does not have.
    pub misaligned_rad: f64,
    /// True if the hole is level to the magnetic east or west, within 20 deg, where an axial field hardly shows.
    pub level_to_the_east: bool,
}

impl Default for Run {
    /// A run as the error model has it.
    fn default() -> Self {
        Self {
            stations: 40,
            errors: SurveyErrors::default(),
            noise: MultiStationSettings::default(),
            noise_factor: 1.0,
            disturbed: 0.0,
            misaligned_rad: 0.0,
            level_to_the_east: false,
        }
    }
}

/// A station with its truth.
#[derive(Clone, Copy, Debug)]
pub struct TrueStation {
    /// Readings of the tool.
    pub station: Station,
    /// True inclination, radians.
    pub inclination_rad: f64,
    /// True azimuth from magnetic north, radians.
    pub azimuth_rad: f64,
}

/// The stations of a run and the errors behind them.
#[derive(Clone, Debug)]
pub struct TrueRun {
    /// Stations, the first one the shallowest.
    pub stations: Vec<TrueStation>,
    /// Errors, in the order of [`Parameter::ALL`].
    pub errors: [f64; PARAMETERS],
}

impl Run {
    /// Draws place, hole, errors and noise.
    #[must_use]
    pub fn drawn(&self, seed: u64) -> TrueRun {
        let mut draw = Random::new(seed);
        let place = [9.81, draw.between(42.0, 58.0), draw.between(50.0_f64, 76.0).to_radians()];
        let errors =
            Parameter::ALL.map(|parameter| f64::from(parameter.prior_sigma(&self.errors, &self.noise)) * draw.normal());
        // Build from near vertical to a tangent, with a slow turn.
        let [first, last] = [draw.between(1.0, 30.0), draw.between(20.0, 92.0)].map(f64::to_radians);
        let [start, turn] = [draw.between(0.0, TAU), draw.between(-0.6, 0.6)];
        let build_end = draw.between(0.3, 0.9);
        // Drawn apart: runs that differ in nothing else have the same holes and errors.
        let mut apart = Random::new(!seed);
        let angles = std::array::from_fn(|_| self.misaligned_rad * apart.normal());
        let [first, last, start, turn] = if self.level_to_the_east {
            let east = FRAC_PI_2 * apart.sign() + apart.between(-0.3, 0.3);
            [apart.between(1.45, 1.6), apart.between(1.45, 1.6), east, 0.1 * turn]
        } else {
            [first, last, start, turn]
        };
        let count = self.stations.max(2);
        let stations = (0..count).map(|k| {
            let along = k as f64 / (count - 1) as f64;
            let built = if along < build_end { along / build_end } else { 1.0 };
            let attitude = [first + (last - first) * built, start + turn * along, draw.between(0.0, TAU)];
            self.station(attitude, along, place, &Drawn { errors, angles }, &mut draw)
        });
        TrueRun { stations: stations.collect(), errors }
    }

    fn station(
        &self,
        attitude: [f64; 3],
        along: f64,
        [gravity, total, dip]: [f64; 3],
        Drawn { errors, angles }: &Drawn,
        draw: &mut Random,
    ) -> TrueStation {
        let noise = self.noise;
        let factor = draw.between(1.0, self.noise_factor.max(1.0));
        let mut random = |sigma: f32| factor * f64::from(sigma) * draw.normal();
        let (true_gravity, true_dip) = (gravity + errors[13], dip + errors[15] + random(noise.dip_noise_rad));
        let true_total = total + errors[14] + random(noise.total_field_noise_ut);
        let force = into_tool([0.0, 0.0, -true_gravity], attitude);
        let field = into_tool([true_total * cos(true_dip), 0.0, true_total * sin(true_dip)], attitude);
        let [a, b, c] = angles;
        let field = [
            field[0] + a * field[1] + b * field[2],
            field[1] - a * field[0] + c * field[2],
            field[2] - b * field[0] - c * field[1],
        ];
        let read = std::array::from_fn(|k| {
            ((1.0 + errors[3 + k]) * force[k] + errors[k] + random(noise.force_noise_m_s2)) as f32
        });
        let mut sensed: [f64; 3] =
            std::array::from_fn(|k| (1.0 + errors[9 + k]) * field[k] + errors[6 + k] + random(noise.field_noise_ut));
        sensed[2] += errors[12] * along;
        if draw.between(0.0, 1.0) < self.disturbed {
            sensed.iter_mut().for_each(|x| *x += 2.0 * draw.normal());
        }
        let station = Station {
            depth_m: (1_000.0 + 30.0 * along * (self.stations - 1) as f64) as f32,
            force_m_s2: read,
            field_ut: sensed.map(|x| x as f32),
            reference: StationReference { gravity_m_s2: gravity as f32, field_ut: total as f32, dip_rad: dip as f32 },
        };
        TrueStation { station, inclination_rad: attitude[0], azimuth_rad: attitude[1] }
    }
}

/// Errors of a run.
struct Drawn {
    errors: [f64; PARAMETERS],
    /// Small angles by which the magnetometer is turned.
    angles: [f64; 3],
}

/// A vector of magnetic NED in tool axes, at inclination, azimuth and toolface, radians.
#[must_use]
pub fn into_tool(v: [f64; 3], [inclination, azimuth, toolface]: [f64; 3]) -> [f64; 3] {
    let about_z = |v: [f64; 3], a: f64| [cos(a) * v[0] + sin(a) * v[1], cos(a) * v[1] - sin(a) * v[0], v[2]];
    let v = about_z(v, azimuth);
    let (s, c) = (sin(inclination), cos(inclination));
    about_z([c * v[0] - s * v[2], v[1], c * v[2] + s * v[0]], toolface)
}
