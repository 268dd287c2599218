use super::least_squares::{Known, Model, NormalEquations, test_misfits};
use crate::{
    algebra::Packed,
    window::{Equations, MAGNETIC, TestEquations, gyro_part},
};

/// Most groups of contiguous blocks: 2^10 sign patterns can be counted exactly.
pub(crate) const MAX_GROUPS: usize = 10;

/// Fewest groups: below it not even a win on every group is rarer than the limit of the p-value (2^-7 = 0.008).
pub(crate) const MIN_GROUPS: usize = 7;

/// Most models in a contest.
const MODELS: usize = 4;

/// Blocked cross-validation of models, the richest first: each group of contiguous, moving test windows is predicted by fits to
/// the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contest {
    /// Whitened misfit of each model on each unseen group.
    losses: [[f32; MAX_GROUPS]; MODELS],
    /// Gravity's part of it on all groups, where a field was read beside it.
    of_gravity: [f32; MODELS],
    /// What the sensor's own noise makes of the rest.
    noise: f32,
    groups: usize,
    /// The first group of which no sample taught the P that flies.
    fresh_from: usize,
    /// The models' fits to all but the next group.
    fits: [[f32; MAGNETIC]; MODELS],
    /// Sum over the groups of the richest fit without the group minus that to everything: first and second moment.
    shift: [f32; 12],
    scatter: Packed<12, 78>,
}

/// What a contest between two of the models says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outcome {
    /// Probability of so large a total gain if the sign of each group's gain were a coin's (exact sign-flip permutation).
    pub p_value: f32,
    /// Share of the loser's misfit on unseen groups that the winner explains.
    pub explained: f32,
    /// On all groups, what the winner leaves of the field's misfit over what the sensor's own noise makes of it.
    pub over_noise: f32,
    /// On all groups, by how much the winner's misfit to gravity is larger than the loser's, where a field was read.
    pub objection: f32,
}

impl Contest {
    pub const fn zero() -> Self {
        Self {
            losses: [[0.0; MAX_GROUPS]; MODELS],
            of_gravity: [0.0; MODELS],
            noise: 0.0,
            groups: 0,
            fresh_from: 0,
            fits: [[0.0; MAGNETIC]; MODELS],
            shift: [0.0; 12],
            scatter: Packed::zero(),
        }
    }

    pub const fn groups(&self) -> usize {
        self.groups
    }

    /// Fits the models to the equations of all but the next group; `None` when a fit fails.
    pub fn fit(&mut self, others: &Equations, models: &[Model], known: &Known) -> Option<()> {
        let equations = NormalEquations::new(others, known.variances);
        for (fit, model) in self.fits.iter_mut().zip(models) {
            *fit = equations.solve(known, model)?;
        }
        Some(())
    }

    /// Plays that group, with the fits of `models` models: `witnesses`, the group's test windows, without those that are beyond `disturbed`
    /// with both of the first two; `noise`, what the sensor's own makes of the misfit of one to gravity, where no field was read, and to the
    /// field, 0 where that is not known; `everything`, the richest model's fit to all.
    pub fn play(
        &mut self,
        witnesses: &mut dyn Iterator<Item = &TestEquations>,
        (disturbed, noise): (f32, [f32; 2]),
        models: usize,
        known: &Known,
        everything: &[f32; 12],
    ) -> Option<()> {
        let mut fits = self.fits;
        fits.iter_mut().skip(models).for_each(|none| *none = [0.0; MAGNETIC]);
        let mut sums = [0.0; MODELS];
        for test in witnesses {
            let [gravity, field] = test_misfits(test, known, &fits);
            let ([g_richest, g_second, ..], [f_richest, f_second, ..]) = (gravity, field);
            if g_richest + f_richest > disturbed && g_second + f_second > disturbed {
                continue;
            }
            add(&mut sums, &gravity);
            add(&mut sums, &field);
            let [gravity_noise, field_noise] = noise;
            if test.field.is_some() {
                add(&mut self.of_gravity, &gravity);
                self.noise += field_noise;
            } else {
                self.noise += gravity_noise;
            }
        }
        for (losses, sum) in self.losses.iter_mut().zip(sums) {
            *losses.get_mut(self.groups)? = sum;
        }
        let [richest, ..] = fits;
        let mut change = gyro_part(&richest);
        for ((c, e), s) in change.iter_mut().zip(everything).zip(&mut self.shift) {
            *c -= e;
            *s += *c;
        }
        self.scatter.add_outer(&change, 1.0);
        self.groups += 1;
        Some(())
    }

