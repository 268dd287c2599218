//! Attitude while drilling, against the simulator's truth, beside VQF's on the same samples.
//!
//! Vector sensors err as the ISCWSA MWD model says, the gyro like one whose twelve parameters have been
//! identified; the configuration says so, and that no sensor is delayed. 30 s of rest are followed by a
//! minute of drilling with vibration and shocks of up to 20 g.

mod tool;

use nalgebra::{Matrix3, UnitQuaternion};

use super::attitude::vqf;
use testbed::study::{Cell, Effort, Table, seeds::each_seed};
use testbed::{flight::fly, simulate::simulate, trace::Trace};
use tool::{REST_S, config, scenario};

/// Time after the start of the rest, and of drilling, from which samples are scored, seconds.
const SETTLED_S: f64 = 5.0;
/// Every how many samples one is scored: errors change over tenths of seconds.
const SCORED: usize = 10;

/// Inclinations, degrees.
const INCLINATIONS_DEG: [f64; 6] = [0.0, 5.0, 15.0, 45.0, 70.0, 90.0];
/// Name and mean speed of rotation.
const ROTATIONS_RPM: [(&str, f64); 5] =
    [("sliding", 0.0), ("30 rpm", 30.0), ("60 rpm", 60.0), ("120 rpm", 120.0), ("180 rpm", 180.0)];
const CELLS: u64 = (INCLINATIONS_DEG.len() * ROTATIONS_RPM.len()) as u64;

/// Inclination below which the magnetic toolface applies, degrees.
const NEAR_VERTICAL_DEG: f64 = 5.5;
/// Inclination from which azimuth is scored, degrees.
const AZIMUTH_FROM_DEG: f64 = 10.0;

const ANGLES: [&str; 3] = ["inclination", "toolface", "azimuth above 10 deg"];

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let each = effort.repetitions(10);
    let runs = each_seed(0..each * CELLS, Run::of)?;
    let title = |what: &str| {
        format!(
            "{what}; {} runs, 0 to 90 deg, 100 Hz, sensor errors at the ISCWSA MWD level, shocks up to 20 g; ours is told the \
             sizes of the sensors' errors, VQF flies with its defaults (targets: inclination 0.10 \
             stationary, 0.25 rotating; toolface 1.5 rotating; azimuth 0.5 stationary)",
            each * CELLS
        )
    };
    let as_it_is = errors(&title("Attitude error, deg rms"), &runs, 0);
    let aligned = errors(&title("Attitude error without one constant heading offset for each run, deg rms"), &runs, 1);
    Ok(vec![as_it_is, aligned, by_inclination(&runs), shares(&runs)])
}

fn errors(title: &str, runs: &[Run], variant: usize) -> Table {
    let heads = ANGLES.iter().flat_map(|angle| [format!("{angle}: ours"), "VQF".to_owned()]);
    let heads: Vec<String> = [String::new()].into_iter().chain(heads).collect();
    let mut table = Table::new(title, &heads.iter().map(String::as_str).collect::<Vec<_>>());
    for (name, chosen) in phases() {
        table.row([Cell::from(name)].into_iter().chain(cells(runs, variant, &chosen)));
    }
    table
}

fn by_inclination(runs: &[Run]) -> Table {
    let heads = ["rotating at", "inclination: ours", "VQF", "toolface: ours", "VQF", "azimuth: ours", "VQF"];
    let mut table = Table::new("Attitude error while rotating, by inclination, as it is, deg rms", &heads);
    for inclination_deg in INCLINATIONS_DEG {
        let chosen: Chosen =
            Box::new(move |run, phase| phase == 1 && run.rpm > 0.0 && run.inclination_deg == inclination_deg);
        table.row([Cell::from(format!("{inclination_deg} deg"))].into_iter().chain(cells(runs, 0, &chosen)));
    }
    table
}

fn shares(runs: &[Run]) -> Table {
    let heads: Vec<&str> = [""].into_iter().chain(ANGLES).collect();
    let mut table = Table::new("Share of errors within one stated sigma, as they are, % (target: 60 to 76)", &heads);
    let all: (String, Chosen) = ("all".to_owned(), Box::new(|_, _| true));
    for (name, chosen) in phases().into_iter().chain([all]) {
        let pooled = pool(runs, 0, 0, &chosen);
        let share = |k: usize| Cell::percent(f64::from(pooled.within[k]) / f64::from(pooled.count[k]), 0);
        table.row([Cell::from(name)].into_iter().chain((0..3).map(share)));
    }
    table
}

/// Chooses runs and phases (0 rest, 1 drilling) for a cell.
type Chosen = Box<dyn Fn(&Run, usize) -> bool>;

fn phases() -> Vec<(String, Chosen)> {
    let rest: (String, Chosen) = ("stationary".to_owned(), Box::new(|_, phase| phase == 0));
    let drilling = ROTATIONS_RPM.iter().map(|&(name, rpm)| -> (String, Chosen) {
        (name.to_owned(), Box::new(move |run, phase| phase == 1 && run.rpm == rpm))
    });
    let rotating: (String, Chosen) = ("all rotating".to_owned(), Box::new(|run, phase| phase == 1 && run.rpm > 0.0));
    [rest].into_iter().chain(drilling).chain([rotating]).collect()
}

fn cells(runs: &[Run], variant: usize, chosen: &Chosen) -> Vec<Cell> {
    let both = [pool(runs, 0, variant, chosen), pool(runs, 1, variant, chosen)];
    (0..3).flat_map(|k| both.iter().map(move |sums| Cell::number(sums.rms_deg(k), 2)).collect::<Vec<_>>()).collect()
}

