//! A day of drilling and stops: what outlives the probe's starts.

use super::{completed::Completed, host::Host, plan::Trouble, proportions::Proportions, tally::Tally, truth::Truth};
use meerkat_mwd::{compensation::GyroModel, survey::SurveyReport};
use std::collections::VecDeque;
use testbed::simulate::Random;

/// Surroundings of the probe, which go on whether or not it has power.
pub struct Day {
    pub proportions: &'static Proportions,
    pub random: Random,
    /// Generator of the damage that is aimed at the counter of commands.
    pub aimed: Random,
    pub truth: Truth,
    pub host: Host,
    pub tally: Tally,
    pub plan: VecDeque<(u64, Trouble)>,
    /// Troubles that struck, the last one at the end, with their times.
    pub struck: Vec<(u64, Trouble)>,
    pub bytes_per_s: u32,
    /// Since the power came.
    pub watchdog_resets: u32,
    /// Every P and b that have flown: what is stored is one of them.
    pub flown: Vec<GyroModel>,
    /// Models that a start may restore.
    pub completed: Completed,
    /// Surveys that were heard, each with the start of the program that it is of.
    pub surveys: Vec<(u64, SurveyReport)>,
    /// FNV-1a of every byte that the probe has sent.
    pub digest: u64,
    /// Chip's time of the first attitude on the line since the start, and of the first without a flag.
    pub back_us: [Option<u64>; 2],
}

impl Day {
    /// The next trouble that is due.
    pub fn next_trouble(&mut self, now_us: u64) -> Option<Trouble> {
        let is_due = self.plan.front().is_some_and(|(at_us, _)| *at_us <= now_us);
        is_due.then(|| self.plan.pop_front()).flatten().map(|(_, trouble)| trouble)
    }

    /// The owner asks for a change of calibration then.
    pub fn owner_at(&mut self, at_us: u64) {
        let place = self.plan.partition_point(|(other_us, _)| *other_us <= at_us);
        self.plan.insert(place, (at_us, Trouble::Owner));
    }

    /// Takes note of a byte.
    pub fn digest(&mut self, byte: u8) {
        self.digest = (self.digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
}
