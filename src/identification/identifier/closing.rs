//! When a window closes, and what is made of it then.

use super::{Identifier, Job, Refusal, State, micros, unidentified};

impl Identifier {
    pub(super) fn start_window(&mut self, t_us: u64) {
        self.stream_start_us = t_us;
        self.stream_from = self.stream.increments.count();
        self.schedule(t_us, t_us.saturating_add(micros(self.config.identification.window_s)));
    }

    /// Sets the next close: the regular one, or the last one before the freeze where that comes first or so soon after that
    /// the regular one's result would not have landed.
    pub(super) fn schedule(&mut self, now_us: u64, regular_us: u64) {
        self.next_close_us = if now_us >= self.final_close_us {
            u64::MAX
        } else if regular_us.saturating_add(micros(self.config.identification.latency_s)) > self.final_close_us {
            self.final_close_us
        } else {
            regular_us
        };
    }

    /// Closes the window in progress: a job, or at once a report of why there is none.
    pub(super) fn close(&mut self, t_us: u64, effect_us: u64, cut_by_gap: bool) {
        let count = self.stream.increments.count();
        let t_start_us = self
            .stream_start_us
            .max(t_us.saturating_sub(micros(self.config.identification.window_s)))
            .max(self.learned_until_us);
        // A window is far shorter than the hour that 32 bits of microseconds hold.
        let length_us = (t_us - t_start_us) as u32;
        let kept = length_us.checked_div(self.stream.grid.interval_us).unwrap_or(0);
        let job = Job {
            t_start_us,
            t_end_us: t_us,
            effect_us,
            from: self.stream_from.max(count.saturating_sub(kept)),
            to: count,
            rest: self.stream.rest_bias(t_us),
            rest_as_read: self.stream.rest_as_read(t_us),
            rest_is_news: self.stream.last_rest_us().is_some_and(|rest_us| rest_us > self.bias_known_us),
            p_known_us: self.p_known_us,
            rest_s: self.stream.rest_seconds(length_us / 1_000_000) as f32,
            rest_pairs: self.stream.rest_pairs.count(),
            rest_norm_error_m_s2: self.stream.rest_norm_error_m_s2(),
        };
        let too_short = Refusal::WindowTooShort {
            length_s: length_us as f32 * 1e-6,
            needed_s: self.config.identification.min_window_s,
            cut_by_gap,
        };
        match (u64::from(length_us) < micros(self.config.identification.min_window_s), self.state) {
            // Too short for P, but a rest in it still gives the bias.
            (true, State::Idle) => {
                self.job = job;
                let report = unidentified(&self.context(), &job, too_short);
                self.conclude(report);
            }
            (true, _) => self.announce_unapplied(&job, too_short),
            (false, State::Idle) => {
                self.job = job;
                self.result.clear();
                // A diagnosis that is not done by now has had its time: when it is due it is counted as an overrun.
                self.state = State::Due;
            }
            (false, _) => self.announce_overrun(&job),
        }
    }

    /// Begins to fit the window of the job.
    #[inline(never)]
    pub(super) fn start_fit(&mut self) {
        self.work.begin_fit();
        let (job, carried) = (self.job, self.carried);
        if let Some((context, fit)) = self.split() {
            fit.start(&context, job, &carried);
        }
        self.state = State::Fitting;
    }
}