fn pool(runs: &[Run], estimator: usize, variant: usize, chosen: &Chosen) -> Sums {
    let mut pooled = Sums::default();
    for run in runs {
        for phase in (0..2).filter(|phase| chosen(run, *phase)) {
            pooled.add(&run.sums[estimator][variant][phase]);
        }
    }
    pooled
}

/// Sums over samples, for each angle.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    squares: [f64; 3],
    within: [u32; 3],
    count: [u32; 3],
}

impl Sums {
    fn take(&mut self, angle: usize, error_rad: f64, sigma_rad: f64) {
        self.squares[angle] += error_rad * error_rad;
        self.within[angle] += u32::from(error_rad.abs() <= sigma_rad);
        self.count[angle] += 1;
    }

    fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.squares[k] += other.squares[k];
            self.within[k] += other.within[k];
            self.count[k] += other.count[k];
        }
    }

    fn rms_deg(&self, angle: usize) -> f64 {
        (self.squares[angle] / f64::from(self.count[angle])).sqrt().to_degrees()
    }
}

/// Sums of one run: this project's and VQF's, as it is and without a constant heading offset, at rest and
/// drilling.
struct Run {
    inclination_deg: f64,
    rpm: f64,
    sums: [[[Sums; 2]; 2]; 2],
}

/// An estimate of one sample: body to NED, and sigmas of the three angles, radians.
type Estimate = ([f64; 4], [f64; 3]);

impl Run {
    fn of(seed: u64) -> anyhow::Result<Self> {
        let cell = (seed % CELLS) as usize;
        let inclination_deg = INCLINATIONS_DEG[cell % INCLINATIONS_DEG.len()];
        let rpm = ROTATIONS_RPM[cell / INCLINATIONS_DEG.len()].1;
        let (trace, _) = simulate(&scenario(inclination_deg, rpm, seed), seed);
        let flight = fly(&config(&trace), &trace.samples, |_| {})?;
        let ours: Vec<Option<Estimate>> = (flight.outputs.iter())
            .map(|output| {
                let a = output.attitude.as_ref()?;
                let sigmas = [a.sigma_inclination_rad, a.sigma_toolface_rad, a.sigma_azimuth_rad];
                Some((a.q.map(f64::from), sigmas.map(f64::from)))
            })
            .collect();
        let theirs: Vec<Option<Estimate>> = vqf(&trace).into_iter().map(|(_, q)| Some((q, [f64::NAN; 3]))).collect();
        Ok(Self { inclination_deg, rpm, sums: [score(&trace, &ours), score(&trace, &theirs)] })
    }
}

fn score(trace: &Trace, estimates: &[Option<Estimate>]) -> [[Sums; 2]; 2] {
    let first_us = trace.first_us();
    let scored: Vec<(usize, [f64; 4], Estimate)> = (trace.samples.iter().zip(&trace.reference).zip(estimates))
        .step_by(SCORED)
        .filter_map(|((sample, reference), estimate)| {
            let t_s = (sample.t_us - first_us) as f64 * 1e-6;
            let phase = usize::from(t_s >= REST_S);
            let settled = t_s >= SETTLED_S && (phase == 0 || t_s >= REST_S + SETTLED_S);
            settled.then_some((phase, (*reference)?, (*estimate)?))
        })
        .collect();
    let (sine, cosine) = scored.iter().fold((0.0, 0.0), |(sine, cosine), (_, reference, (q, _))| {
        let error = rotation(q) * rotation(reference).inverse();
        let heading = 2.0 * error.k.atan2(error.w);
        (sine + heading.sin(), cosine + heading.cos())
    });
    [0.0, f64::atan2(sine, cosine)].map(|offset_rad| {
        let mut sums = [Sums::default(); 2];
        for (phase, reference, (q, sigmas)) in &scored {
            let (truth, found) = (Angles::of(reference), Angles::of(q));
            let sums = &mut sums[*phase];
            sums.take(0, found.inclination - truth.inclination, sigmas[0]);
            let inclination_deg = truth.inclination.to_degrees();
            if inclination_deg < NEAR_VERTICAL_DEG {
                sums.take(1, apart(found.magnetic_toolface - offset_rad, truth.magnetic_toolface), sigmas[1]);
            } else {
                sums.take(1, apart(found.gravity_toolface, truth.gravity_toolface), sigmas[1]);
            }
            if inclination_deg > AZIMUTH_FROM_DEG {
                sums.take(2, apart(found.azimuth - offset_rad, truth.azimuth), sigmas[2]);
            }
        }
        sums
    })
}

/// Tool angles, radians, of `C = Rz(azimuth) Ry(inclination) Rz(toolface)`.
struct Angles {
    inclination: f64,
    azimuth: f64,
    gravity_toolface: f64,
    magnetic_toolface: f64,
}

impl Angles {
    fn of(q: &[f64; 4]) -> Self {
        let c: Matrix3<f64> = *rotation(q).to_rotation_matrix().matrix();
        Self {
            inclination: c.m31.hypot(c.m32).atan2(c.m33),
            azimuth: c.m23.atan2(c.m13),
            gravity_toolface: c.m32.atan2(-c.m31),
            magnetic_toolface: (c.m21 - c.m12).atan2(c.m11 + c.m22),
        }
    }
}

fn rotation([w, x, y, z]: &[f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(*w, *x, *y, *z))
}

fn apart(a: f64, b: f64) -> f64 {
    libm::remainder(a - b, std::f64::consts::TAU)
}
