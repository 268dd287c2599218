//! The cases. Truth is drawn at random for each seed.

use meerkat_mwd::{
    Config, Sample, SampleFlags, compensation::GyroModel, config::Latency, identification::WindowReport,
};

use super::seen::{Seen, counted, seen};
use testbed::{
    flight::{Flight, configuration::of_trace, fly},
    simulate::{
        Effects, Gyro, HardIronInterval, Hole, Random, Rotation, Scenario, ShockSettings, Temperature, Vibration,
        Wobble, simulate,
    },
    trace::Trace,
};

/// One figure of a case.
pub(super) struct Figure {
    pub name: &'static str,
    pub unit: &'static str,
    pub at_most: Option<f64>,
}

pub(super) struct Case {
    pub name: &'static str,
    pub figures: &'static [Figure],
    /// Figures of one seed, in this order.
    pub run: fn(u64) -> anyhow::Result<Vec<f64>>,
}

const fn figure(name: &'static str, unit: &'static str, at_most: Option<f64>) -> Figure {
    Figure { name, unit, at_most }
}

/// Five deviations: once in two million by chance.
const TOLD: Option<f64> = Some(5.0);
const HEADING: Figure = figure("heading, largest error", "deg", Some(0.5));
const SIGMAS: Figure = figure("sigmas", "", TOLD);

pub(super) const CASES: [Case; 12] = [
    Case {
        name: "the string untwists, 0.05 deg/s for 19 s",
        figures: &[HEADING, SIGMAS],
        run: |seed| untwists(seed, 0.05),
    },
    Case { name: "0.1 deg/s", figures: &[HEADING, SIGMAS], run: |seed| untwists(seed, 0.1) },
    Case { name: "0.2 deg/s", figures: &[HEADING, SIGMAS], run: |seed| untwists(seed, 0.2) },
    Case { name: "0.3 deg/s", figures: &[HEADING, SIGMAS], run: |seed| untwists(seed, 0.3) },
    Case {
        name: "scale of z drifts by 2 % in 5 min with temperature",
        figures: &[
            figure("attitude without effects", "deg rms", None),
            figure("with", "deg rms", None),
            figure("with over without", "", Some(1.0)),
        ],
        run: scale_drifts,
    },
    Case {
        name: "accelerometer off by 0.2 to 0.4 mg, field by 30 to 50 nT",
        figures: &[
            figure("elements of P outside of their 95 %", "%", Some(7.0)),
            figure("largest error of an element", "sigmas", TOLD),
        ],
        run: sensors_within_their_data_sheets,
    },
    Case {
        name: "rotation begins in a vertical hole, gyro scale off by 1 to 4 %",
        figures: &[figure("toolface, largest error", "deg", None), SIGMAS],
        run: begins_in_a_vertical_hole,
    },
    Case {
        name: "gyro twice too large on and off every 0.4 s for 30 s",
        figures: &[figure("inclination after 60 s more", "deg", None), SIGMAS],
        run: |seed| on_and_off(seed, |sample| sample.gyro_rad_s = sample.gyro_rad_s.map(|x| 2.0 * x)),
    },
    Case {
        name: "accelerometer missing on and off",
        figures: &[figure("inclination after 60 s more", "deg", None), SIGMAS],
        run: |seed| on_and_off(seed, |sample| sample.flags.insert(SampleFlags::ACCEL_MISSING)),
    },
    Case {
        name: "gyro missing on and off",
        figures: &[figure("inclination after 60 s more", "deg", None), SIGMAS],
        run: |seed| on_and_off(seed, |sample| sample.flags.insert(SampleFlags::GYRO_MISSING)),
    },
    Case {
        name: "a gyro that reads 8.9 deg/s at rest",
        figures: &[figure("rate flown at rest", "deg/s", Some(0.2)), SIGMAS],
        run: reads_at_rest,
    },
    Case {
        name: "a magnet that comes at 60 s and stays",
        figures: &[figure("time from which it is reported, off by", "s", Some(10.0))],
        run: a_magnet_comes,
    },
];