    /// Of model number `winner` against `loser`, counted from 0.
    pub fn between(&self, winner: usize, loser: usize) -> Outcome {
        self.outcome(winner, loser, 0)
    }

    /// The same on the groups of which no sample taught the P that flies.
    pub fn between_on_fresh(&self, winner: usize, loser: usize) -> Outcome {
        self.outcome(winner, loser, self.fresh_from)
    }

    /// How many those are.
    pub const fn fresh_groups(&self) -> usize {
        self.groups.saturating_sub(self.fresh_from)
    }

    /// The groups played so far hold samples that taught the P that flies.
    pub const fn not_fresh(&mut self) {
        self.fresh_from = self.groups;
    }

    /// Whether `winner` cannot win beyond chance any more, once `groups` are played: on those to come its gains may be as large as they like,
    /// but in one pattern of so many all of them keep their signs, and among those the patterns of the gains so far are what they are.
    pub fn is_decided_against(&self, winner: usize, loser: usize, groups: usize, most_p_value: f32) -> bool {
        let to_come = groups.saturating_sub(self.groups).min(MAX_GROUPS);
        self.between(winner, loser).p_value > most_p_value * (1_u32 << to_come) as f32
    }

    fn outcome(&self, winner: usize, loser: usize, from: usize) -> Outcome {
        let (Some(of_winner), Some(of_loser)) = (self.losses.get(winner), self.losses.get(loser)) else {
            return Outcome { p_value: f32::NAN, explained: f32::NAN, over_noise: f32::NAN, objection: f32::NAN };
        };
        // A group before the first that counts has no gain, which has as many patterns of either sign.
        let mut gains = [0.0; MAX_GROUPS];
        let (mut won, mut lost) = (0.0, 0.0);
        for ((w, l), gain) in of_winner.iter().zip(of_loser).zip(&mut gains).take(self.groups).skip(from) {
            *gain = l - w;
            won += w;
            lost += l;
        }
        let explained = if lost > 0.0 { 1.0 - won / lost } else { 0.0 };
        let gravity = |index: usize| self.of_gravity.get(index).copied().unwrap_or(f32::NAN);
        Outcome {
            p_value: sign_flip_p_value(gains.get(..self.groups).unwrap_or_default()),
            explained,
            over_noise: (won - gravity(winner)) / self.noise,
            objection: gravity(winner) - gravity(loser),
        }
    }

    /// Covariance of the richest model's fit by the delete-a-group jackknife: (G - 1) / G times the scatter about the mean. It holds what
    /// the residuals' correlation and the missing effects do to the fit, which the normal matrix does not know. Of a fit that takes up a
    /// share `taken` of its equations it is too large by one over what is left (MacKinnon and White, Journal of Econometrics 29, 1985).
    pub fn covariance(&self, taken: f32) -> Packed<12, 78> {
        let groups = self.groups as f32;
        let mut covariance = Packed::zero();
        if self.groups < 2 {
            return covariance;
        }
        let scale = (1.0 - taken) * (groups - 1.0) / groups;
        covariance.add_scaled(&self.scatter, scale);
        covariance.add_outer(&self.shift, -scale / groups);
        covariance
    }
}

#[inline(never)]
fn add(sums: &mut [f32; MODELS], misfits: &[f32; MODELS]) {
    for (sum, misfit) in sums.iter_mut().zip(misfits) {
        *sum += misfit;
    }
}

