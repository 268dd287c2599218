//! Seeded schedules of faults of one to three sensors. Over the whole flight an attitude that no flag marks has to be
//! within five of its deviations.

use meerkat_mwd::{Sample, SampleFlags};

use super::{
    cases::{configured, flown, random},
    cell,
    seen::{Unflagged, unflagged},
};
use testbed::simulate::{Gyro, Hole, Random, Rotation, Scenario, simulate};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};

/// Length of a flight, of its rest, and the time in which faults begin, seconds: half a minute of sound drilling is
/// before them and after the longest.
const DURATION_S: f64 = 100.0;
const REST_S: f64 = 15.0;
const BEGIN_S: [f64; 2] = [10.0, 60.0];
/// Shortest and longest fault, and shortest and longest part of one that comes and goes, seconds.
const LASTS_S: [f64; 2] = [0.03, 20.0];
const PART_S: [f64; 2] = [0.03, 3.0];
/// Speeds of rotation that are drawn, rpm; one in five tools slides.
const ROTATES_RPM: [f64; 2] = [15.0, 180.0];
/// Largest errors of the gyro's scale factors and couplings (MPU-9250 PS section 3.1), which the configuration allows.
const SCALE: f64 = 0.03;
const COUPLING: f64 = 0.02;

/// Reading of a faulty sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Nothing; the driver says so.
    Missing,
    /// Its last reading.
    Frozen,
    /// Its full scale, with the sign of the true reading.
    Railed,
    /// A quarter, half, twice or four times the truth, as with another range in its register.
    Scaled,
    /// Two axes exchanged, or the opposite of one.
    Swapped,
    /// Zero on one axis or on all.
    Zero,
}

/// Kinds and their names.
const KINDS: [(Kind, &str); 6] = [
    (Kind::Missing, "missing"),
    (Kind::Frozen, "frozen"),
    (Kind::Railed, "railed"),
    (Kind::Scaled, "scaled by 1/4 to 4"),
    (Kind::Swapped, "axes exchanged or turned round"),
    (Kind::Zero, "zero"),
];
/// Names of the sensors, in the order of a sample.
const SENSORS: [&str; 3] = ["gyro", "accelerometer", "magnetometer"];
const MISSING: [SampleFlags; 3] = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
/// Readings of a railed sensor: 2,000 deg/s, 16 g, 4,900 microtesla.
const RAILS: [f32; 3] = [34.9, 156.9, 4_900.0];

/// Fault of one sensor.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// Index into [`SENSORS`].
    sensor: usize,
    /// Index into [`KINDS`].
    kind: usize,
    from_s: f64,
    to_s: f64,
    /// Time on and time off of a fault that comes and goes, seconds.
    parts_s: Option<[f64; 2]>,
    axis: usize,
    all_axes: bool,
    factor: f32,
    /// Last reading before the fault.
    held: [f32; 3],
}

fn logarithmic(random: &mut Random, [least, most]: [f64; 2]) -> f64 {
    least * (most / least).powf(random.uniform())
}

impl Fault {
    fn draw(random: &mut Random, sensor: usize) -> Self {
        let from_s = random.between(BEGIN_S[0], BEGIN_S[1]);
        let parts_s = (random.uniform() < 0.5).then(|| [(); 2].map(|()| logarithmic(random, PART_S)));
        Self {
            sensor,
            kind: random.index(KINDS.len()),
            from_s,
            to_s: from_s + logarithmic(random, LASTS_S),
            parts_s,
            axis: random.index(3),
            all_axes: random.uniform() < 0.5,
            factor: [0.25, 0.5, 2.0, 4.0][random.index(4)],
            held: [0.0; 3],
        }
    }

    fn is_on(&self, t_s: f64) -> bool {
        let since_s = t_s - self.from_s;
        (0.0..self.to_s - self.from_s).contains(&since_s)
            && self.parts_s.is_none_or(|[on_s, off_s]| since_s % (on_s + off_s) < on_s)
    }

    fn spoil(&mut self, sample: &mut Sample) {
        let is_on = self.is_on(sample.t_us as f64 * 1e-6);
        let (next, last) = ((self.axis + 1) % 3, self.axis);
        let of = |k: usize| self.all_axes || k == self.axis;
        let reading = match self.sensor {
            0 => &mut sample.gyro_rad_s,
            1 => &mut sample.accel_m_s2,
            _ => &mut sample.mag_ut,
        };
        if !is_on {
            self.held = *reading;
            return;
        }
        match KINDS[self.kind].0 {
            Kind::Missing => sample.flags.insert(MISSING[self.sensor]),
            Kind::Frozen => *reading = self.held,
            Kind::Railed => {
                let rail = RAILS[self.sensor];
                reading.iter_mut().enumerate().filter(|(k, _)| of(*k)).for_each(|(_, x)| *x = rail.copysign(*x));
            }
            Kind::Scaled => reading.iter_mut().for_each(|x| *x *= self.factor),
            Kind::Swapped if self.all_axes => reading.swap(last, next),
            Kind::Swapped => reading[last] = -reading[last],
            Kind::Zero => reading.iter_mut().enumerate().filter(|(k, _)| of(*k)).for_each(|(_, x)| *x = 0.0),
        }
    }
}

