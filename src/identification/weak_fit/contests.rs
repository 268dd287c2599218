//! Contests between models of one window, about the magnetometer's errors and about the gyro's.

use super::WeakFit;
use crate::{
    algebra::{Packed, minus, quantile},
    identification::{
        contest::{MAX_GROUPS, MIN_GROUPS, Outcome},
        job::{Context, Job},
        judgement::with_rest_bias,
        least_squares::{self, Freedom, Known, MagnetometerErrors, Model},
        prior::theta_of,
    },
    window::{Equations, TESTS, TestEquations, TestWindows, gyro_part},
};
use core::ops::Range;

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

/// The gyro's models, as the contest about it counts them: P and bias; the bias with the flown P; nothing, but for the bias of a new
/// rest; the bias with the factory's P.
pub(crate) const FULL: usize = 0;
pub(crate) const FLOWN_P: usize = 1;
pub(crate) const NOTHING: usize = 2;
pub(crate) const FACTORY_P: usize = 3;

/// What a test window of six normal components exceeds once in a thousand, over what it exceeds three times of four (chi-square with 6
/// degrees of freedom): the quarter that is left least of tells of the others, of which many may be disturbed.
const ONCE_IN_A_THOUSAND: f32 = 22.46 / 3.45;

/// Most probable chance win from which an error of the magnetometer is kept. At 5 % a hard iron that is not there is kept in one window of
/// twenty, and makes the rate error up to five times larger, because it looks like a cross-coupling from the axis that turns.
const MAGNETOMETER_P_VALUE: f32 = 0.01;