/// Share of the 2^n sign patterns of the gains whose sum is at least the observed one (n at most [`MAX_GROUPS`]). Counted in
/// Gray's order: each pattern differs from the one before in one sign.
#[inline(never)]
fn sign_flip_p_value(gains: &[f32]) -> f32 {
    // A pattern and its opposite have opposite sums: half of them are gone through, the last gain's sign kept.
    let halves = ((1_u32 << gains.len()) / 2).max(1);
    // A thousand additions round; the observed pattern must count itself.
    let (observed, size) = gains.iter().fold((0.0, 0.0), |(sum, size), g| (sum + g, size + libm::fabsf(*g)));
    let tolerance = 1e-4 * size;
    let mut sum = observed;
    let opposite = |sum: f32| u32::from(-sum >= observed - tolerance);
    let mut as_large = 1 + opposite(sum);
    for pattern in 1..halves {
        sum += change(gains, pattern);
        as_large += u32::from(sum >= observed - tolerance) + opposite(sum);
    }
    as_large as f32 / (2 * halves) as f32
}

/// By how much the sum changes from the pattern before. Out of line: otherwise the loop is unrolled, to half a kilobyte of flash.
#[inline(never)]
fn change(gains: &[f32], pattern: u32) -> f32 {
    let flipped = pattern.trailing_zeros();
    let gain = gains.get(flipped as usize).copied().unwrap_or(0.0);
    // The sign that flips was negative when Gray's code had its bit set before.
    let was_negative = (pattern - 1) ^ (pattern - 1) >> 1;
    if was_negative >> flipped & 1 == 1 { 2.0 * gain } else { -2.0 * gain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    #[test]
    fn what_is_left_over_noise_is_the_fields_alone_and_gravity_objects_by_its_own() {
        let mut contest = Contest::zero();
        contest.groups = 8;
        contest.losses[0] = [4.0; MAX_GROUPS];
        contest.losses[1] = [7.0; MAX_GROUPS];
        contest.of_gravity = [14.0, 11.0, 0.0, 0.0];
        contest.noise = 12.0;
        let outcome = contest.between(0, 1);
        // Of 32, 14 are gravity's; of 56, 32 are left.
        assert_eq!((outcome.over_noise, outcome.objection), (1.5, 3.0));
        assert!((outcome.explained - 24.0 / 56.0).abs() < 1e-6);
        contest.noise = 0.0;
        assert_eq!(contest.between(0, 1).over_noise, f32::INFINITY, "a noise that is not known is none to be down to");
    }

    #[test]
    fn what_is_decided_against_is_not_won_whatever_comes_and_what_is_not_can_be() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut deviate = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
        let mut decided = 0;
        for _ in 0..500 {
            let mut contest = Contest::zero();
            contest.losses[0] = core::array::from_fn(|_| 5.0 + deviate());
            contest.losses[1] = [5.0; MAX_GROUPS];
            contest.groups = 1 + (9.0 * (deviate() + 0.5)) as usize;
            let is_decided = contest.is_decided_against(0, 1, MAX_GROUPS, 0.01);
            decided += u32::from(is_decided);
            // The best that can come: larger gains than all so far, on every group.
            for group in contest.groups..MAX_GROUPS {
                contest.losses[1][group] = 15.0;
            }
            contest.groups = MAX_GROUPS;
            assert_eq!(contest.between(0, 1).p_value > 0.01, is_decided);
        }
        assert!((100..400).contains(&decided), "{decided}");
    }

    #[test]
    fn p_value_of_all_gains_equal_is_one_pattern_and_of_none_is_all() {
        assert_eq!(sign_flip_p_value(&[1.0; 10]), 1.0 / 1024.0);
        assert_eq!(sign_flip_p_value(&[-1.0; 10]), 1.0);
        assert_eq!(sign_flip_p_value(&[]), 1.0);
        assert_eq!(sign_flip_p_value(&[3.0, -1.0, 2.0]), 2.0 / 8.0);
    }

    #[test]
    fn under_no_change_the_false_alarm_rate_is_the_stated_one() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(11);
        let trials = 4000;
        let mut alarms = 0;
        for _ in 0..trials {
            let gains: [f32; 10] = core::array::from_fn(|_| {
                let u = generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
                // Heavy tails: the permutation does not mind.
                u * u * u
            });
            if sign_flip_p_value(&gains) <= 0.01 {
                alarms += 1;
            }
        }
        // Binomial(4000, 0.01): 40 +- 4 * 6.3. The p-value is discrete, so the rate may lie below.
        assert!(alarms <= 65, "{alarms}");
        assert!(alarms >= 10, "{alarms}");
    }
}
