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
pub mod columns;
mod consistency;
mod course;
mod disagreement;
mod drift;
mod eigen;
#[cfg(feature = "explanation")]
mod explanation;
mod field_norm;
mod gate;
mod gaussian;
mod globals;
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
mod work;

pub use attitude::KnownAttitude;
pub use candidates::{CandidateId, CandidateSet, Claim, EFFECTS, MAX_CANDIDATES, MAX_CLAIMED};
pub use drift::P_DRIFT;
#[cfg(feature = "explanation")]
pub use explanation::{MovedByRows, WidthEvidence};
pub use learnt::{Learnt, LearntHead, NUMBERS, NotContinued};
pub use left_over::WINDOW_NODES;
pub use posterior::Posterior;
pub use real::Real;
pub use refusal::Refusal;
pub use remainder::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub use settings::{Noise, Settings};
pub use widths::Widths;
pub use window_cost::WindowCost;
pub use work::UNIT_CYCLES;

use crate::{
    algebra::real::{self, V3, zero3},
    compensation::{ActiveEffects, Effect, GyroModel, Theta},
    sample::Reading,
};
use averaging::Averaging;
use candidates::{Candidates, evidence::Evidence};
use course::Course;
use globals::Globals;
use heapless::Vec;
use increment::Item;
use intake::Intake;
use left_over::LeftOver;
use node::{Kind, Node};
use parameters::Parameters;
use preintegration::Preintegration;
use prior::Prior;
use remainder::Remainder;
use rest::Rests;
use rows::SCRATCH;
use share::Shares;
use update::Update;
use window_cost::Centre;
use work::Task;

