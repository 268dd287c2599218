//! Forward filter that identifies P and b beside the errors of the accelerometer and the magnetometer: a square root of
//! the information on all of them, updated at a node every half second, without stored samples. Its posterior says what
//! may fly, and how well that is known.
//!
//! Samples become increments (`increment`), these are pre-integrated from node to node (`preintegration`), a node's
//! rows (`rows`) are taken into the root (`globals`), and from the root comes the posterior (`averaging`,
//! `posterior`) whenever it is asked for.

mod alignment;
mod attitude;
mod averaging;
mod candidates;
mod closing;
pub mod columns;
mod consistency;
mod course;
mod disagreement;
mod drift;
mod eigen;
#[cfg(feature = "explanation")]
mod explanation;
mod field_norm;
mod filter;
mod gate;
mod gaussian;
mod globals;
mod gyro_matrix;
mod increment;
mod intake;
mod learnt;
mod left_over;
mod neighbours;
mod node;
mod node_end;
mod parameters;
mod pointing;
mod posterior;
mod preintegration;
mod prior;
mod reading;
mod refusal;
mod remainder;
mod rest;
mod rows;
mod settings;
mod share;
mod square_root;
mod unrolled;
mod taken_out;
mod update;
mod waiting;
mod walk;
mod widths;
mod window_cost;

pub use attitude::KnownAttitude;
pub use candidates::{CandidateId, CandidateSet, Claim, EFFECTS, MAX_CANDIDATES, MAX_CLAIMED};
pub use drift::P_DRIFT;
#[cfg(feature = "explanation")]
pub use explanation::{MovedByRows, WidthEvidence};
pub use learnt::{Learnt, LearntHead, NUMBERS, NotContinued};
pub use left_over::WINDOW_NODES;
pub use posterior::Posterior;
pub(crate) use posterior::turned_back;
pub use real::Real;
pub use refusal::Refusal;
pub use remainder::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub use settings::{Noise, Settings};
pub use widths::Widths;
pub use window_cost::WindowCost;

use crate::{
    algebra::real,
    compensation::{ActiveEffects, Effect, GyroModel, Snapshot, Theta},
    sample::Reading,
};
use closing::Closing;
use filter::Filter;
use heapless::Vec;
use increment::{Increment, Item};
use intake::Intake;
use node_end::NodeEnd;

/// Cycles of a Cortex-M4F that a unit of work stands for: no piece takes more than its units of them
/// (`cargo mwd bench --target --only cost`).
pub const UNIT_CYCLES: u32 = 500;
/// Work units of an increment and of a node's end: the largest cost of each that a flight has shown, in cycles, over
/// [`UNIT_CYCLES`].
const INCREMENT_UNITS: u32 = 60;
const NODE_UNITS: u32 = 340;

/// The filter, in `f32` on the chip, with the rows of the last `NODES` nodes of motion for the search. All zero bytes
/// before [`Estimator::configure`].
pub struct Estimator<T = f32, const NODES: usize = WINDOW_NODES, const E: usize = EFFECTS> {
    intake: Intake<T>,
    filter: Filter<T, NODES, E>,
    closing: Closing<T>,
    // Not an `Option`: it would not be all zero bytes.
    known_attitude: Vec<KnownAttitude, 1>,
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Before its configuration.
    #[must_use]
    pub const fn zero() -> Self {
        Self { intake: Intake::zero(), filter: Filter::zero(), closing: Closing::zero(), known_attitude: Vec::new() }
    }

