#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    history::History,
    normal::{Factor, MAX_COLUMNS, Model, Normal},
    remainder::Remainder,
    report::{DiagnosisReport, EffectReport, MAX_CANDIDATES, Tried, Verdict},
    sign_flip::{GROUPS, Scores, sign_flip},
    walk::Walk,
    weak_columns::{COLUMNS, GYRO, GyroScales, Layout, TestFacts, WeakColumns},
    whitening::Whitening,
};
use crate::{
    algebra::quantile,
    compensation::{ActiveEffects, Effect, FoundEffect, GyroModel, MAX_ACTIVE, Moment, Sensor, effect::MAX_PARAMETERS},
    config::Config,
    window::SampleStream,
};
use nalgebra::{Matrix3, Vector3};

/// Increments that are walked in one piece of work.
const SLICE: u32 = 8;

/// Most test windows of one diagnosis.
const MAX_TESTS: usize = 104;

/// Fewest test windows in a group: two seconds.
const LEAST_PER_GROUP: u32 = 4;

/// Rate of false alarms of a whole diagnosis of a model that lacks nothing; shared out among the candidates (Bonferroni).
const FALSE_ALARMS: f32 = 0.01;

/// Least evidence of a candidate over the cost of its parameters: odds of 20 to 1.
const LEAST_WORTH: f32 = 3.0;

/// By how much a candidate has to show more than one that stands before it in the library, where the likelier of two that look alike
/// come first: odds of 7 to 1.
const LEAST_LEAD: f32 = 2.0;

/// Huber's constant, in deviations of a vector residual's component.
const HUBER: f32 = 3.0;

/// Squared residual of a vector that every other one is under: the median of chi-square with 3 degrees of freedom.
const MEDIAN_SQUARE: f32 = 2.366;

/// Deviation of specific force that is sensor noise, m/s^2: 2 mg in 50 Hz, the noise of common parts (0.2 mg/rtHz) and their cross-axis
/// terms.
const FORCE_NOISE_M_S2: f32 = 0.02;

/// Deviation of the field that is sensor noise at least, microtesla: the resolution of common parts (AK8963: 0.15).
const FIELD_NOISE_UT: f32 = 0.05;

/// A vector that is turned by less does not matter: 0.3 deg.
const LEAST_TURN_RAD: f32 = 0.005_2;

/// Rotation over a second that grows to those 0.3 deg over 16 s, about the mean age of a diagnosis, even if it adds up like noise.
const LEAST_DRIFT_RAD: f32 = LEAST_TURN_RAD / 4.0;

/// A residual of the field that is left for unexplained: a fifth of what matters.
const LEAST_LEFT_RAD: f32 = LEAST_TURN_RAD / 5.0;

/// Most passes of one diagnosis.
const MOST_PASSES: u8 = 20;

/// Information from which a parameter is observed: its deviation is half its usual size.
const OBSERVED: f32 = 4.0;

/// Deviations that a parameter of an effect has to be from zero to be taken out.
const SIGNIFICANT: f32 = 3.0;

/// Columns of P.
const P: usize = 9;

/// Share of the misfit that P has to explain to be taken for wrong; what a window of the identification has to, as well.
const EXPLAINED: f32 = 0.75;

/// Passes after which candidates are tried though the solution has not settled: a model that lacks a large effect may never do so.
const PATIENCE: u8 = 4;

/// The solution has settled when the scales of the residuals change by less than this from one pass to the next.
const SETTLED: f32 = 1.3;

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
}

/// What the diagnosis looks at and with.
pub(crate) struct Subject<'a> {
    pub stream: &'a SampleStream,
    pub config: &'a Config,
    pub library: &'a [&'static dyn Effect],
}

/// An effect in the model.
#[derive(Clone, Copy)]
struct Chosen {
    index: u8,
    evidence: f32,
    p_value: f32,
    /// Sum of squares of what it turns, and of how many.
    turned: [f32; 2],
    residual_before_rad: f32,
    residual_after_rad: f32,
    /// Sandwich deviations of its scaled parameters.
    sigma: [f32; MAX_PARAMETERS],
    /// Whether this window alone would not have shown it.
    by_history: bool,
}

