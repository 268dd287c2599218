//! Results that wait for their instant, and reports that wait to be polled.

use super::{Identifier, Job, Refusal, State, WindowReport, unidentified};

impl Identifier {
    /// Keeps a result until it takes effect.
    pub(super) fn conclude(&mut self, report: WindowReport) {
        self.result.clear();
        // Just emptied, so there is room.
        let _ = self.result.push(report);
        self.state = State::Ready;
    }

    /// A window whose result is not ready in time.
    pub(super) fn announce_overrun(&mut self, job: &Job) {
        self.overruns = self.overruns.saturating_add(1);
        self.announce_unapplied(job, Refusal::Overrun);
    }

    /// Reports a window without a result: what flies stays.
    pub(super) fn announce_unapplied(&mut self, job: &Job, refusal: Refusal) {
        let report = unidentified(&self.context(), job, refusal);
        self.announce(WindowReport { fitted: self.flown, flown: self.flown, ..report });
    }

    pub(super) fn announce(&mut self, report: WindowReport) {
        if self.pending.push_back(report).is_err() {
            self.reports_lost = self.reports_lost.saturating_add(1);
        }
    }

    /// The oldest report that nobody has taken.
    pub fn take_report(&mut self) -> Option<WindowReport> {
        self.pending.pop_front()
    }
}