impl WeakFit {
    /// Plays half of a group of the contest about the magnetometer, the `piece`th of all; `Some(false)` when there is none left, or no error
    /// of it can win any more.
    pub fn play_magnetometer(&mut self, context: &Context, tests: &TestWindows, piece: usize) -> Option<bool> {
        let groups = groups_of(filled(tests).count());
        let is_lost = |error: usize| self.contest.is_decided_against(error, error + 1, groups, MAGNETOMETER_P_VALUE);
        let is_over = self.contest.groups() > 0 && (0..2).all(is_lost);
        if is_over { Some(false) } else { self.play(context, tests, piece, &MAGNETOMETER_MODELS) }
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
    pub fn play_gyro(&mut self, context: &Context, job: &Job, tests: &TestWindows, piece: usize) -> Option<bool> {
        let factory = theta_of(&context.config.gyro);
        let (rested, _) = with_rest_bias(context, job);
        let models = [
            Freedom::Full,
            Freedom::Bias([0.0; 9]),
            Freedom::Held(minus(&theta_of(&rested), &self.theta)),
            Freedom::Bias(p_part(&minus(&factory, &self.theta))),
        ]
        .map(|freedom| Model { freedom, magnetometer: self.magnetometer });
        // As long as the factory's P flies the last is the second again, and nobody asks for it.
        let flies_factory = context.flown.p == context.config.gyro.p;
        let models = models.get(..FACTORY_P).filter(|_| flies_factory).unwrap_or(&models);
        if self.is_judged_by_rests(context) {
            let about = (&self.base, &self.theta);
            return self.rests.play(context, piece, models, about, &mut self.contest);
        }
        self.play(context, tests, piece, models)
    }

    /// Whether pairs of rests take the place of test windows in the contest about the gyro.
    fn is_judged_by_rests(&self, context: &Context) -> bool {
        let [_, field] = self.seen;
        field == 0 && self.rests.suffices(context)
    }

    /// Takes in what pairs of rests teach, where they judge. It is not carried on: the next window has most of the pairs too.
    pub fn learn_from_rests(&mut self, context: &Context) -> Option<()> {
        if self.is_judged_by_rests(context) {
            self.rests.teach(context, (&self.base, &self.theta), &mut self.prior, &mut self.between)?;
            self.solution = self.fit(&Model::full(self.magnetometer))?;
        }
        Some(())
    }

    /// Covariance of the fit by the jackknife of the contest.
    pub fn jackknife(&self) -> Packed<12, 78> {
        self.contest.covariance(self.rests.taken)
    }

    /// What the contest says of P and bias against the bias with the flown P; where pairs of rests judge, with the share that `theta`, which
    /// they taught, explains.
    pub fn outcome(&self, context: &Context, theta: &[f32; 12]) -> Outcome {
        let mut outcome = self.contest.between(FULL, FLOWN_P);
        if self.is_judged_by_rests(context) {
            let change = minus(theta, &self.theta);
            outcome.explained = self.rests.explained(&self.between, &change);
        }
        outcome
    }

    /// First the models are fitted to the equations of all but the group, then the group is predicted.
    fn play(&mut self, context: &Context, tests: &TestWindows, piece: usize, models: &[Model]) -> Option<bool> {
        let count = filled(tests).count();
        let groups = groups_of(count);
        let group = piece / 2;
        if group >= groups {
            return Some(false);
        }
        // Dealt out evenly, contiguous ones to a group.
        let share = |g: usize| (g * count).checked_div(groups).unwrap_or(0);
        let mine = share(group)..share(group + 1);
        if piece.is_multiple_of(2) {
            let others = self.all_but(tests, &mine);
            // Not `known()`: the contest is borrowed beside it.
            let known = Known { variances: &self.variances, base: &self.base, prior: &self.prior, theta: &self.theta };
            self.contest.fit(&others, models, &known)?;
        } else {
            let known = Known { variances: &self.variances, base: &self.base, prior: &self.prior, theta: &self.theta };
            let mut witnesses = filled(tests).skip(mine.start).take(mine.len()).map(|(_, test)| test);
            // Three equations. Of a reference's vectors all that is left counts as noise: they have no errors that P could be taken for.
            let of_sensor = 3.0 * self.weights.sensor_noise() / self.variances.field;
            let is_exact = context.config.identification.vectors_from_reference;
            let noise = if is_exact { f32::INFINITY } else { of_sensor };
            let limits = (self.disturbed, [0.0, noise]);
            self.contest.play(&mut witnesses, limits, models.len(), &known, &gyro_part(&self.solution))?;
            if filled(tests).nth(mine.start).is_some_and(|(number, _)| number < self.taught_tests) {
                self.contest.not_fresh();
            }
        }
        Some(true)
    }

    /// The equations of all test windows but those of a group and their neighbours, which share samples with it and so do not teach. Groups are
    /// asked for one after the other: the test windows about the border of two are summed once for both.
    #[inline(never)]
    fn all_but(&mut self, tests: &TestWindows, mine: &Range<usize>) -> Equations {
        let mut others = self.total;
        let (theta, weights) = (&self.theta, &self.weights);
        let add = |sum: &mut Equations, range: Range<usize>, sign: f32| {
            for (number, test) in filled(tests).skip(range.start).take(range.len()) {
                sum.add(test, theta, weights.of(number).map(|weight| sign * weight));
            }
        };
        let mut done = 0;
        if mine.start > 0 {
            others.subtract(&self.between);
            done = mine.start + OVERLAPPING;
        }
        let border = mine.end.saturating_sub(OVERLAPPING);
        add(&mut others, done..border, -1.0);
        self.between = Equations::zero();
        add(&mut self.between, border..mine.end + OVERLAPPING, 1.0);
        others.subtract(&self.between);
        // A small group's borders overlap, and what is in both was taken out twice.
        add(&mut others, border..done, 1.0);
        others
    }

    /// From how much P and bias leave in each test window: what is beyond doubt. Of a reference's vectors, without noise, P leaves next to
    /// nothing where the tool hardly turns, and what the bias alone leaves tells.
    pub fn measure_doubt(&mut self, context: &Context, tests: &TestWindows) -> Option<()> {
        let is_exact = context.config.identification.vectors_from_reference;
        let freedom = if is_exact { Freedom::Bias([0.0; 9]) } else { Freedom::Full };
        let x = self.fit(&Model { freedom, magnetometer: self.magnetometer })?;
        let mut misfits = [0.0; TESTS];
        let mut count = 0;
        for (_, test) in filled(tests) {
            if let Some(slot) = misfits.get_mut(count) {
                let [[gravity], [field]] = least_squares::test_misfits(test, &self.known(), &[x]);
                *slot = gravity + field;
                count += 1;
            }
        }
        self.disturbed = ONCE_IN_A_THOUSAND * quantile(misfits.get_mut(..count).unwrap_or_default(), 0.25);
        Some(())
    }
}

/// The test windows that say something, with their numbers.
fn filled(tests: &TestWindows) -> impl Iterator<Item = (usize, &TestEquations)> {
    tests.numbered().filter(|(_, test)| !test.is_empty())
}

/// How many groups so many of them make.
fn groups_of(count: usize) -> usize {
    (count / TESTS_PER_GROUP).min(MAX_GROUPS)
}

/// The part of P of a theta.
fn p_part(theta: &[f32; 12]) -> [f32; 9] {
    let [p @ .., _, _, _] = theta;
    *p
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hard_iron_has_to_show_but_where_a_magnet_came_or_left() {
        let mut weak = WeakFit::zero();
        weak.magnetometer = MagnetometerErrors::Lag;
        weak.choose_magnetometer(false);
        assert_eq!(weak.magnetometer, MagnetometerErrors::None, "nothing shows in a contest without groups");
        weak.choose_magnetometer(true);
        assert_eq!(weak.magnetometer, MagnetometerErrors::LagAndIron);
    }
}