impl Chosen {
    const NONE: Self = Self {
        index: 0,
        evidence: 0.0,
        p_value: 0.0,
        turned: [0.0; 2],
        residual_before_rad: 0.0,
        residual_after_rad: 0.0,
        sigma: [0.0; MAX_PARAMETERS],
        by_history: false,
    };
}

/// What a candidate shows beside the model.
struct Effective {
    scores: Scores,
    whitening: Whitening,
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
    /// Squared residuals of each test window in units of their prior variance, at the solution of the pass before; negative: none.
    squares: [[f32; 2]; MAX_TESTS],
    /// Variance of the rows, over what they were thought to have.
    scales: [f32; 2],
    /// Solution so far, in units of the usual sizes.
    x: [f32; COLUMNS],
    /// The part of it that is taken out of the readings before the equations are made, so that they are about the solution: a lag
    /// of 15 ms at 180 deg/s is seen a thousandth wrong to first order.
    taken_out: ActiveEffects,
    chosen: heapless::Vec<Chosen, MAX_ACTIVE>,
    /// Candidates that are too small to matter, or did not fit: one bit each.
    banned: u32,
    tried: [Tried; MAX_CANDIDATES],
    residual: [f32; 2],
    residual_sums: [[f32; 2]; 2],
    residual_before_rad: Option<[f32; 2]>,
    nis_sums: [f32; 2],
    nis: f32,
    nis_before: f32,
    remainder: Remainder,
    /// Whether the report is to be taken.
    done: bool,
}

mod measure;
mod selection;
mod verdict;