    /// Sets the configuration and starts afresh.
    pub fn configure(&mut self, settings: &Settings, library: &'static [&'static dyn Effect]) {
        self.intake.start(settings);
        self.filter.configure(settings, library);
        self.closing.begin();
        self.closing.expect_another();
        self.known_attitude.clear();
    }

    /// Starts about a stored model with its deviations: P's prior is about the model's P, as wide as that was known and
    /// may have drifted. The bias is another one at every start, and is as unknown as without the model. The effects
    /// that were taken out still are. If the samples contradict the model, it is forgotten.
    pub fn restore(&mut self, model: &GyroModel, deviations: &Theta, effects: &ActiveEffects) {
        self.filter.restore(model, deviations, effects);
    }

    /// Takes one sample: raw rate, rad/s; specific force, m/s^2, and field, microtesla, calibrated; temperature over
    /// the effects' reference temperature, K. Time must increase. Returns true if an increment ends with it: then
    /// [`Estimator::look`] can ask for the attitude.
    pub fn push(&mut self, t_us: u64, [rate, force, field]: [Reading; 3], warming_k: Option<f32>) -> bool {
        self.intake.push(t_us, [rate, force, field], warming_k)
    }

    /// Announces seconds before the next sample that the samples' times do not show: a clock stood still.
    pub const fn wait(&mut self, seconds: f32) {
        self.intake.wait(seconds);
    }

    /// Sets the flown model, with which rotations are composed: it changes at instants of the samples' own time.
    pub fn compose_with(&mut self, model: &GyroModel) {
        self.intake.compose_with(model);
    }

    /// Asks for the posterior of all samples so far. It is there once [`Estimator::step`] has worked up to here, and
    /// until then there is none. `is_searched`: true if the cost of a search about it is wanted too, see
    /// [`Estimator::window_cost`].
    pub fn close(&mut self, is_searched: bool) {
        let number = self.closing.expect_another();
        self.intake.ask(Item::Close { is_searched, number });
    }

    /// Has the filter forget the probe's own hard iron, and the earth's field with it, at the end of the node: from
    /// about the last sample on it is another. Returns false if there is no room for the request now.
    pub fn forget_iron(&mut self) -> bool {
        let has_room = self.intake.has_room();
        if has_room {
            self.intake.ask(Item::IronChanged);
        }
        has_room
    }

    /// Returns the posterior that the last [`Estimator::close`] asked for, once it is done.
    #[must_use]
    pub fn posterior(&self) -> Option<&Posterior> {
        self.closing.posterior()
    }

    /// Does one bounded piece of work; returns its size in units of [`UNIT_CYCLES`], 0 when there is nothing to do.
    // Rare calls are not inlined: their stack frames would lie under all others.
    pub fn step(&mut self) -> u32 {
        if self.filter.task != filter::Task::Idle {
            return self.filter.step();
        }
        if self.closing.is_busy() {
            return self.closing.step(&mut self.filter);
        }
        match self.intake.pop() {
            None => 0,
            Some(Item::Increment(increment)) => {
                let units = self.take(Some(&increment));
                self.filter.course.neighbours.hold(increment);
                units
            }
            Some(Item::Gap { seconds, silent_s }) => {
                let units = self.take(None);
                let Filter { shares, pre, task, .. } = &mut self.filter;
                if silent_s < seconds * T::of(0.5) {
                    // Samples came without a usable rate: the gap is the gyro's, and so is a node that it cuts short.
                    let cut_s = if *task == filter::Task::Idle { pre.seconds } else { T::ZERO };
                    shares.unread.add(T::ONE, seconds - silent_s + cut_s);
                }
                self.filter.gap(seconds);
                units
            }
            Some(Item::Look) => {
                self.known_attitude.clear();
                // Just emptied, so there is room.
                let _ = self.filter.attitude().map(|known| self.known_attitude.push(known));
                INCREMENT_UNITS
            }
            Some(Item::IronChanged) => {
                self.filter.course.iron_has_changed = true;
                INCREMENT_UNITS
            }
            Some(Item::Close { is_searched, number }) => {
                self.closing.ask(is_searched, number);
                // Before the attitude is aligned anew, the globals have not walked through a gap yet.
                if self.filter.course.unwalked_s >= T::of(walk::EVERY_S) {
                    self.filter.task = filter::Task::AddingNoise(0);
                }
                INCREMENT_UNITS
            }
        }
    }

    /// Gives the increment that waits for its successor to the filter; returns the work's units.
    fn take(&mut self, next: Option<&Increment<T>>) -> u32 {
        let Some(held) = self.filter.course.neighbours.take() else { return INCREMENT_UNITS };
        match self.filter.take(&held, next, self.intake.increment_s()) {
            NodeEnd::NotYet => return INCREMENT_UNITS,
            NodeEnd::Ended => (),
            NodeEnd::BegunAnew => self.closing.begin(),
        }
        INCREMENT_UNITS + NODE_UNITS
    }

    /// Effects that the evidence shows, as of the last posterior.
    #[must_use]
    pub fn claims(&self) -> &[Claim] {
        &self.filter.evidence.account.claims
    }

    /// Log Bayes factors of the candidates beside those that are claimed: the library's effects, then further steps of
    /// the bias.
    #[must_use]
    pub const fn tried(&self) -> &[f32; MAX_CANDIDATES] {
        &self.filter.evidence.choice.tried
    }

    /// Returns the number of candidates that were tried.
    #[must_use]
    pub fn candidates(&self) -> u8 {
        self.filter.candidates.named_count() as u8
    }

    /// The effects that are looked for.
    #[must_use]
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.filter.candidates.library()
    }

    /// Norm of the field at the start, microtesla.
    #[must_use]
    pub fn field_ut(&self) -> f32 {
        self.filter.course.field_unit.narrow()
    }

    /// NIS of all nodes of motion up to the last posterior, mean squared innovation over its degrees of freedom: first
    /// with neither nuisances nor effects, then with the claims.
    #[must_use]
    pub const fn nis_of_claims(&self) -> [f32; 2] {
        self.closing.nis_of_claims()
    }

    /// Returns the quantities that the field's innovations go with since [`Estimator::start_remainder`].
    #[must_use]
    pub fn remainder(&self) -> RemainderReport {
        self.filter.remainder.report()
    }

    /// Returns true if the innovations hold more than noise and the claims, or an error that the library has no name
    /// for.
    #[must_use]
    pub fn is_unexplained(&self) -> bool {
        let [_, nis] = self.nis_of_claims();
        let is_large = nis > consistency::DIVERGED || self.filter.remainder.is_contradicted();
        is_large || self.filter.evidence.choice.is_unnamed || !self.filter.remainder.report().is_white()
    }

    /// Begins a new remainder with the innovations to come.
    pub fn start_remainder(&mut self) {
        self.filter.was_unexplained = self.is_unexplained();
        self.filter.remainder.start();
    }

    /// Increments that were lost because [`Estimator::step`] was called too seldom.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.intake.lost()
    }

    /// Seconds of motion since the start.
    #[must_use]
    pub fn motion_s(&self) -> f32 {
        self.filter.course.motion_s.narrow()
    }

    /// When the probe was last at rest, microseconds; `None` before the first rest.
    #[must_use]
    pub fn last_rest_us(&self) -> Option<u64> {
        Some(self.filter.rests.latest_us).filter(|us| *us > 0)
    }

    /// Readings of the latest rest, without field: first without force, too, then with it; zero before the first.
    pub(crate) fn still(&self) -> [Snapshot; 2] {
        [self.filter.rests.still(), self.filter.rests.read()]
    }

    /// Returns the number of the last `seconds`, at most 64, that were at rest.
    #[must_use]
    pub fn rest_seconds(&self, seconds: u32) -> u32 {
        self.filter.rests.seconds(seconds)
    }
}

#[cfg(test)]
mod tests;