/// The filter, in `f32` on the chip, with the rows of the last `NODES` nodes of motion for the search. All zero bytes
/// before [`Estimator::configure`].
pub struct Estimator<T = f32, const NODES: usize = WINDOW_NODES, const E: usize = EFFECTS> {
    settings: Settings,
    prior: Prior<T>,
    intake: Intake<T>,
    task: Task,
    course: Course<T>,
    /// Mean of the bias's prior, rad/s, raw frame.
    bias: V3<T>,
    parameters: Parameters<T>,
    pre: Preintegration<T>,
    rests: Rests<T>,
    kind: Kind,
    node: Node<T>,
    update: Update<T>,
    candidates: Candidates<T, E>,
    /// The effects' part of an update's rows.
    further: [[T; E]; SCRATCH],
    evidence: Evidence<T>,
    remainder: Remainder,
    /// True if more than noise was left at the end of the window before.
    was_unexplained: bool,
    globals: Globals<T>,
    /// Number of changes of the globals.
    updates: u32,
    averaging: Averaging<T>,
    /// True if a search follows the averaging in progress.
    is_searched: bool,
    left_over: LeftOver<NODES>,
    // Not `Option`s: these would not be all zero bytes.
    centre: Vec<Centre, 1>,
    posterior: Vec<Posterior, 1>,
    known_attitude: Vec<KnownAttitude, 1>,
    shares: Shares<T>,
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Before its configuration.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            settings: Settings::UNSET,
            prior: Prior::zero(),
            intake: Intake::zero(),
            task: Task::Next,
            course: Course::zero(),
            bias: zero3(),
            parameters: Parameters::zero(),
            pre: Preintegration::zero(),
            rests: Rests::zero(),
            kind: Kind::Moving,
            node: Node::zero(),
            update: Update::zero(),
            candidates: Candidates::zero(),
            further: [[T::ZERO; E]; SCRATCH],
            evidence: Evidence::zero(),
            remainder: Remainder::zero(),
            was_unexplained: false,
            globals: Globals::zero(),
            updates: 0,
            averaging: Averaging::zero(),
            is_searched: false,
            left_over: LeftOver::zero(),
            centre: Vec::new(),
            posterior: Vec::new(),
            known_attitude: Vec::new(),
            shares: Shares::zero(),
        }
    }

    /// Sets the configuration and starts afresh.
    pub fn configure(&mut self, settings: &Settings, library: &'static [&'static dyn Effect]) {
        self.candidates.configure(library);
        self.settings = *settings;
        self.intake.start(settings);
        self.remainder.start();
        self.was_unexplained = false;
        self.shares = Shares::zero();
        self.rests.start();
        let [x, y, z] = self.settings.factory.b_rad_s.map(T::of);
        self.bias = V3::new(x, y, z);
        self.begin();
        self.posterior.clear();
        self.known_attitude.clear();
    }

    /// Starts from the factory's prior.
    fn begin(&mut self) {
        self.prior = Prior::of(&self.settings);
        self.task = Task::Next;
        self.course.begin();
        self.candidates.begin();
        self.evidence.clear();
        self.globals.start();
        self.node.referred = 0;
        self.updates = self.updates.wrapping_add(1);
        self.rests.interrupt();
        self.start_node();
        self.left_over.start();
        self.averaging = Averaging::zero();
        self.centre.clear();
        self.linearise();
    }

    /// Computes the parameters at the present globals.
    fn linearise(&mut self) {
        let mut x = self.globals.x;
        for (x, sigma) in x.iter_mut().zip(&self.prior.sigma) {
            *x *= *sigma;
        }
        self.parameters = Parameters::new(&x, &self.bias, &self.prior.p);
    }

    /// Starts about a stored model with its deviations: P's prior is about the model's P, as wide as that was known and may
    /// have drifted. The bias is another one at every start, and is as unknown as without the
    /// model. The effects that were taken out still are. If the samples contradict the model, it is forgotten.
    pub fn restore(&mut self, model: &GyroModel, deviations: &Theta, effects: &ActiveEffects) {
        self.prior.restore(model, deviations);
        self.candidates.restore(effects);
        self.linearise();
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

    /// Steps the mean of the bias, raw frame.
    fn step_bias(&mut self, by_rad_s: &V3<T>) {
        self.bias += by_rad_s;
        self.linearise();
    }

    /// Asks for the posterior of all samples so far. It is there once [`Estimator::step`] has worked up to here, and
    /// until then there is none. `is_searched`: true if the cost of a search about it is wanted too, see
    /// [`Estimator::window_cost`].
    pub fn close(&mut self, is_searched: bool) {
        self.posterior.clear();
        self.intake.ask(Item::Close { is_searched });
    }

    /// Returns the posterior that the last [`Estimator::close`] asked for, once it is done.
    #[must_use]
    pub fn posterior(&self) -> Option<&Posterior> {
        self.posterior.first()
    }

    /// Effects that the evidence shows, as of the last posterior.
    #[must_use]
    pub fn claims(&self) -> &[Claim] {
        &self.evidence.account.claims
    }

    /// Log Bayes factors of the candidates beside those that are claimed: the library's effects, then further steps of
    /// the bias.
    #[must_use]
    pub const fn tried(&self) -> &[f32; MAX_CANDIDATES] {
        &self.evidence.choice.tried
    }

    /// Returns the number of candidates that were tried.
    #[must_use]
    pub fn candidates(&self) -> u8 {
        self.candidates.named_count() as u8
    }

    /// The effects that are looked for.
    #[must_use]
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.candidates.library()
    }

    /// Norm of the field at the start, microtesla.
    #[must_use]
    pub fn field_ut(&self) -> f32 {
        self.course.field_unit.narrow()
    }

    /// NIS of all nodes of motion, mean squared innovation over its degrees of freedom: first with neither nuisances
    /// nor effects, then with the claims.
    #[must_use]
    pub fn nis_of_claims(&self) -> [f32; 2] {
        self.evidence.residual.map(|of_claims| self.course.consistency.nis_beside(of_claims))
    }

    /// Returns the quantities that the field's innovations go with since [`Estimator::start_remainder`].
    #[must_use]
    pub fn remainder(&self) -> RemainderReport {
        self.remainder.report()
    }

    /// Returns true if the innovations hold more than noise and the claims, or an error that the library has no name
    /// for.
    #[must_use]
    pub fn is_unexplained(&self) -> bool {
        let [_, nis] = self.nis_of_claims();
        let is_large = nis > consistency::DIVERGED || self.remainder.is_contradicted();
        is_large || self.evidence.choice.is_unnamed || !self.remainder.report().is_white()
    }

    /// Begins a new remainder with the innovations to come.
    pub fn start_remainder(&mut self) {
        self.was_unexplained = self.is_unexplained();
        self.remainder.start();
    }

    /// Increments that were lost because [`Estimator::step`] was called too seldom.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.intake.lost()
    }

    /// Seconds of motion since the start.
    #[must_use]
    pub fn motion_s(&self) -> f32 {
        self.course.motion_s.narrow()
    }

    /// When the probe was last at rest, microseconds; `None` before the first rest.
    #[must_use]
    pub fn last_rest_us(&self) -> Option<u64> {
        Some(self.rests.latest_us).filter(|us| *us > 0)
    }

    /// Returns the number of the last `seconds`, at most 64, that were at rest.
    #[must_use]
    pub fn rest_seconds(&self, seconds: u32) -> u32 {
        self.rests.seconds(seconds)
    }
}

#[cfg(test)]
mod tests;