/// A hole of any direction in which azimuth and toolface are sound.
fn inclined(random: &mut Random) -> Hole {
    let inclination_deg = random.between(20.0, 70.0);
    Hole { inclination_deg, azimuth_deg: random.between(0.0, 360.0), ..Hole::default() }
}

/// A tool without vibration in a drawn hole.
fn quiet(random: &mut Random) -> Scenario {
    Scenario {
        duration_s: 180.0,
        rest_s: 30.0,
        ramp_s: 0.5,
        hole: inclined(random),
        rotation: Rotation { toolface_deg: random.between(0.0, 360.0), stick_slip: 0.0, ..Rotation::default() },
        wobble: Wobble { rms_deg: 0.0, ..Wobble::default() },
        vibration: Vibration::none(),
        shocks: ShockSettings { per_minute: 0.0, ..ShockSettings::default() },
        ..Scenario::default()
    }
}

/// Delays are declared: what is scored is something else.
pub(super) fn configured(trace: &Trace) -> Config {
    Config { latency: Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) }, ..of_trace(trace) }
}

pub(super) fn flown(trace: &Trace, config: &Config) -> anyhow::Result<Flight> {
    Ok(fly(config, &trace.samples, |_| {})?)
}

pub(super) fn random(seed: u64) -> Random {
    // A stream apart from the simulator's own.
    Random::new(!seed)
}

/// Largest heading error and sigmas after the untwisting began.
fn untwists(seed: u64, rate_deg_s: f64) -> anyhow::Result<Vec<f64>> {
    let quiet = quiet(&mut random(seed));
    let rotation = Rotation { mean_rpm: rate_deg_s / 6.0, ..quiet.rotation };
    let scenario = Scenario { rotation, stop_s: Some(quiet.rest_s + 19.0), ..quiet };
    let (trace, _) = simulate(&scenario, seed);
    let flight = flown(&trace, &configured(&trace))?;
    let Seen { heading_deg, sigmas, .. } = seen(&trace, &flight, scenario.rest_s - 1.0);
    Ok(vec![heading_deg, sigmas])
}

fn scale_drifts(seed: u64) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let percent_c = 0.1 * if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    let scenario = Scenario {
        duration_s: 360.0,
        rest_s: 20.0,
        hole: inclined(&mut random),
        temperature: Some(Temperature { end_c: Some(45.0), ..Temperature::default() }),
        effects: Effects { gyro_scale_temperature_percent_c: [0.0, 0.0, percent_c], ..Effects::default() },
        ..Scenario::default()
    };
    let (trace, _) = simulate(&scenario, seed);
    let config = configured(&trace);
    let [without, with] = [false, true].map(|effects| flown(&trace, &Config { effects, ..config }));
    let [without, with] = [seen(&trace, &without?, 60.0).rms_deg, seen(&trace, &with?, 60.0).rms_deg];
    Ok(vec![without, with, with / without])
}

/// Errors of P's elements against the truth over all windows, in their stated deviations.
fn errors_of_p(flight: &Flight, truth: &GyroModel) -> Vec<f64> {
    let of = |report: &WindowReport| -> Vec<f64> {
        let elements = report.fitted.p.into_iter().flatten().zip(truth.p.into_iter().flatten());
        elements
            .zip(report.sigma)
            .map(|((found, true_one), sigma)| counted(f64::from((found - true_one) / sigma).abs()))
            .collect()
    };
    flight.reports.iter().filter(|report| report.cost_after.is_some()).flat_map(of).collect()
}

fn sensors_within_their_data_sheets(seed: u64) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let mut vector = |least: f64, most: f64| {
        let length = random.between(least, most);
        random.direction().map(|x| x * length)
    };
    let (accel_bias_m_s2, hard_iron_ut) = (vector(0.002, 0.004), vector(0.03, 0.05));
    let scenario = Scenario {
        duration_s: 220.0,
        hole: inclined(&mut random),
        effects: Effects { accel_bias_m_s2, hard_iron_ut, ..Effects::default() },
        ..Scenario::default()
    };
    let (trace, truth) = simulate(&scenario, seed);
    let config = configured(&trace);
    let flight = flown(&trace, &config)?;
    let errors = errors_of_p(&flight, &truth.gyro);
    let outside = errors.iter().filter(|error| **error > 1.96).count();
    Ok(vec![100.0 * outside as f64 / errors.len() as f64, errors.iter().copied().fold(0.0, f64::max)])
}

