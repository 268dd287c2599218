//! Sections of the bench, each with its name on the command line, its subject and the function that measures it.

use crate::bench::{
    attitude, attitude_cost, benefit, bus, bus_faults, closed_loop, cost, coverage, drilling, effects, honesty, hour,
    mud_pulse, multi_station, power_cuts, rate_error, recordings, replay, second_simulator, sensors, size, swaps,
    sweep, turntable, whole_probe,
};
use research::{contaminated, evaluations, inclination, paper};
use testbed::study::{Effort, Table};

/// One section of the bench.
pub(super) struct Section {
    /// Name on the command line, and of its page.
    pub name: &'static str,
    /// Subject: the headline of its page.
    pub about: &'static str,
    /// Where it runs.
    pub place: Place,
    /// True if it measures on recordings, of which `MWD_RECORDINGS` names the folder.
    pub takes_recordings: bool,
    /// True if it tells of a run by its seed, which `--first-seed` then flies again.
    pub tells_seeds: bool,
    /// Measures, and returns the tables.
    pub run: fn(Effort) -> anyhow::Result<Vec<Table>>,
}

/// Place where a section runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// On this machine.
    Host,
    /// On the emulated chip: with `--target`, which runs nothing else.
    Target,
}

impl Section {
    const fn on_host(name: &'static str, about: &'static str, run: fn(Effort) -> anyhow::Result<Vec<Table>>) -> Self {
        Self { name, about, place: Place::Host, takes_recordings: false, tells_seeds: false, run }
    }

    const fn on_recordings(
        name: &'static str,
        about: &'static str,
        run: fn(Effort) -> anyhow::Result<Vec<Table>>,
    ) -> Self {
        Self { takes_recordings: true, ..Self::on_host(name, about, run) }
    }

    const fn with_told_seeds(
        name: &'static str,
        about: &'static str,
        run: fn(Effort) -> anyhow::Result<Vec<Table>>,
    ) -> Self {
        Self { tells_seeds: true, ..Self::on_host(name, about, run) }
    }

    const fn on_target(name: &'static str, about: &'static str, run: fn(Effort) -> anyhow::Result<Vec<Table>>) -> Self {
        Self { place: Place::Target, ..Self::on_host(name, about, run) }
    }
}

/// All sections, in the order in which they are printed.
pub(super) const SECTIONS: &[Section] = &[
    Section::on_host("rate_error", "Rate error after one window of simulated drilling", rate_error::run),
    Section::on_host("inclination", "Six minutes of the gyro alone with the model of one window", inclination::run),
    Section::on_host("evaluations", "Evaluations that each search needs", evaluations::run),
    Section::on_host("paper", "The paper's experiments beside its printed figures", paper::run),
    Section::on_host("coverage", "Coverage of the reported deviations", coverage::run),
    Section::on_host("contaminated", "Windows of which part of the samples is spoilt", contaminated::run),
    Section::on_host("turntable", "Harm by a window on a turntable", turntable::run),
    Section::on_host("hour", "An hour of drilling", hour::run),
    Section::on_host("swaps", "Harm and missed benefit under random faults and effects", swaps::run),
    Section::on_host("effects", "Effects that nobody declared: what is named, and what it is worth", effects::run),
    Section::on_host("second_simulator", "Effects in the traces of a second simulator", second_simulator::run),
    Section::with_told_seeds("sweep", "Tools drawn whole: hole, motion, sensors and effects", sweep::run),
    Section::on_recordings("closed_loop", "The loop, case by case", closed_loop::run),
    Section::on_recordings("recordings", "Findings on recordings of real sensors", recordings::run),
    Section::on_recordings("benefit", "Share of the attainable benefit that flies", benefit::run),
    Section::on_recordings("attitude", "Attitude on recordings, beside VQF", attitude::run),
    Section::on_host("multi_station", "Azimuths of a run, corrected by all of its stations", multi_station::run),
    Section::on_host("honesty", "Cases that were once wrong in silence", honesty::run),
    Section::on_host("mud_pulse", "Survey words over a channel with bursts", mud_pulse::run),
    Section::on_host("power_cuts", "Power cuts of the storage", power_cuts::run),
    Section::on_host("bus_faults", "Faults of sensors and wires", bus_faults::run),
    Section::on_host("sensors", "Load of the bus", sensors::run),
    Section::on_host("replay", "Speed and memory of a replay", replay::run),
    Section::with_told_seeds("whole_probe", "The whole probe under seeded faults", whole_probe::run),
    Section::on_target("cost", "Cost on the emulated chip", cost::run),
    Section::on_target("size", "Flash, RAM and stack of the firmware, by module", size::run),
    Section::on_target("bus", "Instructions of the sampling path on the emulated chip", bus::run),
    Section::on_host("drilling", "Attitude while drilling, beside VQF", drilling::run),
    Section::on_target("attitude_cost", "Instructions of the attitude filter on the emulated chip", attitude_cost::run),
];
