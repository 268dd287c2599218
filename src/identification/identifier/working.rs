//! The work between samples, piece by piece.

use super::*;

/// Work units of beginning a fit.
const START_UNITS: u32 = 150;

/// Work units of learning from a fit.
const LEARN_UNITS: u32 = 250;

/// Work units of judging a fit.
const JUDGE_UNITS: u32 = 500;

impl Identifier {
    /// One bounded piece of work; returns its size in units, 0 when there is nothing to do.
    pub fn step(&mut self) -> u32 {
        if self.to_learn_us > 0 {
            self.learn();
            return LEARN_UNITS;
        }
        match self.state {
            State::Due => {
                self.start_fit();
                return START_UNITS;
            }
            State::Fitting => {}
            State::Idle | State::Ready => return self.diagnosis.step(&mut self.work, &self.stream, &self.config),
        }
        let Some((context, fit)) = self.split() else { return 0 };
        match fit.step(&context) {
            Step::More(units) => units,
            Step::Done(report) => {
                match report.decision {
                    Decision::Accepted | Decision::Refused(Refusal::ChangeTooSmall { .. }) => self.will_learn(),
                    // What was carried no longer holds, or this window is wrong: the next one stands by itself.
                    Decision::Refused(Refusal::Contradiction { .. } | Refusal::RolledBack { .. }) => {
                        self.carried = Carried::nothing()
                    }
                    // A window that the gate does not believe teaches nothing.
                    Decision::Refused(_) => {}
                }
                self.conclude(report);
                JUDGE_UNITS
            }
            Step::Overtaken => {
                // Nothing will be ready when it is due.
                self.result.clear();
                self.state = State::Ready;
                JUDGE_UNITS
            }
        }
    }

    /// What no later window will hold is to be carried on.
    fn will_learn(&mut self) {
        let until_us = match self.next_close_us {
            u64::MAX => return,
            next_us => next_us.saturating_sub(micros(self.config.identification.window_s)),
        };
        if until_us > self.job.t_start_us {
            self.learned_until_us = until_us;
            self.to_learn_us = until_us;
        }
    }

    #[inline(never)]
    fn learn(&mut self) {
        let until_us = core::mem::take(&mut self.to_learn_us);
        let mut carried = self.carried;
        if let Some((context, fit)) = self.split() {
            fit.learn(&context, until_us, &mut carried);
        }
        self.carried = carried;
    }

    pub(super) fn context(&self) -> Context<'_> {
        Context { stream: &self.stream, config: &self.config, flown: &self.flown }
    }

    /// The fit beside what it needs to know.
    pub(super) fn split(&mut self) -> Option<(Context<'_>, &mut WindowFit)> {
        let Self { stream, config, flown, work, .. } = self;
        let Work::Fit(fit) = work else { return None };
        Some((Context { stream, config, flown }, fit))
    }
}
