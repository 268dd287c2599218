//! What follows from a pass: the solution moves, an effect is dropped or added, or there is no more to find.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs.

use super::{selection::Tested, *};

/// Where the end of a pass stands; each step does a bounded piece of it.
///
/// With a tag of its own, so that its beginning is all zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub(super) enum Ending {
    /// The scales of the residuals.
    Scales,
    /// The shocks at which the bias may have stepped.
    Shocks { is_stable: bool },
    /// Each time at which it may have.
    Step { is_stable: bool },
    /// What the pass comes to.
    Judge { is_stable: bool },
    /// Whether a chosen effect is there still.
    Drop { slot: usize, has_settled: bool },
    /// Whether a candidate shows.
    Try { index: usize, has_settled: bool },
    /// Whether P does.
    P,
    /// Whether a candidate shows in all windows together.
    History { index: usize, p_is_wrong: bool },
    /// Whether an effect that flies stays as it does.
    Keep { number: usize, p_is_wrong: bool },
    /// The solution moves, after a change of the model or not.
    Solve,
}

/// What comes after a step of the end of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    Step(Ending),
    /// Another pass.
    Pass,
    /// There is no more to find.
    Done,
}

impl Diagnosis {
    /// One piece of the end of a pass.
    #[inline(never)]
    pub(super) fn end_pass(&mut self, subject: &Subject, history: &mut History) -> Next {
        match self.ending {
            Ending::Scales if self.usable < LEAST_PER_GROUP * GROUPS as u32 => Next::Done,
            // The first residuals are those of the errors that are looked for.
            Ending::Scales => Next::Step(Ending::Shocks { is_stable: self.pass > 0 && self.rescale() }),
            Ending::Shocks { is_stable } => Next::Step(match self.look_for_step(subject) {
                true => Ending::Step { is_stable },
                false => Ending::Judge { is_stable: self.follow_step(None) && is_stable },
            }),
            Ending::Step { is_stable } => Next::Step(match self.scan_for_step(subject) {
                true => Ending::Step { is_stable },
                false => {
                    let found = self.found_step(subject);
                    Ending::Judge { is_stable: self.follow_step(found) && is_stable }
                }
            }),
            Ending::Judge { is_stable } => self.judge(subject, is_stable),
            Ending::Drop { slot, has_settled } => match self.drops(subject, slot) {
                None => Next::Step(self.ending),
                Some(true) => self.again(),
                Some(false) if slot + 1 < self.chosen.len() => Next::Step(Ending::Drop { slot: slot + 1, has_settled }),
                Some(false) => self.after_drop(has_settled),
            },
            Ending::Try { index, has_settled } => match self.tries(subject, index, history) {
                Tested::Under => Next::Step(self.ending),
                Tested::Done if index + 1 < Self::candidates(subject) => {
                    Next::Step(Ending::Try { index: index + 1, has_settled })
                }
                Tested::Done => self.after_tries(subject, has_settled),
            },
            Ending::P => match self.p_is_wrong(subject) {
                None => Next::Step(Ending::P),
                Some(p_is_wrong) => {
                    self.best.clear();
                    self.begin_history(history);
                    Next::Step(Ending::History { index: 0, p_is_wrong })
                }
            },
            Ending::History { index, p_is_wrong } => match self.tries_with_history(subject, index, history) {
                Tested::Under => Next::Step(self.ending),
                Tested::Done if index + 1 < Self::candidates(subject) => {
                    Next::Step(Ending::History { index: index + 1, p_is_wrong })
                }
                Tested::Done => Next::Step(Ending::Keep { number: 0, p_is_wrong }),
            },
            Ending::Keep { number, p_is_wrong } => match subject.stream.effects().iter().nth(number) {
                Some(flown) => {
                    self.keep_flown(subject, flown);
                    Next::Step(Ending::Keep { number: number + 1, p_is_wrong })
                }
                None => self.finish(subject, p_is_wrong),
            },
            Ending::Solve => {
                self.add_rest(subject);
                if self.solve(&self.model(subject, None)).is_some() { Next::Pass } else { Next::Done }
            }
        }
    }

