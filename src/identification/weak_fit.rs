use super::{
    Carried, LEAST_EXPLAINED, Prior,
    contest::{Contest, MAX_GROUPS, MIN_GROUPS, Outcome},
    job::{Context, Job},
    least_squares::{self, Freedom, Known, MagnetometerErrors, Model, RowVariances},
    prior::theta_of,
    rest_evidence::RestEvidence,
    robust_weights::{RobustWeights, Round},
};
use crate::{
    algebra::{minus, quantile},
    window::{Equations, MAGNETIC, TESTS, TestEquations, TestWindows, gyro_part},
};

/// Test windows that are gone through in one piece of work.
const SLICE: usize = 16;

/// Fewest test windows in a group: 2.5 s, longer than the motion is correlated.
const TESTS_PER_GROUP: usize = 5;

/// Test windows after one that begin before it ends.
const OVERLAPPING: usize = 3;

/// Models of the magnetometer that compete before P is judged.
const MAGNETOMETER_MODELS: [Model; 3] = [
    Model::full(MagnetometerErrors::LagAndIron),
    Model::full(MagnetometerErrors::Lag),
    Model::full(MagnetometerErrors::None),
];

/// The gyro's models, as the contest about it counts them: P and bias; the bias with the flown P; nothing; the bias with the factory's
/// P.
pub(crate) const FULL: usize = 0;
pub(crate) const FLOWN_P: usize = 1;
pub(crate) const NOTHING: usize = 2;
pub(crate) const FACTORY_P: usize = 3;

/// What a test window of six normal components exceeds once in a thousand, over what it exceeds every other time (chi-square with 6
/// degrees of freedom).
const ONCE_IN_A_THOUSAND: f32 = 22.46 / 5.35;

/// Most probable chance win from which an error of the magnetometer is kept. At 5 % a hard iron that is not there is kept in one window of
/// twenty, and makes the rate error up to five times larger, because it looks like a cross-coupling from the axis that turns.
const MAGNETOMETER_P_VALUE: f32 = 0.01;

/// The weak form of one window: its normal equations, what is known beforehand, the solution, and the contests between models of
/// it.
pub(crate) struct WeakFit {
    /// What the equations are about: the model flown when the window closed.
    pub theta: [f32; 12],
    /// Factory and rest.
    base: Prior,
    /// What earlier windows taught, aged.
    carried: Carried,
    /// Both.
    pub prior: Prior,
    pub total: Equations,
    /// A test window in which neither P and bias nor the bias alone comes nearer than this is disturbed beyond doubt and no witness
    /// in the contests; a weighted sum of squares.
    disturbed: f32,
    weights: RobustWeights,
    /// Whether the weights have been begun with.
    measured: bool,
    /// Test windows of the fit, how many of them lacked a rate, and how many hold gravity and the field.
    tests: u32,
    spoilt: u32,
    pub seen: [u32; 2],
    /// Test windows that begin before the end of what the P that flies was learnt from.
    taught_tests: usize,
    pub solution: [f32; MAGNETIC],
    pub variances: RowVariances,
    pub magnetometer: MagnetometerErrors,
    pub contest: Contest,
    /// The pairs of rests that judge in the place of test windows.
    pub(super) rests: RestEvidence,
    /// The equations of all but the group that is being played.
    others: Equations,
}

impl WeakFit {
    pub const fn zero() -> Self {
        Self {
            theta: [0.0; 12],
            base: Prior::zero(),
            carried: Carried::nothing(),
            prior: Prior::zero(),
            total: Equations::zero(),
            disturbed: 0.0,
            weights: RobustWeights::zero(),
            measured: false,
            tests: 0,
            spoilt: 0,
            seen: [0; 2],
            taught_tests: 0,
            solution: [0.0; MAGNETIC],
            variances: RowVariances { gravity: 0.0, field: 0.0 },
            magnetometer: MagnetometerErrors::None,
            contest: Contest::zero(),
            rests: RestEvidence::none(),
            others: Equations::zero(),
        }
    }

    /// Begins with what earlier windows taught, `carried`, aged to the middle of the window.
    pub fn start(&mut self, context: &Context, job: &Job, carried: &Carried) {
        self.theta = theta_of(context.flown);
        self.base = Prior::new(&context.config.identification, &context.config.gyro, job.rest.as_ref());
        self.rests = RestEvidence::new(context, job);
        self.carried = *carried;
        self.prior = self.base.with(carried);
        self.weights.start();
        self.measured = false;
        self.taught_tests = taught_tests(context, job);
        // A hard iron that is free bends to disturbances, and hides them.
        self.magnetometer = MagnetometerErrors::Lag;
        self.contest = Contest::zero();
    }

