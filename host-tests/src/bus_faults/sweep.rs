//! Sweep of a kind of fault over every transaction.

use super::{
    Case, Judgement, Kind, Motion, Run, attitude, judge,
    kinds::{Fault, Part, cases},
    run,
};
use meerkat_mwd::{Sample, SampleFlags, emulation::BusFault};

/// Results of all runs of a kind of fault.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Number of runs.
    pub runs: usize,
    /// Runs whose samples equal those of a run without a fault, bit for bit.
    pub without_effect: usize,
    /// Runs with a wrong sample that nothing flags, apart from a single sample whose payload the wire has
    /// spoilt.
    pub wrong_runs: usize,
    /// Most such samples in one run.
    pub wrong_samples: usize,
    /// Largest error of such a sample, as a multiple of the noise.
    pub wrong_noises: f64,
    /// Runs whose readings did not all become good again.
    pub not_recovered: usize,
    /// Runs whose samples changed while nothing reported a fault.
    pub silent: usize,
    /// Runs in which the wire spoilt one sample's payload by less than the innovation limit.
    pub spoilt_payloads: usize,
    /// Longest time from a fault to its first sign, microseconds.
    pub detection_us: u64,
    /// Longest time from the end of a fault to good samples, microseconds.
    pub recovery_us: u64,
    /// The case with that longest time.
    pub slowest: Option<Case>,
    /// Largest attitude error that such a sample made, degrees.
    pub attitude_deg: f64,
    /// The worst case, for a closer look.
    pub worst: Option<Case>,
}

/// Runs a kind of fault at every `stride`-th transaction with a part in the first two seconds, on the bus of
/// the run without a fault.
#[must_use]
pub fn sweep(motion: &Motion, clean: &Run, part: Part, kind: &Kind, stride: usize) -> Outcome {
    let transactions = clean.transactions[usize::from(part == Part::Rm3100)];
    let all = cases(kind, part, transactions);
    let cases: Vec<Case> =
        all.into_iter().filter(|case| (case.at_transaction as usize).is_multiple_of(stride)).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let sound = Sound {
        motion,
        clean,
        flown: attitude::fly(motion, &clean.samples),
        alarms: judge(motion, clean, 0, &[]).flagged,
    };
    let parts: Vec<Outcome> = std::thread::scope(|scope| {
        let sound = &sound;
        let workers: Vec<_> = (0..threads)
            .map(|worker| {
                let cases = cases.iter().skip(worker).step_by(threads);
                scope.spawn(move || cases.fold(Outcome::default(), |outcome, case| outcome.with(sound, case)))
            })
            .collect();
        workers.into_iter().filter_map(|worker| worker.join().ok()).collect()
    });
    // If a worker panicked its runs are missing, and the count shows it.
    parts.into_iter().fold(Outcome::default(), Outcome::and)
}

/// Faults strike from the start up to this time, microseconds.
pub const STRIKES_UNTIL_US: u64 = 2_000_000;
/// Time after a fault within which a sign of trouble counts as its sign, microseconds.
const NOTICED_WITHIN_US: u64 = 100_000;
/// Length of a run, microseconds: leaves time for the slowest recovery.
pub const RUN_US: u64 = 2_800_000;

/// The run without a fault, to compare with.
struct Sound<'a> {
    motion: &'a Motion,
    clean: &'a Run,
    flown: attitude::Flown,
    alarms: Vec<u64>,
}

