use meerkat_mwd::{
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};
use mwd::diagnosis::against_reference;
use testbed::{
    flight::{
        Flight,
        configuration::{freeze_at_us, of_trace},
        fly_frozen,
    },
    score::{self, PerModel},
    trace::Trace,
};

/// A flight over a trace with its end held out, and what it was worth there.
pub struct Played {
    pub reports: Vec<WindowReport>,
    pub scores: PerModel,
}

impl Played {
    pub fn accepted(&self) -> bool {
        self.reports.iter().any(|r| r.decision == Decision::Accepted)
    }
    /// Time-aligned 2 s rotation error of what was flown over that of bias only, held out.
    pub fn ratio(&self) -> f64 {
        self.scores.with_effects.unwrap() / self.scores.bias_only.unwrap()
    }
    /// Returns true if what was flown is worse than bias only by more than a twentieth and a fiftieth of a degree, as
    /// the bench counts harm.
    pub fn harmful(&self) -> bool {
        self.scores.with_effects.unwrap() > 1.05 * self.scores.bias_only.unwrap() + 0.02
    }
}

/// `None` without a score (no motion held out).
pub fn play(trace: &Trace, hold_out: f64, optimizer: OptimizerKind) -> Option<Played> {
    let mut config = of_trace(trace);
    config.identification.optimizer = optimizer;
    scored(trace, fly_frozen(&config, freeze_at_us(trace, hold_out), &trace.samples).unwrap())
}

/// Plays a trace with the reference standing in for accelerometer and magnetometer.
pub fn play_against_reference(trace: &Trace, hold_out: f64) -> Option<Played> {
    let freeze_us = freeze_at_us(trace, hold_out);
    scored(trace, against_reference(trace, &of_trace(trace), Some(freeze_us)).unwrap().0)
}

fn scored(trace: &Trace, flight: Flight) -> Option<Played> {
    let settings = score::Settings { from_us: flight.frozen_at_us.unwrap(), ..score::Settings::default() };
    let reference = score::score(trace, &flight, &settings)?;
    let scores = match reference.time_alignment_ms {
        Some(_) => reference.orientation_2s_rms_time_aligned_deg,
        None => reference.orientation_2s_rms_deg,
    };
    scores.with_effects?;
    Some(Played { reports: flight.reports, scores })
}