/// A flight under one schedule.
#[derive(Clone, Debug)]
pub struct Played {
    /// One to three faults, each of another sensor.
    pub faults: Vec<Fault>,
    /// Its attitudes that no flag marks.
    pub seen: Unflagged,
}

impl Played {
    /// Returns true if a sensor reads what a sound one may read in another motion: a gyro another rate than there is,
    /// an accelerometer a gravity from elsewhere.
    #[must_use]
    pub fn looks_sound(&self) -> bool {
        self.faults.iter().any(|fault| match KINDS[fault.kind].0 {
            Kind::Swapped => fault.sensor < 2,
            Kind::Frozen | Kind::Scaled | Kind::Zero => fault.sensor == 0,
            Kind::Missing | Kind::Railed => false,
        })
    }
}

/// Flies the schedule of a seed.
///
/// # Errors
/// The configuration cannot be flown.
pub fn play(seed: u64) -> anyhow::Result<Played> {
    let random = &mut random(seed);
    let rpm = if random.uniform() < 0.2 { 0.0 } else { random.between(ROTATES_RPM[0], ROTATES_RPM[1]) };
    let p = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let [whole, most] = if row == column { [1.0, SCALE] } else { [0.0, COUPLING] };
            whole + random.between(-most, most)
        })
    });
    let scenario = Scenario {
        duration_s: DURATION_S,
        rest_s: REST_S,
        hole: Hole {
            inclination_deg: random.between(0.0, 90.0),
            azimuth_deg: random.between(0.0, 360.0),
            ..Hole::default()
        },
        rotation: Rotation {
            toolface_deg: random.between(0.0, 360.0),
            mean_rpm: rpm,
            stick_slip: random.uniform(),
            ..Rotation::default()
        },
        gyro: Gyro { p: Some(p), ..Gyro::default() },
        ..Scenario::default()
    };
    let (mut trace, _) = simulate(&scenario, seed);
    let mut sensors = vec![0, 1, 2];
    let mut faults: Vec<Fault> = (0..=random.index(3))
        .map(|_| {
            let sensor = sensors.remove(random.index(sensors.len()));
            Fault::draw(random, sensor)
        })
        .collect();
    for sample in &mut trace.samples {
        faults.iter_mut().for_each(|fault| fault.spoil(sample));
    }
    let flight = flown(&trace, &configured(&trace))?;
    Ok(Played { faults, seen: unflagged(&trace, &flight, 0.0) })
}

/// Table of all schedules, and of those in which a sensor or a kind is at fault.
pub(crate) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.seeds(10_000);
    let count = seeds.end - seeds.start;
    let played = each_seed(seeds, play)?;
    let mut table = Table::new(
        format!(
            "{count} schedules of faults of one to three sensors, half of which come and go; a minute and a half of simulated \
             drilling each, at 100 Hz. Attitudes that no flag marks, and those of them that are off by more than five of their stated \
             deviations"
        ),
        &[
            "at fault",
            "flights",
            "with any beyond 5",
            "attitudes without a flag",
            "beyond 5",
            "longest stretch, s",
            "worst, sigmas",
        ],
    );
    let mut add = |name: String, chosen: &dyn Fn(&Played) -> bool| {
        let of: Vec<&Played> = played.iter().filter(|one| chosen(one)).collect();
        let sum = |part: fn(&Unflagged) -> usize| of.iter().map(|one| part(&one.seen)).sum::<usize>() as f64;
        let most = |part: fn(&Unflagged) -> f64| of.iter().map(|one| part(&one.seen)).fold(0.0, f64::max);
        table.row([
            Cell::from(name),
            Cell::number(of.len() as f64, 0),
            Cell::number(sum(|seen| usize::from(seen.beyond > 0)), 0),
            Cell::number(sum(|seen| seen.count), 0),
            Cell::number(sum(|seen| seen.beyond), 0),
            Cell::number(most(|seen| seen.longest_s), 2),
            cell(most(|seen| seen.worst), 1),
        ]);
    };
    add("all".to_owned(), &|_| true);
    for (sensor, of) in SENSORS.iter().enumerate() {
        for (kind, (_, name)) in KINDS.iter().enumerate() {
            let alone =
                |one: &Played| matches!(one.faults[..], [fault] if fault.sensor == sensor && fault.kind == kind);
            add(format!("{of} alone, {name}"), &alone);
        }
    }
    for sensors in [2, 3] {
        add(format!("{sensors} sensors"), &|one| one.faults.len() == sensors);
    }
    add("a gyro frozen, scaled, turned or zero, or an accelerometer turned".to_owned(), &Played::looks_sound);
    add("none of these".to_owned(), &|one| !one.looks_sound());
    Ok(table)
}