impl Outcome {
    fn with(mut self, sound: &Sound<'_>, case: &Case) -> Self {
        let Sound { motion, clean, alarms, .. } = sound;
        let run = run(motion, clean.bus, Some(case));
        let Some(struck_us) = run.struck_us.filter(|struck_us| *struck_us <= STRIKES_UNTIL_US) else { return self };
        self.runs += 1;
        if run.samples == clean.samples {
            self.without_effect += 1;
            return self;
        }
        let over_us = struck_us + case.lasting_us;
        let judgement = judge(motion, &run, over_us, alarms);
        // A later sign is a false alarm.
        match run.noticed_us.filter(|noticed_us| *noticed_us < over_us + NOTICED_WITHIN_US) {
            Some(noticed_us) => self.detection_us = self.detection_us.max(noticed_us - struck_us),
            None => self.silent += 1,
        }
        match judgement.well_from_us {
            Some(well_us) if well_us.saturating_sub(over_us) > self.recovery_us => {
                (self.recovery_us, self.slowest) = (well_us - over_us, Some(*case));
            }
            Some(_) => {}
            None => self.not_recovered += 1,
        }
        self.weigh_wrong(sound, &run, &judgement, case);
        self
    }

    fn weigh_wrong(&mut self, sound: &Sound<'_>, run: &Run, judgement: &Judgement, case: &Case) {
        let on_the_wire = matches!(case.fault, Fault::Wire(BusFault::BitFlip { .. } | BusFault::ShortRead { .. }));
        if on_the_wire && let Some(believed) = one_payload(run, sound.clean) {
            if believed {
                self.spoilt_payloads += 1;
                let effect_deg = attitude::difference_deg(&attitude::fly(sound.motion, &run.samples), &sound.flown);
                if effect_deg > self.attitude_deg {
                    (self.attitude_deg, self.worst) = (effect_deg, Some(*case));
                }
            }
        } else if !judgement.wrong.is_empty() {
            self.wrong_runs += 1;
            if judgement.wrong.len() > self.wrong_samples {
                self.worst = Some(*case);
            }
            self.wrong_samples = self.wrong_samples.max(judgement.wrong.len());
            self.wrong_noises =
                judgement.wrong.iter().fold(self.wrong_noises, |most, (_, _, noises)| most.max(*noises));
        }
    }

    fn and(self, other: Self) -> Self {
        let first = (self.wrong_samples, self.attitude_deg) >= (other.wrong_samples, other.attitude_deg);
        Self {
            runs: self.runs + other.runs,
            without_effect: self.without_effect + other.without_effect,
            wrong_runs: self.wrong_runs + other.wrong_runs,
            wrong_samples: self.wrong_samples.max(other.wrong_samples),
            wrong_noises: self.wrong_noises.max(other.wrong_noises),
            not_recovered: self.not_recovered + other.not_recovered,
            silent: self.silent + other.silent,
            spoilt_payloads: self.spoilt_payloads + other.spoilt_payloads,
            detection_us: self.detection_us.max(other.detection_us),
            recovery_us: self.recovery_us.max(other.recovery_us),
            slowest: if self.recovery_us >= other.recovery_us { self.slowest } else { other.slowest },
            attitude_deg: self.attitude_deg.max(other.attitude_deg),
            worst: if first { self.worst.or(other.worst) } else { other.worst.or(self.worst) },
        }
    }
}

/// Judgement of a fault that spoilt only one reading's payload: true if that reading changed and is believed. `None`
/// unless every sample equals that of the run without a fault, apart from flagged ones and one reading.
fn one_payload(run: &Run, clean: &Run) -> Option<bool> {
    let pairs = || run.samples.iter().zip(&clean.samples).map(|((_, a), (_, b))| (a, b));
    let same_times = run.samples.len() == clean.samples.len() && pairs().all(|(a, b)| a.t_us.abs_diff(b.t_us) < 1_000);
    let readings = |sample: &Sample| {
        [
            (sample.gyro_rad_s, SampleFlags::GYRO_MISSING),
            (sample.accel_m_s2, SampleFlags::ACCEL_MISSING),
            (sample.mag_ut, SampleFlags::MAG_MISSING),
        ]
        .map(|(reading, missing)| (!sample.flags.contains(missing)).then_some(reading))
    };
    let believed = |a: &Sample, b: &Sample| readings(a).iter().zip(readings(b)).any(|(a, b)| a.is_some() && *a != b);
    match pairs().filter(|(a, b)| believed(a, b)).count() {
        _ if !same_times => None,
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}
