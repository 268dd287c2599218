#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    history::History,
    normal::{Factor, MAX_COLUMNS, Model, Normal},
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

/// Rotation over a second that grows to those 0.3 deg over the 25 s from one window to the next, even if it adds up like noise.
const LEAST_DRIFT_RAD: f32 = LEAST_TURN_RAD / 5.0;

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
    /// Whether the report is to be taken.
    done: bool,
}

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
        let weak_form = &subject.stream.weak_form;
        let moving = subject.config.identification.max_bias_rad_s;
        let library = (subject.library, &self.layout);
        if let Some((facts, number)) = self.columns.push(&instant, weak_form, library, &scales, moving) {
            self.take_test(subject, &facts, number, weak_form.noise_gain());
            self.columns.clear(number);
        }
    }

    /// How much the chosen vector effects turn their vectors.
    fn measure_turns(&mut self, subject: &Subject, moment: &Moment) {
        if moment.rate_rad_s.norm_squared() < square(subject.config.identification.max_bias_rad_s) {
            return;
        }
        for slot in 0..self.chosen.len() {
            let Some(index) = self.chosen.get(slot).map(|chosen| usize::from(chosen.index)) else { return };
            let Some(effect) = subject.library.get(index) else { continue };
            let vector = match effect.sensor() {
                Sensor::Gyro => continue,
                Sensor::Accelerometer => moment.force_m_s2,
                Sensor::Magnetometer => moment.field_ut,
            };
            let parameters = self.parameters(subject, index);
            let part = crate::compensation::contribution(*effect, &parameters, moment);
            let norm = vector.norm_squared();
            if let Some(chosen) = self.chosen.get_mut(slot).filter(|_| norm > 0.0) {
                chosen.turned[0] += part.norm_squared() / norm;
                chosen.turned[1] += 1.0;
            }
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

    #[inline(never)]
    fn take_test(&mut self, subject: &Subject, test: &TestFacts, under_way: usize, noise_gain: f32) {
        let number = self.test as usize;
        self.test += 1;
        if !(test.counts[0] || test.counts[1]) || number >= MAX_TESTS {
            return;
        }
        let ordinal = self.usable;
        self.usable += 1;
        let width = self.layout.width();
        let group = (ordinal * GROUPS as u32).checked_div(self.usable_before).unwrap_or(0) as usize;
        let is_taken_out = self.taken_out_columns(subject);
        let force = test.force_scatter + square(FORCE_NOISE_M_S2);
        let field = test.field_noise_ut2 + square(FIELD_NOISE_UT);
        let thought = [noise_gain * force, noise_gain * field];
        for v in 0..2 {
            if !test.counts[v] {
                self.squares[number][v] = -1.0;
                continue;
            }
            let rows = self.columns.rows(under_way, v);
            let residual = |i: usize| -> f32 {
                let row = rows[i].iter().zip(&self.x).zip(&is_taken_out).take(width);
                row.fold(test.rhs[v][i], |r, ((a, x), taken_out)| if *taken_out { r } else { r - a * x })
            };
            let r = [residual(0), residual(1), residual(2)];
            let norm = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
            let z = norm / (thought[v] * self.scales[v]);
            self.squares[number][v] = norm / thought[v];
            // Huber: beyond three deviations a residual pulls no harder.
            let limit = HUBER * HUBER * 3.0;
            let huber = if z > limit { libm::sqrtf(limit / z) } else { 1.0 };
            let weight = huber / (thought[v] * self.scales[v]);
            self.normal.add(rows, width, weight);
            if let Some(scores) = self.scores.as_chunks_mut::<COLUMNS>().0.get_mut(group) {
                for (row, r) in rows.iter().zip(&r) {
                    scores.iter_mut().zip(row).take(width).for_each(|(sum, a)| *sum += weight * a * r);
                }
            }
            if test.norms[v] > 0.0 {
                self.residual_sums[v][0] += norm / square(test.norms[v]);
                self.residual_sums[v][1] += 1.0;
            }
            if v == 1 && test.field_noise_ut2 > 0.0 {
                self.nis_sums[0] += norm / (3.0 * noise_gain * test.field_noise_ut2);
                self.nis_sums[1] += 1.0;
            }
        }
        self.measure_drifts(subject, test, under_way);
    }

    /// Columns of what the equations are about already: the gyro's parameters, and the effects whose part is out of the readings.
    fn taken_out_columns(&self, subject: &Subject) -> [bool; COLUMNS] {
        let mut is_taken_out: [bool; COLUMNS] = core::array::from_fn(|column| column < GYRO);
        for found in self.taken_out.iter() {
            let index = usize::from(found.index);
            if subject.library.get(index).is_some_and(|effect| effect.sensor() != Sensor::Gyro) {
                let columns = is_taken_out.get_mut(self.columns_of(subject, index)).unwrap_or_default();
                columns.fill(true);
            }
        }
        is_taken_out
    }

    /// How much the chosen gyro effects turn the body over a test window, whose weights add up to a second.
    fn measure_drifts(&mut self, subject: &Subject, test: &TestFacts, under_way: usize) {
        for slot in 0..self.chosen.len() {
            let Some(index) = self.chosen.get(slot).map(|chosen| usize::from(chosen.index)) else { return };
            if subject.library.get(index).is_none_or(|effect| effect.sensor() != Sensor::Gyro) {
                continue;
            }
            let columns = self.columns_of(subject, index);
            let mut largest = 0.0;
            for v in 0..2 {
                if !(test.counts[v] && test.norms[v] > 0.0) {
                    continue;
                }
                let sum = self.columns.rows(under_way, v).iter().fold(0.0, |sum, row| {
                    let turned =
                        columns.clone().fold(0.0, |turned, column| turned + at(row, column) * self.x_of(column));
                    sum + turned * turned
                });
                let turned = sum / square(test.norms[v]);
                largest = if turned > largest { turned } else { largest };
            }
            if let Some(chosen) = self.chosen.get_mut(slot) {
                chosen.turned[0] += largest;
                chosen.turned[1] += 1.0;
            }
        }
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

    /// A candidate's scores, group by group, cleared of what the model explains, and the information that it has beside the model. `None`
    /// where it shows nothing or is one with the model.
    fn effective_scores(&mut self, subject: &Subject, index: usize, model: &Model) -> Option<Effective> {
        self.effective_scores_of(self.columns_of(subject, index), model)
    }

    /// The same of some columns.
    fn effective_scores_of(&mut self, columns: core::ops::Range<usize>, model: &Model) -> Option<Effective> {
        let dimension = columns.len();
        if dimension == 0 || model.len() + dimension > MAX_COLUMNS {
            return None;
        }
        self.factor.of(&self.normal, model)?;
        // B = N00^-1 N0c, column by column.
        let mut gains = [[0.0_f32; MAX_COLUMNS]; MAX_PARAMETERS];
        for (gain, column) in gains.iter_mut().zip(columns.clone()) {
            for (value, &row) in gain.iter_mut().zip(model) {
                *value = self.normal.get(usize::from(row), column);
            }
            self.factor.solve(gain);
        }
        // S = Ncc - Nc0 B.
        let mut information = [[0.0_f32; MAX_PARAMETERS]; MAX_PARAMETERS];
        for (row_of, column) in information.iter_mut().zip(columns.clone()) {
            for ((element, other), gain) in row_of.iter_mut().zip(columns.clone()).zip(&gains) {
                let rows = model.iter().zip(gain);
                let explained =
                    rows.fold(0.0, |sum, (&row, gain)| sum + self.normal.get(usize::from(row), column) * gain);
                *element = self.normal.get(column, other) - explained;
            }
        }
        let whitening = Whitening::new(&information, dimension, |i| {
            // What is left beside the model has to be more than rounding, too.
            let own = 1e-4 * self.normal.get(columns.start + i, columns.start + i);
            if own > OBSERVED { own } else { OBSERVED }
        })?;
        // A candidate that is in the solution has taken its part out of the residual: put back, evenly, S x of it.
        let own = information.map(|row| {
            let x = columns.clone().zip(&row);
            x.fold(0.0, |sum, (column, s)| sum + s * self.x_of(column)) / GROUPS as f32
        });
        let mut scores = [[0.0; MAX_PARAMETERS]; GROUPS];
        for (score, group) in scores.iter_mut().zip(self.groups()) {
            for (((score, column), gain), own) in score.iter_mut().zip(columns.clone()).zip(&gains).zip(&own) {
                let rows = model.iter().zip(gain);
                let explained = rows.fold(0.0, |sum, (&row, gain)| sum + at(group, usize::from(row)) * gain);
                *score = at(group, column) - explained + own;
            }
        }
        Some(Effective { scores, whitening })
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

    /// Whether P, after all effects, explains most of what is left: then it is about to be identified, and stays free. Else what it would
    /// take is the effects' own: which of two sensors' axes are turned cannot be told, and P flies as it is.
    fn p_is_wrong(&mut self, model: &Model) -> bool {
        let mut others = Model::new();
        for &column in model.iter().filter(|column| usize::from(**column) >= P) {
            // As much room as the model has.
            let _ = others.push(column);
        }
        let Some(Effective { scores, whitening }) = self.effective_scores_of(0..P, &others) else { return false };
        let (gain, _) = sign_flip(&whitening.whitened(&scores));
        // What is left with P free, in the same units: three components of two vectors.
        let left = 6.0 * self.usable as f32;
        gain > EXPLAINED * (gain + left)
    }

    /// Adds this window's scores to those of the windows before, and the candidate that shows most in all of them together to the model.
    fn add_by_history(&mut self, subject: &Subject, model: &Model, history: &mut History) -> bool {
        let chosen = self.chosen.iter();
        history.begin(
            chosen.fold(self.banned, |mask, chosen| mask | 1_u32.checked_shl(u32::from(chosen.index)).unwrap_or(0)),
        );
        let candidates = subject.library.len().min(MAX_CANDIDATES);
        let limit = FALSE_ALARMS / candidates as f32;
        let mut best: Option<(Chosen, [f32; MAX_PARAMETERS], f32)> = None;
        for index in 0..candidates {
            let taken = self.chosen.iter().any(|c| usize::from(c.index) == index);
            if taken || self.banned.checked_shr(index as u32).unwrap_or(0) & 1 != 0 {
                continue;
            }
            let Some(Effective { scores, whitening }) = self.effective_scores(subject, index, model) else { continue };
            let columns = self.columns_of(subject, index);
            let Some(together) = history.with(&columns, &scores) else { continue };
            let whitened = whitening.whitened(&together);
            let windows = f32::from(history.windows());
            let (twice_the_gain, p_value) = sign_flip(&whitened);
            let evidence = 0.5 * twice_the_gain / windows;
            let worth = self.worth(subject, index, evidence);
            if let Some(tried) = self.tried.get_mut(index).filter(|tried| tried.p_value > p_value) {
                (tried.evidence, tried.p_value) = (evidence, p_value);
            }
            if p_value <= limit && worth > best.map_or(LEAST_WORTH, |(.., most)| most + LEAST_LEAD) {
                let estimate = whitening.estimate(&whitened).map(|x| x / windows);
                let sigma = whitening.sandwich(&whitened).map(|x| x / windows);
                let found = Chosen { index: index as u8, evidence, p_value, sigma, by_history: true, ..Chosen::NONE };
                best = Some((found, estimate, worth));
            }
        }
        let Some((found, estimate, _)) = best else { return false };
        let columns = self.columns_of(subject, usize::from(found.index));
        let residual_before_rad = Self::shown_in(subject, found.index, self.residual);
        if self.chosen.push(Chosen { residual_before_rad, ..found }).is_err() {
            return false;
        }
        self.x.get_mut(columns).unwrap_or_default().iter_mut().zip(estimate).for_each(|(x, found)| *x = found);
        true
    }

    /// The model has been changed: whether it can be solved.
    fn changed(&mut self, subject: &Subject) -> bool {
        self.since_change = 0;
        let model = self.model(subject, None);
        self.solve(&model).is_some()
    }

    /// The residual of the vector that shows an effect.
    fn shown_in(subject: &Subject, index: u8, [gravity, field]: [f32; 2]) -> f32 {
        match subject.library.get(usize::from(index)).map(|effect| effect.sensor()) {
            Some(Sensor::Accelerometer) => gravity,
            _ => field,
        }
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

    /// Drops a chosen effect that is too small to matter or, with the others there, no longer shows.
    fn drop_one(&mut self, subject: &Subject) -> bool {
        for slot in 0..self.chosen.len() {
            let Some(&Chosen { index, turned: [sum, count], by_history, .. }) = self.chosen.get(slot) else { break };
            let size = libm::sqrtf(if count > 0.0 { sum / count } else { 0.0 });
            let index = usize::from(index);
            let is_gyro = subject.library.get(index).is_some_and(|effect| effect.sensor() == Sensor::Gyro);
            let too_small = size < if is_gyro { LEAST_DRIFT_RAD } else { LEAST_TURN_RAD };
            let model = self.model(subject, Some(index));
            let effective = self.effective_scores(subject, index, &model);
            let shows = effective.is_some_and(|effective| {
                let scores = effective.whitening.whitened(&effective.scores);
                if let Some(chosen) = self.chosen.get_mut(slot).filter(|_| !by_history) {
                    chosen.sigma = effective.whitening.sandwich(&scores);
                }
                by_history || sign_flip(&scores).1 <= FALSE_ALARMS
            });
            if too_small || !shows {
                if let Some(tried) = self.tried.get_mut(index) {
                    tried.too_small = too_small;
                }
                self.banned |= 1_u32.checked_shl(index as u32).unwrap_or(0);
                let columns = self.columns_of(subject, index);
                self.x.get_mut(columns).unwrap_or_default().fill(0.0);
                self.chosen.retain(|chosen| usize::from(chosen.index) != index);
                return true;
            }
        }
        false
    }

    /// The candidate that shows most, of those that show beyond chance.
    fn best_candidate(&mut self, subject: &Subject, model: &Model) -> Option<(usize, f32, f32)> {
        let candidates = subject.library.len().min(MAX_CANDIDATES);
        let limit = FALSE_ALARMS / candidates as f32;
        let mut best: Option<(usize, f32, f32, f32)> = None;
        for index in 0..candidates {
            let chosen = self.chosen.iter().any(|c| usize::from(c.index) == index);
            if chosen || self.banned.checked_shr(index as u32).unwrap_or(0) & 1 != 0 {
                continue;
            }
            let Some(Effective { scores, whitening }) = self.effective_scores(subject, index, model) else { continue };
            let (twice_the_gain, p_value) = sign_flip(&whitening.whitened(&scores));
            let evidence = 0.5 * twice_the_gain;
            if let Some(tried) = self.tried.get_mut(index) {
                *tried = Tried { evidence, p_value, too_small: false };
            }
            if p_value <= limit
                && self.worth(subject, index, evidence) > best.map_or(LEAST_WORTH, |(.., most)| most + LEAST_LEAD)
            {
                best = Some((index, evidence, p_value, self.worth(subject, index, evidence)));
            }
        }
        best.map(|(index, evidence, p_value, _)| (index, evidence, p_value))
    }

    /// Evidence of a candidate less what its parameters cost (Schwarz, Annals of Statistics 6 (1978) 461).
    fn worth(&self, subject: &Subject, index: usize, evidence: f32) -> f32 {
        let parameters = self.columns_of(subject, index).len() as f32;
        evidence - 0.5 * parameters * libm::logf(self.usable as f32)
    }

    fn report(&self, subject: &Subject) -> DiagnosisReport {
        let enough = self.usable >= LEAST_PER_GROUP * GROUPS as u32 && self.tested;
        let mut effects = [EffectReport::default(); MAX_ACTIVE];
        for (report, chosen) in effects.iter_mut().zip(&self.chosen) {
            let index = usize::from(chosen.index);
            let Some(effect) = subject.library.get(index) else { continue };
            let mut parameters = self.parameters(subject, index);
            let mut sigma = [0.0; MAX_PARAMETERS];
            let both = sigma.iter_mut().zip(&mut parameters);
            for (((sigma, x), scaled), parameter) in both.zip(&chosen.sigma).zip(effect.parameters()) {
                *sigma = scaled * parameter.usual;
                if libm::fabsf(*x) < SIGNIFICANT * *sigma {
                    // Of an effect that is there, a part that is not seen to be: in a vertical hole the offset along the axis.
                    *x = 0.0;
                }
            }
            let [sum, count] = chosen.turned;
            *report = EffectReport {
                found: FoundEffect { index: chosen.index, parameters, sigma },
                evidence: chosen.evidence,
                p_value: chosen.p_value,
                size_rad: libm::sqrtf(if count > 0.0 { sum / count } else { 0.0 }),
                residual_rad: [chosen.residual_before_rad, chosen.residual_after_rad],
                believed: effect.parameters().iter().zip(&parameters).all(|(parameter, x)| parameter.believes(*x)),
            };
        }
        let verdict = if !enough {
            Verdict::NotEnoughExcitation
        } else if self.is_unexplained() {
            Verdict::UnexplainedResidual
        } else if !self.chosen.is_empty() {
            Verdict::EffectsFound
        } else {
            Verdict::ModelSufficient
        };
        DiagnosisReport {
            t_start_us: self.job.t_start_us,
            t_end_us: self.job.t_end_us,
            t_effect_us: 0,
            verdict,
            effects,
            count: if enough { self.chosen.len() as u8 } else { 0 },
            tried: self.tried,
            candidates: subject.library.len().min(MAX_CANDIDATES) as u8,
            residual_before_rad: self.residual_before_rad.unwrap_or(self.residual),
            residual_after_rad: self.residual,
            nis: [self.nis_before, self.left().0],
        }
    }

    /// Whether more is left of the field's residual than its noise, and more than matters little.
    fn is_unexplained(&self) -> bool {
        // Degrees of freedom: three components of every fourth test window, as they overlap.
        let freedom = 0.75 * self.usable as f32;
        let band = 1.0 + 1.96 * libm::sqrtf(2.0 / freedom);
        let (nis, residual_rad) = self.left();
        nis > band && residual_rad > LEAST_DRIFT_RAD
    }

    /// NIS and residual of the field with all effects in and P free.
    const fn left(&self) -> (f32, f32) {
        let [_, residual] = self.residual;
        if self.is_final { self.left } else { (self.nis, residual) }
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