    /// Share of the test windows that lacked a rate; 0 of none.
    pub fn spoilt_share(&self) -> f32 {
        if self.tests == 0 { 0.0 } else { self.spoilt as f32 / self.tests as f32 }
    }

    /// Adds slice `slice` of the test windows; false when there is none left.
    pub fn sum(&mut self, tests: &TestWindows, slice: usize) -> bool {
        if slice == 0 {
            self.total = Equations::zero();
            (self.tests, self.spoilt, self.seen) = (0, 0, [0; 2]);
        }
        let mut more = false;
        for (number, test) in slice_of(tests, slice) {
            more = true;
            self.total.add(test, &self.theta, self.weights.of(number));
            self.tests += 1;
            self.spoilt += u32::from(test.spoilt);
            let [gravity, field] = &mut self.seen;
            *gravity += u32::from(test.gravity.is_some());
            *field += u32::from(test.field.is_some());
        }
        more
    }

    /// One round of solving the window by itself; `None` when it cannot be.
    pub fn solve_alone(&mut self, round: u8) -> Option<()> {
        let before = (round > 0).then_some(&self.solution);
        let alone =
            least_squares::solve_with_variances(&self.total, &self.base, &self.theta, self.magnetometer, before);
        (self.solution, self.variances) = alone?;
        Some(())
    }

    /// So little weight is left that nothing can be solved: whether it helps to begin again without weights.
    pub fn begin_again(&mut self) -> bool {
        let weighted = self.weights.is_running();
        if weighted {
            self.weights.start();
        }
        weighted
    }

    /// After a solution: what is next for the weights.
    pub fn next_weights(&mut self, tests: &TestWindows) -> Round {
        if self.measured {
            return if self.weights.is_running() { self.weights.advance(tests) } else { Round::Done };
        }
        self.measured = true;
        self.weights.measure(tests, &self.theta, &self.solution);
        if self.weights.is_running() { Round::Next } else { Round::Done }
    }

    /// Weighs slice `slice` of the test windows by their residuals; false when there is none left.
    pub fn weigh(&mut self, tests: &TestWindows, slice: usize) -> bool {
        let mut some = slice_of(tests, slice).peekable();
        let more = some.peek().is_some();
        self.weights.weigh(some, &self.theta, &self.solution, &mut self.total);
        more
    }

    /// Once the window is solved by itself, and so its variances known: with what earlier windows taught.
    pub fn solve(&mut self) -> Option<()> {
        self.contest = Contest::zero();
        if !self.carried.is_empty() {
            self.solution = self.fit(&Model::full(self.magnetometer))?;
        }
        Some(())
    }

    /// The fit of a model to the whole window.
    pub fn fit(&self, model: &Model) -> Option<[f32; MAGNETIC]> {
        least_squares::solve(&self.total, &self.known(), model)
    }

    /// What earlier windows taught, aged to the middle of the window.
    pub const fn carried(&self) -> &Carried {
        &self.carried
    }

