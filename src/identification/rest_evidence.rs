//! Pairs of rests as evidence: gravity that the gyro carried from one to the other, in the place of test windows in which the hand's
//! accelerations are.

use super::{
    Prior,
    contest::{Contest, MAX_GROUPS, MIN_GROUPS},
    job::{Context, Job},
    least_squares::{Freedom, Known, MagnetometerErrors, Model, NormalEquations, RowVariances},
};
use crate::window::{Equations, MAGNETIC, RestPair, TestEquations, gyro_part};

/// The equations of a pair are over their deviation already.
const UNIT: RowVariances = RowVariances { gravity: 1.0, field: 1.0 };

/// Which pairs of rests a window is judged by.
pub(crate) struct RestEvidence {
    /// Pairs that came before the window closed; 0: none is to be used.
    until: u32,
    /// End of what the P that flies was learnt from.
    p_known_us: u64,
}

impl RestEvidence {
    pub const fn none() -> Self {
        Self { until: 0, p_known_us: 0 }
    }

    /// Gravity alone judges only with a calibration of the accelerometer on record.
    pub fn new(context: &Context, job: &Job) -> Self {
        let until = if context.accelerometer_on_record() { job.rest_pairs } else { 0 };
        Self { until, p_known_us: job.p_known_us }
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
            for (_, pair) in self.pairs(context).enumerate().filter(|(number, _)| !mine.contains(number)) {
                others.add(&equations(pair), theta, [1.0; 2]);
            }
            contest.fit(&others, models, &known)?;
        } else {
            let mine = self.pairs(context).skip(mine.start).take(mine.len());
            let mut tests = [TestEquations::zero(); 2];
            for (test, pair) in tests.iter_mut().zip(mine.clone()) {
                *test = equations(pair);
            }
            contest.play(&mut tests.iter(), f32::INFINITY, models.len(), &known, &[0.0; 12])?;
            if mine.clone().any(|pair| pair.t_us <= self.p_known_us) {
                contest.not_fresh();
            }
        }
        Some(true)
    }

    /// The share of what the bias alone leaves in all pairs that a change of theta, which flies so far, explains there.
    #[inline(never)]
    pub fn explained(&self, context: &Context, (base, theta): (&Prior, &[f32; 12]), change: &[f32; 12]) -> f32 {
        let mut sum = Equations::zero();
        self.pairs(context).for_each(|pair| sum.add(&equations(pair), theta, [1.0; 2]));
        let known = Known { variances: &UNIT, base, prior: base, theta };
        let bias = Model { freedom: Freedom::Bias([0.0; 9]), magnetometer: MagnetometerErrors::None };
        let bias = NormalEquations::new(&sum, known.variances).solve(&known, &bias).unwrap_or([0.0; MAGNETIC]);
        1.0 - sum.gravity.misfit(change) / sum.gravity.misfit(&gyro_part(&bias))
    }
}

fn equations(pair: &RestPair) -> TestEquations {
    TestEquations { gravity: pair.rows, ..TestEquations::zero() }
}
