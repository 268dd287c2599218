#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    bias_step::{BiasStep, RateErrors, Scan, Shocks, Timing},
    history::History,
    normal::{Factor, MAX_COLUMNS, Model, Normal, Prior},
    remainder::Remainder,
    report::{BiasStepReport, DiagnosisReport, EffectReport, MAX_CANDIDATES, Tried, Verdict},
    sign_flip::GROUPS,
    stream::{RestBias, SampleStream, UNDER_WAY, halved, whole},
    walk::Walk,
    weak_columns::{COLUMNS, GYRO, GyroScales, Layout, NO_ROWS, TestFacts, WeakColumns, put},
    whitening::{Whitening, each_parameter},
};
use crate::{
    algebra::quantile,
    compensation::{ActiveEffects, Effect, FoundEffect, GyroModel, MAX_ACTIVE, Moment, Sensor, effect::MAX_PARAMETERS},
    config::Config,
};
use nalgebra::{Matrix3, Vector3};

mod all_windows;
mod bias_steps;
mod chosen;
mod end_of_pass;
mod flown;
mod limits;
mod measure;
mod pass;
mod selection;
mod solution;
mod trial;
mod verdict;

use chosen::Chosen;
use end_of_pass::{Ending, Next};
use limits::*;
use trial::Trial;

/// Increments that are walked in one piece of work.
const SLICE: u32 = 4;

/// Work units of a piece of the end of a pass.
const END_UNITS: u32 = 250;

/// Most test windows of one diagnosis.
const MAX_TESTS: usize = 104;

/// What is to be diagnosed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiagnosisJob {
    pub t_start_us: u64,
    pub t_end_us: u64,
    /// Increments.
    pub from: u32,
    pub to: u32,
    /// The model that flew at the end: what is found does not depend on when the work is done.
    pub flown: GyroModel,
    /// Share of them that no diagnosis has looked at.
    pub unseen: f32,
    /// The bias from rests before the end, with what the effects add to it.
    pub rest: RestBias,
}

/// What the diagnosis looks at and with.
pub(crate) struct Subject<'a> {
    pub stream: &'a SampleStream,
    pub config: &'a Config,
    pub library: &'a [&'static dyn Effect],
}

/// One diagnosis, resumable: each step is a bounded piece of it.
pub(crate) struct Diagnosis {
    running: bool,
    job: DiagnosisJob,
    p: Matrix3<f32>,
    c: Vector3<f32>,
    pass: u8,
    /// Whether the scales stayed in the pass before.
    was_stable: bool,
    /// Passes since the model was changed.
    since_change: u8,
    /// Mean square of what turns the magnetometer's axes and is none of the library's, rad^2; 0: nothing.
    outside: f32,
    /// NIS and residual of the field when nothing more could be added.
    left: (f32, f32),
    /// Whether nothing is added any more.
    is_final: bool,
    /// Whether P is held as it flies.
    p_is_held: bool,
    /// Whether candidates have been tried.
    tested: bool,
    next: u32,
    test: u32,
    usable: u32,
    usable_before: u32,
    walk: Walk,
    layout: Layout,
    columns: WeakColumns,
    normal: Normal,
    /// Group by group. Flat, so that it is cleared where it stands.
    scores: [f32; GROUPS * COLUMNS],
    factor: Factor,
    /// Squared residuals of each test window in units of their prior variance, at the solution of the pass before, the upper half of an f32;
    /// 0: none.
    squares: [[u16; 2]; MAX_TESTS],
    /// Variance of the rows, over what they were thought to have.
    scales: [f32; 2],
    /// What is known of it before.
    priors: [Prior; COLUMNS],
    /// Solution so far, in units of the usual sizes.
    x: [f32; COLUMNS],
    /// The part of it that is taken out of the readings before the equations are made, so that they are about the solution: a lag
    /// of 15 ms at 180 deg/s is seen a thousandth wrong to first order.
    taken_out: ActiveEffects,
    /// The step of the bias that is taken out, and the one that the last pass shows.
    step: BiasStep,
    shown_step: BiasStep,
    shocks: Shocks,
    scan: Scan,
    /// Sums of the raw and of the compensated rates of the pass, rad/s.
    rate_sums: [Vector3<f32>; 2],
    chosen: heapless::Vec<Chosen, MAX_ACTIVE>,
    /// Columns that left the solution, one bit each.
    left_out: u64,
    /// Candidates that are too small to matter, or did not fit: one bit each.
    banned: u32,
    tried: [Tried; MAX_CANDIDATES],
    /// What each candidate was worth when the last was chosen, or when it was.
    worths: [f32; MAX_CANDIDATES],
    residual: [f32; 2],
    residual_sums: [[f32; 2]; 2],
    residual_before_rad: Option<[f32; 2]>,
    nis_sums: [f32; 2],
    nis: f32,
    nis_before: f32,
    remainder: Remainder,
    ending: Ending,
    trial: Trial,
    /// The candidate that shows most so far, with its worth, and what history says that its parameters are.
    best: heapless::Vec<(Chosen, f32), 1>,
    estimate: [f32; MAX_PARAMETERS],
    /// Whether the report is to be taken.
    done: bool,
}