impl Diagnosis {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            running: false,
            job: DiagnosisJob { t_start_us: 0, t_end_us: 0, from: 0, to: 0, flown: GyroModel::UNSET },
            p: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            c: Vector3::new(0.0, 0.0, 0.0),
            pass: 0,
            was_stable: false,
            since_change: 0,
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
            squares: [[0.0; 2]; MAX_TESTS],
            scales: [0.0; 2],
            x: [0.0; COLUMNS],
            taken_out: ActiveEffects::none(),
            chosen: heapless::Vec::new(),
            banned: 0,
            tried: [Tried { evidence: 0.0, p_value: 0.0, too_small: false }; MAX_CANDIDATES],
            residual: [0.0; 2],
            residual_sums: [[0.0; 2]; 2],
            residual_before_rad: None,
            nis_sums: [0.0; 2],
            nis: 0.0,
            nis_before: 0.0,
            remainder: Remainder::zero(),
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
        self.is_final = false;
        self.p_is_held = false;
        self.tested = false;
        self.usable = 0;
        self.scales = [1.0; 2];
        self.squares = [[0.0; 2]; MAX_TESTS];
        self.x = [0.0; COLUMNS];
        self.chosen.clear();
        self.banned = 0;
        self.tried = [Tried { p_value: 1.0, ..Tried::default() }; MAX_CANDIDATES];
        self.residual_before_rad = None;
        self.nis_before = 0.0;
        self.done = false;
        self.start_pass(subject);
    }

    fn start_pass(&mut self, subject: &Subject) {
        self.next = self.job.from;
        self.test = 0;
        self.usable_before = self.usable;
        self.usable = 0;
        let scales = gyro_scales(subject);
        let flown_p = self.job.flown.p_matrix();
        let flown_c = flown_p * Vector3::from(self.job.flown.b_rad_s);
        self.p = Matrix3::from_fn(|i, j| flown_p[(i, j)] + scales.of_p(i, j) * self.x[3 * i + j]);
        self.c = Vector3::from_fn(|i, _| flown_c[i] + scales.c_rad_s * self.x[9 + i]);
        self.walk.start(subject.stream, self.job.from, (&self.p, &self.c));
        self.columns.start(subject.stream.weak_form.hop());
        self.normal.clear();
        self.scores.fill(0.0);
        let mut taken_out = ActiveEffects::none();
        for &Chosen { index, .. } in &self.chosen {
            let parameters = self.parameters(subject, usize::from(index));
            taken_out.add(FoundEffect { index, parameters, ..FoundEffect::default() });
        }
        self.taken_out = taken_out;
        self.residual_sums = [[0.0; 2]; 2];
        self.nis_sums = [0.0; 2];
        if !self.is_final {
            self.remainder.start(subject.stream.weak_form.hop(), subject.stream.grid.interval_s());
        }
        for chosen in &mut self.chosen {
            chosen.turned = [0.0; 2];
        }
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
        let more = self.end_pass(subject, history);
        if more {
            self.start_pass(subject);
        } else {
            self.running = false;
            self.done = true;
        }
        3_000
    }

    /// The columns of a candidate; empty where there is no room for it.
    fn columns_of(&self, subject: &Subject, index: usize) -> core::ops::Range<usize> {
        self.layout.columns_of(subject.library, index)
    }

    #[inline(never)]
    fn take(&mut self, subject: &Subject, index: u32) {
        let scales = gyro_scales(subject);
        let mut instant = self.walk.advance((subject.stream, self.job.to), index, (&self.p, &self.c));
        let read = instant.moment;
        self.taken_out.correct_vectors(subject.library, &mut instant.moment);
        self.measure_turns(subject, &read);
        if !self.is_final {
            self.remainder.watch(&instant);
        }
        let weak_form = &subject.stream.weak_form;
        let moving = subject.config.identification.max_bias_rad_s;
        let library = (subject.library, &self.layout);
        if let Some((facts, number)) = self.columns.push(&instant, weak_form, library, &scales, moving) {
            self.take_test(subject, &facts, number, weak_form.noise_gain());
            self.columns.clear(number);
        }
    }

    /// Parameters of a candidate in the solution so far, in SI units.
    fn parameters(&self, subject: &Subject, index: usize) -> [f32; MAX_PARAMETERS] {
        let mut parameters = [0.0; MAX_PARAMETERS];
        let Some(effect) = subject.library.get(index) else { return parameters };
        let columns = self.columns_of(subject, index);
        for ((value, column), parameter) in parameters.iter_mut().zip(columns).zip(effect.parameters()) {
            *value = self.x_of(column) * parameter.usual;
        }
        parameters
    }

    /// The scores of each group.
    fn groups(&self) -> &[[f32; COLUMNS]] {
        self.scores.as_chunks().0
    }

    /// The model so far, or all of it but one effect. What history added is not this window's to solve for.
    fn model(&self, subject: &Subject, without: Option<usize>) -> Model {
        let mut model = Model::new();
        let chosen = self.chosen.iter().filter(|chosen| !chosen.by_history);
        let effects = chosen.map(|chosen| usize::from(chosen.index)).filter(|index| Some(*index) != without);
        let gyro = if self.p_is_held { P..GYRO } else { 0..GYRO };
        let columns = gyro.chain(effects.flat_map(|index| self.columns_of(subject, index)));
        for column in columns {
            // No room is no column.
            let _ = model.push(column as u8);
        }
        model
    }

    /// The solution so far of a column.
    fn x_of(&self, column: usize) -> f32 {
        at(&self.x, column)
    }

    /// Moves the solution to the optimum of the model.
    fn solve(&mut self, model: &Model) -> Option<()> {
        self.factor.of(&self.normal, model)?;
        let mut rhs = [0.0; MAX_COLUMNS];
        for (sum, &column) in rhs.iter_mut().zip(model) {
            let column = usize::from(column);
            // The prior of deviation 1 about zero pulls with the value itself.
            let pull = -self.x_of(column);
            *sum = self.groups().iter().fold(pull, |sum, scores| sum + at(scores, column));
        }
        self.factor.solve(&mut rhs);
        for (change, &column) in rhs.iter().zip(model) {
            if let Some(x) = self.x.get_mut(usize::from(column)) {
                *x += change;
            }
        }
        Some(())
    }

    /// Ends a pass; whether another is needed.
    #[inline(never)]
    fn end_pass(&mut self, subject: &Subject, history: &mut History) -> bool {
        if self.usable < LEAST_PER_GROUP * GROUPS as u32 {
            return false;
        }
        // The first residuals are those of the errors that are looked for.
        let is_stable = self.pass > 0 && self.rescale();
        // The solution that made these residuals comes from the pass before: it has settled when the scales had by then.
        let has_settled = is_stable && self.was_stable;
        self.was_stable = is_stable;
        let rms = self.residual_sums.map(|[sum, count]| libm::sqrtf(if count > 0.0 { sum / count } else { 0.0 }));
        self.residual = rms;
        let [sum, count] = self.nis_sums;
        self.nis = if count > 0.0 { sum / count } else { 0.0 };
        let model = self.model(subject, None);
        self.pass += 1;
        self.since_change += 1;
        let may_go_on = self.pass < MOST_PASSES;
        if !has_settled && self.since_change < PATIENCE && may_go_on {
            return self.solve(&model).is_some();
        }
        self.tested = true;
        if self.residual_before_rad.is_none() {
            self.residual_before_rad = Some(rms);
            self.nis_before = self.nis;
        }
        if let Some(last) = self.chosen.last_mut() {
            last.residual_after_rad = Self::shown_in(subject, last.index, rms);
        }
        if (has_settled || self.is_final) && self.drop_one(subject) {
            return may_go_on && self.changed(subject);
        }
        if self.is_final || !may_go_on {
            return false;
        }
        if !self.chosen.is_full()
            && let Some((index, evidence, p_value)) = self.best_candidate(subject, &model)
        {
            let residual_before_rad = Self::shown_in(subject, index as u8, rms);
            // There is room.
            let _ =
                self.chosen.push(Chosen { index: index as u8, evidence, p_value, residual_before_rad, ..Chosen::NONE });
            return self.changed(subject);
        }
        if !has_settled {
            return self.solve(&model).is_some();
        }
        // Nothing more shows in this window by itself. What is left while P is free is what the verdict is about: what P itself lacks is the
        // identification's.
        self.is_final = true;
        self.left = (self.nis, rms[1]);
        let p_is_wrong = self.p_is_wrong(&model);
        let added = self.add_by_history(subject, &model, history);
        if !p_is_wrong {
            self.p_is_held = true;
            self.x.iter_mut().take(P).for_each(|x| *x = 0.0);
        }
        // More passes, to see what is left with P as it flies and what was added.
        (added || !p_is_wrong) && self.changed(subject)
    }

    /// The model has been changed: whether it can be solved.
    fn changed(&mut self, subject: &Subject) -> bool {
        self.since_change = 0;
        let model = self.model(subject, None);
        self.solve(&model).is_some()
    }

    /// Scales of the rows' variances from the median residual: what every other test window is under. Whether they are much the same
    /// as before.
    fn rescale(&mut self) -> bool {
        let mut has_settled = true;
        for v in 0..2 {
            let mut values = [0.0; MAX_TESTS];
            let squares = self.squares.iter().take(self.test as usize).map(|squares| squares[v]);
            let mut count = 0;
            for (value, square) in values.iter_mut().zip(squares.filter(|square| *square > 0.0)) {
                *value = square;
                count += 1;
            }
            let median = quantile(values.get_mut(..count).unwrap_or_default(), 0.5) / MEDIAN_SQUARE;
            if median > 0.0 && median.is_finite() {
                has_settled &= median < SETTLED * self.scales[v] && self.scales[v] < SETTLED * median;
                self.scales[v] = median;
            }
        }
        has_settled
    }
}

fn gyro_scales(subject: &Subject) -> GyroScales {
    let id = &subject.config.identification;
    GyroScales {
        diagonal: id.prior_sigma_diagonal,
        off_diagonal: id.prior_sigma_off_diagonal,
        c_rad_s: id.prior_sigma_bias_rad_s,
    }
}

/// An element; 0 beyond the end.
fn at(values: &[f32], index: usize) -> f32 {
    values.get(index).copied().unwrap_or(0.0)
}

fn square(x: f32) -> f32 {
    x * x
}
