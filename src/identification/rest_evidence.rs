//! Pairs of rests as evidence: gravity that the gyro carried from one to the other holds none of the hand's accelerations, which are in
//! test windows and in innovations.

use super::{
    Prior,
    contest::{Contest, MAX_GROUPS, MIN_GROUPS},
    job::{Context, Job},
    least_squares::{Freedom, Known, MagnetometerErrors, Model, NormalEquations, RowVariances},
};
use crate::{
    algebra::plus,
    window::{Equations, RestPair, TestEquations, gyro_part},
};
use core::ops::Range;

/// The equations of a pair are over their deviation already.
const UNIT: RowVariances = RowVariances { gravity: 1.0, field: 1.0 };

/// A direction has two components.
const COMPONENTS: f32 = 2.0;

/// Unknowns of a fit of P and bias.
const UNKNOWNS: f32 = 12.0;
/// Of one of the bias alone.
const UNKNOWNS_OF_BIAS: f32 = 3.0;

/// Which pairs of rests a window is judged by.
pub(crate) struct RestEvidence {
    /// Pairs that came before the window closed; 0: none is to be used.
    until: u32,
    /// End of what the P that flies was learnt from.
    p_known_us: u64,
    /// Share of the equations that a fit of P and bias takes up; 0 where the pairs do not judge.
    pub taken: f32,
    /// What a square that is left by one is of the variance that the bias alone leaves.
    share_of_square: f32,
}

impl RestEvidence {
    pub const fn none() -> Self {
        Self { until: 0, p_known_us: 0, taken: 0.0, share_of_square: 0.0 }
    }

    /// Gravity alone judges only with a calibration of the accelerometer on record.
    pub fn new(context: &Context, job: &Job) -> Self {
        let until = if context.accelerometer_on_record() { job.rest_pairs } else { 0 };
        Self { until, p_known_us: job.p_known_us, ..Self::none() }
    }

    fn pairs<'a>(&self, context: &Context<'a>) -> impl Iterator<Item = &'a RestPair> + Clone + use<'a> {
        context.stream.rest_pairs.until(self.until)
    }

    /// Whether there are enough for every one to be a group of the contest.
    pub fn suffices(&self, context: &Context) -> bool {
        self.pairs(context).count() >= MIN_GROUPS
    }

    /// Plays half of a group of the contest, the `piece`th of all; `Some(false)` when there is none left. Every model is fitted to the other
    /// pairs and what was known before any of them, `base`.
    pub fn play(
        &self,
        context: &Context,
        piece: usize,
        models: &[Model],
        (base, theta): (&Prior, &[f32; 12]),
        contest: &mut Contest,
    ) -> Option<bool> {
        let count = self.pairs(context).count();
        let groups = count.min(MAX_GROUPS);
        let group = piece / 2;
        if group >= groups {
            return Some(false);
        }
        let share = |g: usize| (g * count).checked_div(groups).unwrap_or(0);
        let mine = share(group)..share(group + 1);
        let known = Known { variances: &UNIT, base, prior: base, theta };
        if piece.is_multiple_of(2) {
            let mut others = Equations::zero();
            self.sum(context, theta, &mine, &mut others);
            contest.fit(&others, models, &known)?;
        } else {
            let mine = self.pairs(context).skip(mine.start).take(mine.len());
            let mut tests = [TestEquations::zero(); 2];
            for (test, pair) in tests.iter_mut().zip(mine.clone()) {
                *test = equations(pair);
            }
            contest.play(&mut tests.iter(), (f32::INFINITY, [COMPONENTS, 0.0]), models.len(), &known, &[0.0; 12])?;
            if mine.clone().any(|pair| pair.t_us <= self.p_known_us) {
                contest.not_fresh();
            }
        }
        Some(true)
    }

    /// Sums the equations of all pairs but `without`.
    #[inline(never)]
    fn sum(&self, context: &Context, theta: &[f32; 12], without: &Range<usize>, sum: &mut Equations) {
        *sum = Equations::zero();
        for (_, pair) in self.pairs(context).enumerate().filter(|(number, _)| !without.contains(number)) {
            sum.add(&equations(pair), theta, [1.0; 2]);
        }
    }

    /// Adds to `prior` what the pairs teach, with the variance that they show where that exceeds their own; their equations are left in `sum`.
    #[inline(never)]
    pub fn teach(
        &mut self,
        context: &Context,
        (base, theta): (&Prior, &[f32; 12]),
        prior: &mut Prior,
        sum: &mut Equations,
    ) -> Option<()> {
        self.sum(context, theta, &(0..0), sum);
        let known = Known { variances: &UNIT, base, prior, theta };
        let normal = NormalEquations::new(sum, &UNIT);
        let solution = |freedom| normal.solve(&known, &Model { freedom, magnetometer: MagnetometerErrors::None });
        let full = gyro_part(&solution(Freedom::Full)?);
        let bias = gyro_part(&solution(Freedom::Bias([0.0; 9]))?);
        // A pair makes two equations: along gravity it says nothing.
        let equations = sum.gravity.rows * (COMPONENTS / 3.0);
        let free = equations - UNKNOWNS;
        if free <= 0.0 {
            return None;
        }
        self.taken = UNKNOWNS / equations;
        self.share_of_square = (equations - UNKNOWNS_OF_BIAS) / (free * sum.gravity.misfit(&bias));
        let square = sum.gravity.misfit(&full);
        prior.learn(&sum.gravity.normal, if square > free { free / square } else { 1.0 }, plus(theta, &full));
        Some(())
    }

    /// The share of the variance that the bias alone leaves in the pairs, which a change of theta that they taught explains; `sum` is what that
    /// left. Variance is per equation that is left free (Theil's adjusted coefficient of determination), since a fit of twelve unknowns to two
    /// dozen equations predicts an unseen one with twice the variance even if all that is wrong is P.
    pub fn explained(&self, sum: &Equations, change: &[f32; 12]) -> f32 {
        1.0 - sum.gravity.misfit(change) * self.share_of_square
    }
}

fn equations(pair: &RestPair) -> TestEquations {
    TestEquations { gravity: pair.rows, ..TestEquations::zero() }
}
