//! Counts of a run: troubles, checks and what did not hold.

use super::plan::KINDS;
use serde::{Deserialize, Serialize};

/// Requirements that have to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Violation {
    /// Every sample is flown once, or counted as lost.
    SampleLost,
    /// A stationary survey is of a rest, says the tool's inclination, and is on the line in time.
    Survey,
    /// A stationary survey leaves within a second of its end.
    LateSurvey,
    /// A survey that is said again is the one that was said, with its times.
    SurveyAgain,
    /// The counter of commands never falls.
    CounterFell,
    /// A command of the owner is carried out once.
    Replayed,
    /// Nobody else's is that needs the key.
    Forged,
    /// Calibration is not changed while drilling.
    ChangedWhileDrilling,
    /// Nothing is erased while drilling, but before the first sample of a start.
    ErasedWhileDrilling,
    /// The model that is restored was completed.
    ModelNotCompleted,
    /// The owner's settings hold after a start.
    SettingsLost,
    /// Flash that can be read is used.
    StorageRefused,
    /// An attitude without a flag is within five of its deviations.
    Attitude,
    /// The watchdog resets a stage that hangs, and nothing else.
    WatchdogReset,
    /// A probe with power and sound sensors says its attitude.
    Silent,
    /// The program takes no more memory than is set aside for it.
    Ram,
    /// Nothing panics.
    Panic,
}

/// All, with their names.
pub const VIOLATIONS: [(Violation, &str); 17] = [
    (Violation::SampleLost, "every sample is flown once, or counted as lost"),
    (Violation::Survey, "a survey is of a rest and within 5 sigma"),
    (Violation::LateSurvey, "a survey is on the line a second after its end"),
    (Violation::SurveyAgain, "a survey that is said again is the one that was said, with its time"),
    (Violation::CounterFell, "the counter of commands never falls"),
    (Violation::Replayed, "a command of the owner is carried out once"),
    (Violation::Forged, "nobody else's command is, that needs the key"),
    (Violation::ChangedWhileDrilling, "calibration is not changed while drilling"),
    (Violation::ErasedWhileDrilling, "nothing is erased while drilling, but before the first sample of a start"),
    (Violation::ModelNotCompleted, "the model that is restored was completed"),
    (Violation::SettingsLost, "what the owner has set holds after a start"),
    (Violation::StorageRefused, "a flash that can be read is used"),
    (Violation::Attitude, "an attitude without a flag is within 5 sigma, 30 s after start and faults"),
    (Violation::WatchdogReset, "the watchdog resets a stage that hangs, and nothing else"),
    (Violation::Silent, "attitude is back 3 s after the start"),
    (Violation::Ram, "the stack stays within its limit"),
    (Violation::Panic, "nothing panics"),
];

/// Counts of one run, or of many.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Troubles that struck, by kind.
    pub troubles: [u64; KINDS.len()],
    /// Checks made, in the order of [`VIOLATIONS`].
    pub checks: [u64; VIOLATIONS.len()],
    /// Those that did not hold, in the same order.
    pub violations: [u64; VIOLATIONS.len()],
    /// Attitudes without a flag that came before they had to be within their deviations, and those that were not.
    pub soon: [u64; 2],
    /// Angles of surveys in the 30 s after a fault while an effect is taken out, and those beyond their deviations.
    pub misled: [u64; 2],
    /// Commands of the owner.
    pub commands: u64,
    /// Starts of the program.
    pub starts: u64,
    /// Samples that were read.
    pub samples: u64,
    /// Number of these that were lost and counted.
    pub lost: u64,
    /// Results that newer ones pushed out before they found room.
    pub results_lost: u64,
    /// Most bytes of stack at a call of the board.
    pub stack: u64,
    /// Models stored.
    pub models: u64,
    /// Models restored.
    pub restored: u64,
    /// Longest time from a start to its end, microseconds.
    pub longest_us: u64,
    /// Frames that the host sent.
    pub frames: u64,
    /// Most erasures of a sector.
    pub erasures: u64,
    /// Time of the chip, for words, microseconds.
    pub now_us: u64,
    /// Most samples that waited.
    pub queue: u64,
    /// Seconds from a start to the first attitude on the line, while drilling and at rest; and to the first one without
    /// a flag.
    pub back_s: [Vec<f64>; 3],
    /// First violation in words, with its time.
    pub first: Option<String>,
}

impl Tally {
    /// Counts a check.
    pub fn checked(&mut self, what: Violation) {
        self.checks[what as usize] += 1;
    }

    /// Counts what does not hold, and keeps the first of it in words.
    pub fn violated(&mut self, what: Violation, words: impl FnOnce() -> String) {
        self.violations[what as usize] += 1;
        self.first.get_or_insert_with(|| format!("{:.3} s: {what:?}: {}", self.now_us as f64 * 1e-6, words()));
    }

    /// Adds another run.
    pub fn add(&mut self, other: &Self) {
        let sums = [
            (&mut self.troubles[..], &other.troubles[..]),
            (&mut self.checks[..], &other.checks[..]),
            (&mut self.violations[..], &other.violations[..]),
            (&mut self.soon[..], &other.soon[..]),
            (&mut self.misled[..], &other.misled[..]),
        ];
        for (sums, others) in sums {
            sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
        }
        self.commands += other.commands;
        self.starts += other.starts;
        self.samples += other.samples;
        self.lost += other.lost;
        self.results_lost += other.results_lost;
        self.stack = self.stack.max(other.stack);
        self.models += other.models;
        self.restored += other.restored;
        self.queue = self.queue.max(other.queue);
        self.longest_us = self.longest_us.max(other.longest_us);
        self.frames = self.frames.max(other.frames);
        self.erasures = self.erasures.max(other.erasures);
        for (all, more) in self.back_s.iter_mut().zip(&other.back_s) {
            all.extend(more);
        }
    }

    /// Number of all that did not hold.
    pub fn all_violations(&self) -> u64 {
        self.violations.iter().sum()
    }
}