fn begins_in_a_vertical_hole(seed: u64) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let off = random.between(0.01, 0.04) * if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    let p = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0 + off]];
    let scenario = Scenario {
        duration_s: 90.0,
        rest_s: 20.0,
        hole: Hole { inclination_deg: 0.0, azimuth_deg: random.between(0.0, 360.0), ..Hole::default() },
        rotation: Rotation { mean_rpm: random.between(30.0, 120.0), ..Rotation::default() },
        gyro: Gyro { p: Some(p), ..Gyro::default() },
        ..Scenario::default()
    };
    let (trace, _) = simulate(&scenario, seed);
    let Seen { heading_deg, sigmas, .. } = seen(&trace, &flown(&trace, &configured(&trace))?, scenario.rest_s);
    Ok(vec![heading_deg, sigmas])
}

/// A fault on and off every 0.4 s from the 60th to the 90th second; all is sound after it.
fn on_and_off(seed: u64, spoil: fn(&mut Sample)) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let hole = inclined(&mut random);
    let (mut trace, _) = simulate(&Scenario { duration_s: 180.0, hole, ..Scenario::default() }, seed);
    for sample in &mut trace.samples {
        let since_us = sample.t_us.saturating_sub(60_000_000);
        if (1..30_000_000).contains(&since_us) && since_us % 800_000 < 400_000 {
            spoil(sample);
        }
    }
    let flight = flown(&trace, &configured(&trace))?;
    Ok(vec![seen(&trace, &flight, 150.0).inclination_deg, seen(&trace, &flight, 20.0).sigmas])
}

fn reads_at_rest(seed: u64) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let bias_deg_s = random.direction().map(|x| 8.9 * x);
    let scenario = Scenario {
        duration_s: 60.0,
        rest_s: 20.0,
        hole: inclined(&mut random),
        gyro: Gyro { bias_deg_s: Some(bias_deg_s), diagonal_sigma: 0.01, off_diagonal_sigma: 0.005, ..Gyro::default() },
        ..Scenario::default()
    };
    let (trace, _) = simulate(&scenario, seed);
    let mut config = configured(&trace);
    // The part's data sheet: 10 deg/s (LSM6DS).
    config.identification.max_bias_rad_s = 10.0_f32.to_radians();
    config.identification.prior_sigma_bias_rad_s = 10.0_f32.to_radians();
    let flight = flown(&trace, &config)?;
    let at_rest = flight.outputs.iter().filter(|output| (15_000_000..20_000_000).contains(&output.t_us));
    let rates = at_rest.map(|output| output.rate_rad_s.iter().map(|x| f64::from(x * x)).sum::<f64>());
    let squares: Vec<f64> = rates.collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    Ok(vec![rms.to_degrees(), seen(&trace, &flight, 20.0).sigmas])
}

fn a_magnet_comes(seed: u64) -> anyhow::Result<Vec<f64>> {
    let mut random = random(seed);
    let size = random.between(3.0, 10.0);
    let offset_ut = random.direction().map(|x| x * size);
    let magnet = HardIronInterval { from_s: 60.0, to_s: 1e3, offset_ut, ramp_s: 0.3 };
    let scenario = Scenario {
        duration_s: 300.0,
        hole: inclined(&mut random),
        effects: Effects { hard_iron_intervals: vec![magnet], ..Effects::default() },
        ..Scenario::default()
    };
    let (trace, _) = simulate(&scenario, seed);
    let flight = flown(&trace, &configured(&trace))?;
    let off = flight.magnets.iter().map(|magnet| (magnet.from_us as f64 * 1e-6 - 60.0).abs());
    Ok(vec![off.fold(f64::INFINITY, f64::min)])
}
