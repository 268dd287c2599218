//! The filter between two requests: increments enter the node in progress, and the rows of a node the root of all that
//! is estimated, piece by piece.

use super::{
    NodeEnd, Settings,
    candidates::{Candidates, Claim, Misfit, Units, Unturned, evidence::Evidence},
    columns::{GLOBALS, NUISANCES, P},
    course::Course,
    globals::Globals,
    gyro_matrix::GyroMatrix,
    increment::Increment,
    left_over::LeftOver,
    node::{Kind, Node},
    parameters::Parameters,
    preintegration::Preintegration,
    prior::Prior,
    reading,
    real::{Real, V3, norm, widened, zero3},
    remainder::Remainder,
    rest::Rests,
    rows::SCRATCH,
    share::Shares,
    update::Update,
    walk,
};
use crate::compensation::{ActiveEffects, Effect, GyroModel, Theta};
use core::f32::consts::PI;
use nalgebra::Vector3;

/// Length of a node, seconds.
const NODE_S: f32 = 0.5;
/// Length of an increment, microseconds.
const INCREMENT_US: u64 = 40_000;
/// Interval at which the effects are weighed, microseconds.
const WEIGHED_EVERY_US: u64 = 5_000_000;

/// Work units of the pieces: the largest cost of each kind that a flight has shown, in cycles, over
/// [`UNIT_CYCLES`](super::UNIT_CYCLES).
const COLUMN_UNITS: u32 = 56;
const NOISE_UNITS: u32 = 105;
const WALKING_UNITS: u32 = 70;

/// Piece of a node's work in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// Waits for the next increment.
    Idle,
    /// Eliminates the old states from a node's rows.
    Eliminating,
    /// Adds the remaining rows to the globals, from this column on.
    Absorbing(usize),
    /// Adds the remaining rows to the effects' own, from this column on.
    AbsorbingOwn(usize),
    /// Weighs the effects.
    Weighing,
    /// Adds process noise to each global that walks, from this column on.
    AddingNoise(usize),
    /// Makes the root with the noise triangular, from this column on.
    Walking(usize),
}

/// State of the filter: what is estimated, and the node in progress.
pub(super) struct Filter<T, const NODES: usize, const E: usize> {
    pub settings: Settings,
    pub prior: Prior<T>,
    pub task: Task,
    pub course: Course<T>,
    /// Mean of the bias's prior, rad/s, raw frame; and true if a rest has measured it.
    pub bias: V3<T>,
    pub has_measured_bias: bool,
    pub parameters: Parameters<T>,
    pub pre: Preintegration<T>,
    pub rests: Rests<T>,
    pub kind: Kind,
    pub node: Node<T>,
    pub update: Update<T>,
    pub candidates: Candidates<T, E>,
    /// The effects' part of an update's rows.
    pub further: [[T; E]; SCRATCH],
    pub evidence: Evidence<T>,
    pub remainder: Remainder,
    /// True if more than noise was left at the end of the window before.
    pub was_unexplained: bool,
    pub globals: Globals<T>,
    /// Number of changes of the globals.
    pub updates: u32,
    pub left_over: LeftOver<NODES>,
    pub shares: Shares<T>,
}

impl<T: Real, const NODES: usize, const E: usize> Filter<T, NODES, E> {
    /// Before its configuration.
    pub const fn zero() -> Self {
        Self {
            settings: Settings::UNSET,
            prior: Prior::zero(),
            task: Task::Idle,
            course: Course::zero(),
            bias: zero3(),
            has_measured_bias: false,
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
            left_over: LeftOver::zero(),
            shares: Shares::zero(),
        }
    }