impl Diagnosis {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            running: false,
            job: DiagnosisJob {
                t_start_us: 0,
                t_end_us: 0,
                from: 0,
                to: 0,
                flown: GyroModel::UNSET,
                unseen: 0.0,
                rest: RestBias::ZERO,
            },
            p: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            c: Vector3::new(0.0, 0.0, 0.0),
            pass: 0,
            was_stable: false,
            since_change: 0,
            outside: 0.0,
            left: (0.0, 0.0),
            is_final: false,
            p_is_held: false,
            tested: false,
            next: 0,
            test: 0,
            usable: 0,
            usable_before: 0,
            walk: Walk::zero(),
            layout: Layout::zero(),
            columns: WeakColumns::zero(),
            normal: Normal::zero(),
            scores: [0.0; GROUPS * COLUMNS],
            factor: Factor::zero(),
            squares: [[0; 2]; MAX_TESTS],
            scales: [0.0; 2],
            priors: [Prior { information: 0.0, mean: 0.0 }; COLUMNS],
            x: [0.0; COLUMNS],
            taken_out: ActiveEffects::none(),
            step: BiasStep::zero(),
            shown_step: BiasStep::zero(),
            shocks: Shocks::zero(),
            scan: Scan::zero(),
            rate_sums: [Vector3::new(0.0, 0.0, 0.0); 2],
            chosen: heapless::Vec::new(),
            left_out: 0,
            banned: 0,
            tried: [Tried { evidence: 0.0, p_value: 0.0, too_small: false, suspected: false }; MAX_CANDIDATES],
            worths: [0.0; MAX_CANDIDATES],
            residual: [0.0; 2],
            residual_sums: [[0.0; 2]; 2],
            residual_before_rad: None,
            nis_sums: [0.0; 2],
            nis: 0.0,
            nis_before: 0.0,
            remainder: Remainder::zero(),
            ending: Ending::Scales,
            trial: Trial::zero(),
            best: heapless::Vec::new(),
            estimate: [0.0; MAX_PARAMETERS],
            done: false,
        }
    }

    /// Begins a diagnosis; what another has not finished is dropped.
    pub fn start(&mut self, subject: &Subject, job: DiagnosisJob) {
        self.running = true;
        self.job = job;
        self.layout = Layout::new(subject.library);
        self.pass = 0;
        self.was_stable = false;
        self.since_change = 0;
        self.outside = 0.0;
        self.is_final = false;
        self.p_is_held = false;
        self.tested = false;
        self.usable = 0;
        self.scales = [1.0; 2];
        self.squares = [[0; 2]; MAX_TESTS];
        self.priors = [Prior::UNIT; COLUMNS];
        self.x = [0.0; COLUMNS];
        self.step = BiasStep::NONE;
        self.shown_step = BiasStep::NONE;
        self.chosen.clear();
        self.left_out = 0;
        self.banned = 0;
        self.tried = [Tried { p_value: 1.0, ..Tried::default() }; MAX_CANDIDATES];
        self.worths = [0.0; MAX_CANDIDATES];
        self.residual_before_rad = None;
        self.nis_before = 0.0;
        self.done = false;
        self.trial.drop_unfinished();
        self.start_pass(subject);
    }

    /// The report of a diagnosis that is done.
    #[inline(never)]
    pub fn take_report(&mut self, subject: &Subject) -> Option<DiagnosisReport> {
        let done = core::mem::take(&mut self.done);
        done.then(|| self.report(subject))
    }

    /// One bounded piece of work; returns its size in work units, 0 when there is nothing to do.
    #[inline(never)]
    pub fn step(&mut self, subject: &Subject, history: &mut History) -> u32 {
        if !self.running {
            return 0;
        }
        if !subject.stream.increments.holds(self.job.from) {
            // Overtaken by the samples: what was begun is lost, and the next window has its own.
            self.running = false;
            return 1;
        }
        if self.next < self.job.to {
            let end = if self.job.to - self.next < SLICE { self.job.to } else { self.next + SLICE };
            for index in self.next..end {
                self.take(subject, index);
            }
            self.next = end;
            return 40 * SLICE;
        }
        match self.end_pass(subject, history) {
            Next::Step(ending) => self.ending = ending,
            Next::Pass => self.start_pass(subject),
            Next::Done => {
                if self.tested {
                    self.remember(subject, history);
                }
                self.running = false;
                self.done = true;
            }
        }
        END_UNITS
    }
}

/// An element; 0 beyond the end.
fn at(values: &[f32], index: usize) -> f32 {
    values.get(index).copied().unwrap_or(0.0)
}

/// Weight of a vector residual of that square in its deviations (Huber): beyond three of them it pulls no harder.
fn huber(z: f32) -> f32 {
    let limit = HUBER * HUBER * 3.0;
    if z > limit { libm::sqrtf(limit / z) } else { 1.0 }
}

fn square(x: f32) -> f32 {
    x * x
}
