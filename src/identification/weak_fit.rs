mod contests;

use super::{
    Carried, Prior,
    contest::Contest,
    job::{Context, Job},
    least_squares::{self, Known, MagnetometerErrors, Model, NormalEquations, RowVariances},
    prior::theta_of,
    rest_evidence::RestEvidence,
    robust_weights::{RobustWeights, Round},
};
use crate::window::{Equations, MAGNETIC, TestEquations, TestWindows, UNDER_WAY};
pub(crate) use contests::{FACTORY_P, FLOWN_P, FULL, NOTHING};

/// Test windows that are gone through in one piece of work.
const SLICE: usize = 16;

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
    /// Length of the test windows, in quarters of the longest.
    pub quarters: usize,
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
    /// Those of the test windows at the end of the group played last and at the beginning of the next; in the end those of the pairs of rests.
    between: Equations,
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
            quarters: 0,
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
            between: Equations::zero(),
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
        self.quarters = UNDER_WAY;
        // A reference's vectors have no noise by which a disturbance could be told.
        self.measured = context.config.identification.vectors_from_reference;
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

    /// Too little weight is left: whether it helps to begin again, with test windows of half the length. Of those that lie between
    /// disturbances there are more. After the shortest all of the longest count again: what bends them is no disturbance here and there but
    /// the rule.
    pub fn begin_again(&mut self) -> bool {
        if !self.weights.is_running() {
            return false;
        }
        self.weights.start();
        self.measured = self.quarters == 1;
        self.quarters = if self.measured { UNDER_WAY } else { self.quarters / 2 };
        true
    }

    /// Whether an increment is disturbed: every test window that holds its half second has lost more than half of its weight.
    #[inline(never)]
    pub fn distrusts(&self, increment: usize, hop: usize) -> bool {
        let (end, tests) = (increment.checked_div(hop).unwrap_or(0) + 1, self.tests as usize);
        let first = end.saturating_sub(self.quarters);
        first < tests && (first..end.min(tests)).all(|number| self.weights.of(number)[1] < 0.5)
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
        NormalEquations::new(&self.total, &self.variances).solve(&self.known(), model)
    }

    /// What earlier windows taught, aged to the middle of the window.
    pub const fn carried(&self) -> &Carried {
        &self.carried
    }

    fn known(&self) -> Known<'_> {
        Known { variances: &self.variances, base: &self.base, prior: &self.prior, theta: &self.theta }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_too_few_agree_shorter_test_windows_are_tried_and_after_the_shortest_all_of_the_longest_count() {
        let (mut weak, tests) = (WeakFit::zero(), TestWindows::zero());
        weak.quarters = UNDER_WAY;
        assert!(!weak.begin_again(), "there were no weights");
        for quarters in [2, 1, UNDER_WAY] {
            assert!(!weak.measured);
            weak.weights = RobustWeights::begun();
            assert!(weak.begin_again());
            assert_eq!((weak.quarters, weak.weights.of(0)), (quarters, [1.0; 2]));
            assert!(!weak.weights.is_running());
        }
        assert_eq!(weak.next_weights(&tests), Round::Done);
        assert!(!weak.begin_again());
    }
}
