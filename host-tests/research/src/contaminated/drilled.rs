use std::{
    ops::Range,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use meerkat_mwd::compensation::GyroModel;

use super::{
    prior::Prior,
    readings::{Readings, Theta, model_of},
    window::{Window, lm_huber},
};
use testbed::{
    score::systematic_rate_error_rad_s,
    simulate::{Contamination, Hits, Hole, Scenario, contaminate, simulate},
    trace::Trace,
};

/// Shares of the samples hit, by turns of the seeds.
pub(super) const SHARES: [f64; 5] = [0.1, 0.2, 0.3, 0.4, 0.5];

/// Samples of the window, in drilling at full speed; the start is the five seconds before it.
pub(super) const WINDOW: Range<usize> = 500..5_500;

/// Samples from the window's end to the first one that is scored.
const LATENCY: usize = 500;

/// A drilled run without contamination: its window, and the six minutes that begin 5 s after it.
pub(super) struct Drilled {
    pub seed: u64,
    pub scenario: Scenario,
    pub trace: Trace,
    pub truth: GyroModel,
    /// True rate of every sample.
    pub rates_rad_s: Vec<[f64; 3]>,
    /// Systematic rate error of the fit of the clean window (Levenberg-Marquardt, Huber), rad/s: what success
    /// is measured by.
    pub clean_error_rad_s: f64,
}

impl Drilled {
    /// Drilling from the start. Even seeds are vertical, odd ones at 45 deg.
    pub fn new(seed: u64) -> Self {
        Self::after_rest(seed, 0.0)
    }

    /// A run after a rest, of which 5 s lie before the window.
    pub fn after_rest(seed: u64, rest_s: f64) -> Self {
        let vertical = Hole { inclination_deg: 0.0, build_rate_deg_h: 0.0, turn_rate_deg_h: 0.0, ..Hole::default() };
        let hole = if seed.is_multiple_of(2) { vertical } else { Hole::default() };
        let scenario = Scenario { duration_s: 420.0, rest_s, hole, ..Scenario::default() };
        let (mut trace, truth) = simulate(&scenario, 1_000 + seed);
        let after = WINDOW.end + LATENCY;
        let rates_rad_s = trace.true_rate.take().unwrap_or_default();
        trace.samples.truncate(after + 100);
        trace.reference.truncate(after + 100);
        let mut drilled = Self { seed, scenario, trace, truth: truth.gyro, rates_rad_s, clean_error_rad_s: 0.0 };
        let prior = Prior::data_sheet();
        let clean = Window::new(Readings::new(&drilled.trace, &WINDOW, None), &prior, seed);
        drilled.clean_error_rad_s = drilled.error_rad_s(&lm_huber(&clean).theta);
        drilled
    }

    /// The share of this seed.
    pub fn share(&self) -> f64 {
        SHARES[self.share_index()]
    }

    /// Index of the share.
    pub fn share_index(&self) -> usize {
        (self.seed / 2) as usize % SHARES.len()
    }

    /// The trace with a share of the window's samples hit; clean without a kind.
    pub fn hit(&self, kind: Option<Contamination>, share: f64) -> (Trace, Option<Hits>) {
        match kind {
            None => (self.trace.clone(), None),
            Some(kind) => {
                let (trace, hits) = contaminate(&self.trace, kind, share, &WINDOW, self.seed);
                (trace, Some(hits))
            }
        }
    }

    /// Readings of the window, hit.
    pub fn readings(&self, kind: Option<Contamination>, share: f64) -> Readings {
        let (trace, hits) = self.hit(kind, share);
        Readings::new(&trace, &WINDOW, hits.as_ref())
    }

    /// Systematic rate error over the next six minutes, rad/s.
    pub fn error_rad_s(&self, theta: &Theta) -> f64 {
        self.model_error_rad_s(&model_of(theta))
    }

    /// Systematic rate error of a gyro model over the next six minutes, rad/s.
    pub fn model_error_rad_s(&self, model: &GyroModel) -> f64 {
        let ahead = self.rates_rad_s.get(WINDOW.end + LATENCY..).unwrap_or_default();
        systematic_rate_error_rad_s(&self.truth, model, ahead).unwrap_or(f64::INFINITY)
    }

    /// Error of theta over that of the clean fit.
    pub fn ratio(&self, theta: &Theta) -> f64 {
        self.error_rad_s(theta) / self.clean_error_rad_s
    }
}

/// `f` of every number under `count`, on all cores, in order.
pub(super) fn in_parallel<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        return;
                    }
                    let value = f(index);
                    // A poisoned lock: another thread panicked, and the scope will say so.
                    if let Ok(mut done) = done.lock() {
                        done.push((index, value));
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_default();
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, value)| value).collect()
}