    /// Sets the configuration and starts afresh.
    pub fn configure(&mut self, settings: &Settings, library: &'static [&'static dyn Effect]) {
        self.candidates.configure(library);
        self.settings = *settings;
        self.remainder.forget();
        self.was_unexplained = false;
        self.shares = Shares::zero();
        self.rests.start();
        let [x, y, z] = self.settings.factory.b_rad_s.map(T::of);
        self.bias = V3::new(x, y, z);
        self.has_measured_bias = false;
        self.begin();
    }

    /// Starts from the factory's prior.
    pub fn begin(&mut self) {
        self.prior = Prior::of(&self.settings);
        self.task = Task::Idle;
        self.course.begin();
        self.candidates.begin();
        self.evidence.clear();
        self.globals.start();
        self.node.referred = 0;
        self.updates = self.updates.wrapping_add(1);
        self.rests.interrupt();
        self.start_node();
        self.left_over.start();
        self.linearise();
    }

    /// Computes the parameters at the present globals.
    pub fn linearise(&mut self) {
        let mut x = self.globals.x;
        for (x, sigma) in x.iter_mut().zip(&self.prior.sigma) {
            *x *= *sigma;
        }
        self.parameters = Parameters::new(&x, &self.bias, self.gyro_matrix().p);
    }

    /// P at the present globals.
    pub fn gyro_matrix(&self) -> GyroMatrix<T> {
        let column = |k: usize| self.globals.x.get(P.from + k).zip(self.prior.sigma.get(P.from + k));
        let d = core::array::from_fn(|k| column(k).map_or(T::ZERO, |(x, sigma)| *x * *sigma));
        GyroMatrix::new(&d, &self.prior.p)
    }

    /// Starts about a stored model, see [`Estimator::restore`](super::Estimator::restore).
    pub fn restore(&mut self, model: &GyroModel, deviations: &Theta, effects: &ActiveEffects) {
        self.prior.restore(model, deviations);
        self.candidates.restore(effects);
        self.linearise();
    }

    /// Steps the mean of the bias, raw frame.
    fn step_bias(&mut self, by_rad_s: &V3<T>) {
        self.bias += by_rad_s;
        self.linearise();
    }

    /// Takes a step of the bias that has been taken out for long into the bias.
    pub fn settle(&mut self, claim: &Claim) {
        let [x, y, z, ..] = claim.parameters;
        self.candidates.settle(claim, &mut self.globals, &self.prior.sigma);
        self.evidence.account.claims.retain(|other| other.step_us != claim.step_us);
        let step = widened(&Vector3::new(x, y, z));
        // The increments of the node in progress have it taken out already.
        self.pre.settle(&step);
        self.step_bias(&self.parameters.turned_back(&step));
        self.task = Task::Walking(0);
    }

    /// Axes of the body that have not turned, in a drill string: there the earth's field is the same over the whole
    /// path, and only turns of an axis or a declared field tell a constant field along it from the earth's.
    fn unturned(&self) -> [bool; 3] {
        if self.settings.noise.field_is_even { self.course.pointing.hides() } else { [false; 3] }
    }

    /// Variance of the node's rotation by the uncertainty of bias and P, rad^2.
    pub fn unknown_rotation(&self) -> T {
        self.pre.rotation_variance(&self.globals, &self.prior.sigma)
    }

    /// NIS of all nodes of motion: first with neither nuisances nor effects, then with the claims.
    pub fn nis_of_claims(&self) -> [f32; 2] {
        self.evidence.residual.map(|of_claims| self.course.consistency.nis_beside(of_claims))
    }

    /// Begins a node.
    pub fn start_node(&mut self) {
        self.pre.start();
        self.candidates.start_node();
        self.remainder.start_node();
    }

    /// Notes seconds in which the rotation of the probe was unknown; the attitude is then aligned anew.
    pub fn gap(&mut self, seconds: T) {
        self.start_node();
        self.rests.interrupt();
        self.rests.pass(seconds);
        self.course.neighbours.forget_before();
        self.course.is_aligned = false;
        self.course.alignment.start();
        self.course.gap_s += seconds;
        if self.course.has_begun {
            self.course.unwalked_s += seconds;
        }
    }

    /// Adds an increment whose neighbours are known; `increment_s`: length of one. Returns what becomes of the node.
    #[inline(never)]
    pub fn take(&mut self, increment: &Increment<T>, next: Option<&Increment<T>>, increment_s: T) -> NodeEnd {
        let mut increment = *increment;
        if let Some(field) = &mut increment.field {
            if self.course.field_unit == T::ZERO {
                self.course.field_unit = norm(field);
            }
            if self.course.field_unit > T::ZERO {
                *field /= self.course.field_unit;
            }
        }
        self.course.weighed_us.get_or_insert(increment.end_us.saturating_sub(INCREMENT_US));
        let [force_rate, rate_change] = self.course.neighbours.derivatives(&increment, next);
        let (out, moment) = self.candidates.look_at(&increment, &rate_change, self.course.field_unit, &self.parameters);
        let gravity = (self.course.is_aligned && self.settings.noise.predicted_gravity).then(|| {
            let up = V3::new(T::ZERO, T::ZERO, T::of(self.settings.gravity_m_s2));
            self.node.point().transpose() * up
        });
        let turned = self.pre.add(&increment, &force_rate, gravity.as_ref(), &self.parameters, &out);
        self.candidates.add(&turned);
        self.remainder.watch(&moment, &(self.node.attitude * turned.middle).map(|x| x.narrow()));
        // A node ends up to half an increment early, as the increments' lengths are rounded.
        let late = self.pre.seconds + increment_s * T::of(0.5);
        if late < T::of(NODE_S) && self.pre.angle < T::of(PI) {
            return NodeEnd::NotYet;
        }
        let end = NodeEnd::of(self);
        if self.kind == Kind::Rest {
            self.rests.force_m_s2 = moment.force_m_s2;
            self.rests.square_force_m2_s4 = moment.square_force_m2_s4;
            self.rests.warming_k = moment.warming_k;
        }
        end
    }

    /// Does one bounded piece of a node's work; returns its size in units, 0 if there is none.
    pub fn step(&mut self) -> u32 {
        match self.task {
            Task::Idle => 0,
            Task::Eliminating => {
                if !self.update.eliminate(&self.candidates, &mut self.further) {
                    self.task = Task::Absorbing(0);
                }
                COLUMN_UNITS
            }
            Task::Absorbing(column) => {
                self.absorb(column);
                COLUMN_UNITS
            }
            Task::AbsorbingOwn(column) => {
                self.absorb_own(column);
                COLUMN_UNITS
            }
            Task::Weighing => {
                let units = self.evidence.units();
                self.weigh();
                units
            }
            Task::AddingNoise(from) => {
                self.add_process_noise(from);
                NOISE_UNITS
            }
            Task::Walking(column) => {
                self.walk(column);
                WALKING_UNITS
            }
        }
    }

    // Not inlined, nor are the pieces below: the cost of each kind of work is counted by its function's calls.
    #[inline(never)]
    fn absorb(&mut self, column: usize) {
        self.updates = self.updates.wrapping_add(1);
        if column == NUISANCES && self.kind == Kind::Moving {
            self.left_over.push(self.update.left_over(), &self.globals.x);
        }
        let next = self.candidates.absorb(&mut self.further, &mut self.globals, self.update.left_over(), column);
        if next < GLOBALS {
            self.task = Task::Absorbing(next);
            return;
        }
        if self.kind == Kind::Moving {
            self.course.consistency.add(self.update.innovation());
        }
        self.task = Task::AbsorbingOwn(0);
    }

    #[inline(never)]
    fn absorb_own(&mut self, column: usize) {
        if self.candidates.absorb_own(&mut self.further, self.update.left_over(), column) {
            self.task = Task::AbsorbingOwn(column + 2);
            return;
        }
        if self.kind == Kind::Moving {
            self.course.consistency.add_unexplained(self.update.innovation());
        }
        let change = self.globals.solve();
        self.update.finish(&mut self.node, &change);
        self.candidates.finish(&self.further);
        let end_us = self.pre.end_us;
        self.pre.start();
        self.linearise();
        self.task = Task::Idle;
        // Both move the means, which must not happen in the middle of a node.
        if self.course.unwalked_s >= T::of(walk::EVERY_S) {
            self.task = Task::AddingNoise(0);
        } else if end_us >= self.course.weighed_us.unwrap_or(end_us).saturating_add(WEIGHED_EVERY_US) {
            self.course.weighed_us = Some(end_us);
            let of = (&self.settings, self.course.field_unit);
            let reference = reading::reference_rows(&self.node, of, (&self.globals.x, &self.prior.sigma));
            let mut unturned = Unturned { axes: self.unturned(), reference };
            let (is_read, is_linear) = (self.node.referred > 0, self.node.curved == 0);
            if is_read && is_linear && !unturned.explains_the_field(&self.globals.x) {
                // An attitude is wrong, and what follows from it would be.
                return;
            }
            if unturned.reference.is_none() && is_read {
                // While the attitude is found again, the rows of the declared field from before hold.
                unturned.reference = self.evidence.reference();
            }
            let is_unexplained = self.was_unexplained || self.remainder.is_contradicted();
            let misfit = Misfit { dispersion: self.remainder.dispersion(), is_unexplained };
            self.evidence.start(&self.settings.rules, misfit, unturned, &self.candidates);
            self.task = Task::Weighing;
        }
    }

    /// Does one piece of the weighing of the effects; at its end takes out the mean of those that the data show.
    #[inline(never)]
    fn weigh(&mut self) {
        let units = Units { sigma: &self.prior.sigma, field_ut: self.course.field_unit };
        let rows = (&mut self.update.rows, &mut self.further);
        if self.evidence.step(rows, &self.globals, &self.candidates, &units) {
            return;
        }
        let mut x = [T::ZERO; E];
        for (column, mean) in self.evidence.account.taken.iter().zip(&self.evidence.account.mean) {
            if let Some(x) = column.place().and_then(|place| x.get_mut(place)) {
                *x = *mean;
            }
        }
        // The search's rows hold for what was taken out before; with other effects they would draw it off the mean.
        if x != *self.candidates.x() {
            self.left_over.start();
        }
        self.candidates.take_out(&x, &mut self.globals, &mut self.node);
        self.candidates.note_steps(&self.evidence.account.claims, &self.evidence.choice.tried);
        self.linearise();
        self.task = Task::Idle;
    }

    /// Adds process noise to the next global that walks, from a column on.
    #[inline(never)]
    fn add_process_noise(&mut self, from: usize) {
        for (column, sigma) in self.prior.sigma.iter().enumerate().skip(from) {
            let variance = walk::variance_per_s(column, sigma.narrow(), &self.settings.noise);
            if variance > 0.0 {
                self.candidates.add_process_noise(&mut self.globals, column, T::of(variance) * self.course.unwalked_s);
                self.task = Task::AddingNoise(column + 1);
                return;
            }
        }
        self.course.unwalked_s = T::ZERO;
        self.task = Task::Walking(0);
    }

    #[inline(never)]
    fn walk(&mut self, column: usize) {
        self.updates = self.updates.wrapping_add(1);
        self.candidates.triangular(&mut self.globals, column);
        self.task = if column + 1 < GLOBALS { Task::Walking(column + 1) } else { Task::Idle };
    }
}
