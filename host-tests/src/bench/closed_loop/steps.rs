//! Three axial shocks in a row, each with a step of the gyro's bias.

use meerkat_mwd::Config;
use nalgebra::Vector3;

use crate::bench::effects::trial::drilled;
use testbed::study::{Cell, Effort, Table, rms, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly_frozen},
    simulate::{Random, simulate},
};

/// Shocks are at random in these ranges, and the last diagnosis is at the end of the data, before the first step has
/// become part of the bias.
const SHOCKS_S: [[f64; 2]; 3] = [[38.0, 48.0], [62.0, 72.0], [86.0, 96.0]];
const DURATION_S: f64 = 130.0;

/// Range of the steps, deg/s, and of the shocks, m/s^2: 8 to 16 g, read over a sample.
const STEP_DEG_S: [f64; 2] = [0.25, 0.5];
const SHOCK_M_S2: [f64; 2] = [80.0, 160.0];

/// Time by which a step may be dated wrong, seconds.
const NEAR_S: f64 = 2.0;

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 60_000;

struct Run {
    found: usize,
    /// Steps named at other times.
    others: usize,
    /// Errors of what was found, in stated deviations.
    off: Vec<f64>,
}

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.repetitions(20);
    let runs = each_seed(FIRST_SEED..FIRST_SEED + seeds, run)?;
    let [[least, most], [soft, hard]] = [STEP_DEG_S, SHOCK_M_S2];
    let mut table = Table::new(
        format!(
            "Three axial shocks of {soft} to {hard} m/s^2 with steps of the bias of {least} to {most} deg/s, drilling at 45 deg, {DURATION_S} s: \
             steps that are named within {NEAR_S} s of their shocks, and components of their sizes within one and two stated deviations, % \
             (a normal distribution: 68 and 95)"
        ),
        &[
            "runs",
            "all three named",
            "two",
            "fewer",
            "steps at other times",
            "within one",
            "within two",
            "rms of error over deviation",
        ],
    );
    let off: Vec<f64> = runs.iter().flat_map(|run| &run.off).copied().collect();
    let with = |is: &dyn Fn(usize) -> bool| Cell::number(runs.iter().filter(|run| is(run.found)).count() as f64, 0);
    let within = |deviations: f64| {
        Cell::percent(off.iter().filter(|off| off.abs() <= deviations).count() as f64 / off.len() as f64, 0)
    };
    table.row([
        Cell::number(runs.len() as f64, 0),
        with(&|found| found == 3),
        with(&|found| found == 2),
        with(&|found| found < 2),
        Cell::number(runs.iter().map(|run| run.others).sum::<usize>() as f64, 0),
        within(1.0),
        within(2.0),
        Cell::number(rms(&off), 2),
    ]);
    Ok(table)
}

fn run(seed: u64) -> anyhow::Result<Run> {
    let scenario = drilled(45.0, seed, |scenario, _| {
        (scenario.duration_s, scenario.shocks.per_minute) = (DURATION_S, 0.0);
    })?;
    let (mut trace, truth) = simulate(&scenario, seed);
    let mut random = Random::new(seed ^ 0x0a1a1);
    let steps = SHOCKS_S.map(|[from_s, to_s]| {
        let length = random.between(STEP_DEG_S[0], STEP_DEG_S[1]).to_radians();
        let step = Vector3::from(random.direction().map(|x| x * length));
        (random.between(from_s, to_s), random.sign() * random.between(SHOCK_M_S2[0], SHOCK_M_S2[1]), step)
    });
    for (at_s, shock_m_s2, step) in steps {
        let first = trace.samples.partition_point(|sample| (sample.t_us as f64) * 1e-6 < at_s);
        for (k, sample) in trace.samples.iter_mut().skip(first).enumerate() {
            // The tool comes back: a shock leaves no velocity behind.
            let part = [1.0, -0.25, -0.25, -0.25, -0.25].get(k).copied().unwrap_or(0.0);
            sample.accel_m_s2[2] += (part * shock_m_s2) as f32;
            for (rate, step) in sample.gyro_rad_s.iter_mut().zip(step.iter()) {
                *rate += *step as f32;
            }
        }
    }
    let config = Config { seed, ..of_trace(&trace) };
    let flight = fly_frozen(&config, trace.last_us(), &trace.samples)?;
    let last = flight.diagnoses.iter().rev().find(|report| report.is_conclusive());
    let mut run = Run { found: 0, others: 0, off: Vec::new() };
    for told in last.into_iter().flat_map(|report| report.found()).filter(|told| told.step_us > 0) {
        let at_s = told.step_us as f64 * 1e-6;
        let Some((.., step)) = steps.iter().find(|(s, ..)| (s - at_s).abs() < NEAR_S) else {
            run.others += 1;
            continue;
        };
        run.found += 1;
        let expected = truth.gyro.p_matrix().cast::<f64>() * step;
        let sizes = told.found.parameters.iter().zip(&told.found.sigma).zip(expected.iter());
        run.off.extend(sizes.map(|((size, sigma), truth)| (f64::from(*size) - truth) / f64::from(*sigma)));
    }
    Ok(run)
}