    /// How many candidates are looked at.
    fn candidates(subject: &Subject) -> usize {
        subject.library.len().min(MAX_CANDIDATES)
    }

    fn may_go_on(&self) -> bool {
        self.pass < MOST_PASSES
    }

    /// The model has been changed: it is solved anew, if there may be another pass.
    fn again(&mut self) -> Next {
        self.since_change = 0;
        if self.may_go_on() { Next::Step(Ending::Solve) } else { Next::Done }
    }

    fn judge(&mut self, subject: &Subject, is_stable: bool) -> Next {
        // The solution that made these residuals comes from the pass before: it has settled when the scales had by then.
        let has_settled = is_stable && self.was_stable;
        self.was_stable = is_stable;
        let rms = self.residual_sums.map(|[sum, count]| libm::sqrtf(if count > 0.0 { sum / count } else { 0.0 }));
        self.residual = rms;
        let [sum, count] = self.nis_sums;
        self.nis = if count > 0.0 { sum / count } else { 0.0 };
        self.pass += 1;
        self.since_change += 1;
        if !has_settled && self.since_change < PATIENCE && self.may_go_on() {
            return Next::Step(Ending::Solve);
        }
        self.tested = true;
        if self.residual_before_rad.is_none() {
            self.residual_before_rad = Some(rms);
            self.nis_before = self.nis;
        }
        if let Some(last) = self.chosen.last_mut() {
            last.residual_after_rad = Self::shown_in(subject, last.index, rms);
        }
        if (has_settled || self.is_final) && !self.chosen.is_empty() {
            Next::Step(Ending::Drop { slot: 0, has_settled })
        } else {
            self.after_drop(has_settled)
        }
    }

    /// Nothing was dropped.
    fn after_drop(&mut self, has_settled: bool) -> Next {
        self.best.clear();
        if self.is_final || !self.may_go_on() { Next::Done } else { Next::Step(Ending::Try { index: 0, has_settled }) }
    }

    /// The candidate that shows most, of those that show beyond chance, is added.
    fn after_tries(&mut self, subject: &Subject, has_settled: bool) -> Next {
        if let Some((found, _)) = self.best.pop().filter(|_| !self.chosen.is_full()) {
            let residual_before_rad = Self::shown_in(subject, found.index, self.residual);
            self.note_worths(subject);
            // There is room.
            let _ = self.chosen.push(Chosen { residual_before_rad, ..found });
            if Self::is_bias_step(subject, usize::from(found.index)) {
                self.step = self.shown_step;
            }
            return self.again();
        }
        if !has_settled {
            return Next::Step(Ending::Solve);
        }
        // Nothing more shows in this window by itself. What is left while P is free is what the verdict is about: what P itself lacks is the
        // identification's.
        self.is_final = true;
        let [_, of_field] = self.residual;
        self.left = (self.nis, of_field);
        self.set_outside_aside(subject);
        Next::Step(Ending::P)
    }

    /// What is none of the library's is kept in mind, and is not taken out.
    fn set_outside_aside(&mut self, subject: &Subject) {
        let outside = |chosen: &&mut Chosen| !chosen.too_small && Self::is_outside(subject, usize::from(chosen.index));
        if let Some(chosen) = self.chosen.iter_mut().find(outside) {
            let [sum, count] = chosen.turned;
            (self.outside, chosen.too_small) = (sum / count, true);
        }
    }

    /// More passes, to see what is left with P as it flies, what was added and what is not seen left out.
    fn finish(&mut self, subject: &Subject, p_is_wrong: bool) -> Next {
        // The equations so far are about another P: it has to settle anew.
        self.was_stable = false;
        self.leave_out_unseen(subject);
        let added = self.add_by_history(subject);
        if !p_is_wrong {
            self.p_is_held = true;
            self.note_free(subject);
            self.x.iter_mut().take(P).for_each(|x| *x = 0.0);
        }
        if added || !p_is_wrong || !self.chosen.is_empty() { self.again() } else { Next::Done }
    }
}