    fn known(&self) -> Known<'_> {
        Known { variances: &self.variances, base: &self.base, prior: &self.prior, theta: &self.theta }
    }

    /// Plays a third of a group of the contest about the magnetometer, the `piece`th of all; `Some(false)` when there is none left.
    pub fn play_magnetometer(&mut self, tests: &TestWindows, piece: usize) -> Option<bool> {
        self.play(tests, piece, &MAGNETOMETER_MODELS)
    }

    /// Keeps those errors of the magnetometer that predict unseen test windows better; the window is to be solved again with them. An error that
    /// is there and left out bends P; one that is not there and kept only costs precision (a hard iron looks like a
    /// cross-coupling from the axis that turns). Where a magnet has come to the probe or left it the hard iron stays: what is taken out of the
    /// field for it has an error.
    pub fn choose_magnetometer(&mut self, magnet_moved: bool) {
        let enough = self.contest.groups() >= MIN_GROUPS;
        let shows = |outcome: Outcome| enough && outcome.p_value <= MAGNETOMETER_P_VALUE;
        self.magnetometer = if magnet_moved || shows(self.contest.between(0, 1)) {
            MagnetometerErrors::LagAndIron
        } else if shows(self.contest.between(1, 2)) {
            MagnetometerErrors::Lag
        } else {
            MagnetometerErrors::None
        };
    }

    /// The same of the contest about the gyro.
    pub fn play_gyro(&mut self, context: &Context, tests: &TestWindows, piece: usize) -> Option<bool> {
        let factory = theta_of(&context.config.gyro);
        let models = [
            Freedom::Full,
            Freedom::Bias([0.0; 9]),
            Freedom::Nothing,
            Freedom::Bias(p_part(&minus(&factory, &self.theta))),
        ]
        .map(|freedom| Model { freedom, magnetometer: self.magnetometer });
        if self.is_judged_by_rests(context) {
            let about = (&self.base, &self.theta);
            return self.rests.play(context, piece, &models, about, &mut self.contest, &mut self.others);
        }
        self.play(tests, piece, &models)
    }

    /// Whether pairs of rests take the place of test windows in the contest about the gyro.
    fn is_judged_by_rests(&self, context: &Context) -> bool {
        let [_, field] = self.seen;
        field == 0 && self.rests.suffices(context)
    }

    /// The share of the misfit of pairs of rests that `theta` itself explains, where they judge and it is too little.
    pub fn too_little_explained(&self, context: &Context, theta: &[f32; 12]) -> Option<f32> {
        let change = minus(theta, &self.theta);
        let explained = self.rests.explained(context, (&self.base, &self.theta), &change);
        // Asked for what passes, so that a NaN does not.
        let passes = explained >= LEAST_EXPLAINED;
        (self.is_judged_by_rests(context) && !passes).then_some(explained)
    }

    /// First the equations of all but the group are summed, then the models are fitted to them, then the group is predicted.
    fn play(&mut self, tests: &TestWindows, piece: usize, models: &[Model]) -> Option<bool> {
        let filled = || tests.numbered().filter(|(_, test)| !test.is_empty());
        let count = filled().count();
        let groups = (count / TESTS_PER_GROUP).min(MAX_GROUPS);
        let group = piece / 3;
        if group >= groups {
            return Some(false);
        }
        // Dealt out evenly, contiguous ones to a group.
        let share = |g: usize| (g * count).checked_div(groups).unwrap_or(0);
        let mine = share(group)..share(group + 1);
        // Not `known()`: the contest is borrowed beside it.
        let known = Known { variances: &self.variances, base: &self.base, prior: &self.prior, theta: &self.theta };
        match piece % 3 {
            0 => {
                // Neighbours that share samples with the group do not teach.
                let from = mine.start.saturating_sub(OVERLAPPING);
                self.others = self.total;
                for (number, test) in filled().skip(from).take(mine.end + OVERLAPPING - from) {
                    self.others.add(test, &self.theta, self.weights.of(number).map(|weight| -weight));
                }
            }
            1 => self.contest.fit(&self.others, models, &known)?,
            _ => {
                let mut witnesses = filled().skip(mine.start).take(mine.len()).map(|(_, test)| test);
                self.contest.play(&mut witnesses, self.disturbed, models.len(), &known, &gyro_part(&self.solution))?;
                if filled().nth(mine.start).is_some_and(|(number, _)| number < self.taught_tests) {
                    self.contest.not_fresh();
                }
            }
        }
        Some(true)
    }

    /// From how much the bias alone leaves in each test window: what is beyond doubt.
    pub fn measure_doubt(&mut self, tests: &TestWindows) -> Option<()> {
        let x = self.fit(&Model { freedom: Freedom::Bias([0.0; 9]), magnetometer: self.magnetometer })?;
        let mut misfits = [0.0; TESTS];
        let mut count = 0;
        for test in tests.all().filter(|test| !test.is_empty()) {
            if let Some(slot) = misfits.get_mut(count) {
                [*slot] = least_squares::test_misfits(test, &self.known(), &[x]);
                count += 1;
            }
        }
        self.disturbed = ONCE_IN_A_THOUSAND * quantile(misfits.get_mut(..count).unwrap_or_default(), 0.5);
        Some(())
    }
}

/// Some of the test windows, to be gone through in one piece of work, with their numbers.
fn slice_of(tests: &TestWindows, slice: usize) -> impl Iterator<Item = (usize, &TestEquations)> {
    tests.numbered().skip(slice * SLICE).take(SLICE)
}

/// How many of the window's test windows begin before the end of what the P that flies was learnt from.
fn taught_tests(context: &Context, job: &Job) -> usize {
    let stream = context.stream;
    let hop_us = u64::from(stream.grid.interval_us) * stream.test_function.hop() as u64;
    job.p_known_us.saturating_sub(job.t_start_us).div_ceil(hop_us.max(1)) as usize
}

/// The part of P of a theta.
fn p_part(theta: &[f32; 12]) -> [f32; 9] {
    let [p @ .., _, _, _] = theta;
    *p
}
