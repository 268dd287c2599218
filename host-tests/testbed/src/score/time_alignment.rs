//! The constant delay between gyro and reference of a recording.
//!
//! Two clocks never agree to a millisecond, and only the reference shows a lag that all sensors share; at 300
//! deg/s a lag of 4 ms is 1.2 deg. The scorer fits the delay on the gyro reading that then agrees best with
//! the reference: with a P that is off by percents the score hardly depends on the delay, and its fit would
//! be off by milliseconds.

use super::{
    Tracks,
    integrated::Integrated,
    orientation_2s::{Window, track_rms_deg},
};

/// Largest delay searched, seconds, either way.
pub(super) const RANGE_S: f64 = 0.020;

/// Grid of the search, seconds; a golden section refines the best point of it.
const GRID_S: f64 = 0.001;

/// Least change of the score over the whole range for a delay to be told, degrees: optical references resolve
/// no better, and at rest there is nothing to align.
const RESOLUTION_DEG: f64 = 0.01;

/// The delay with the smallest score of any track, seconds, positive if the gyro lags the reference. `None`
/// without a window that allows every delay searched, or if the best delay lies at the end of the range or is
/// hardly better than the worst.
pub(super) fn fit(windows: &[Window], tracks: &Tracks<Integrated>) -> Option<f64> {
    let covered = |w: &&Window| tracks.cover(w.from_s - RANGE_S, w.to_s + RANGE_S);
    // Use the same windows at every delay: one that comes or goes would be a step in the score.
    let windows: Vec<Window> = windows.iter().filter(covered).copied().collect();
    let fits = [&tracks.bias_only, &tracks.twelve_parameters, &tracks.with_effects, &tracks.uncompensated];
    // The first of equal scores wins: bias only, which no identification has touched.
    let best = fits
        .iter()
        .filter_map(|track| fit_one(&windows, track))
        .reduce(|a, b| if b.score < a.score { b } else { a })?;
    best.delay_s
}

/// Lowest score of one track, and the delay there if one can be told.
struct Fit {
    score: f64,
    delay_s: Option<f64>,
}

fn fit_one(windows: &[Window], track: &Integrated) -> Option<Fit> {
    let cost = |delay_s: f64| track_rms_deg(windows, track, delay_s);
    let half = (RANGE_S / GRID_S).round() as i32;
    let grid: Vec<(i32, f64)> =
        (-half..=half).map(|i| Some((i, cost(f64::from(i) * GRID_S)?))).collect::<Option<_>>()?;
    let (best, lowest) = grid.iter().copied().reduce(|best, next| if next.1 < best.1 { next } else { best })?;
    let highest = grid.iter().fold(lowest, |highest, &(_, score)| highest.max(score));
    if best.abs() == half || highest - lowest < RESOLUTION_DEG {
        return Some(Fit { score: lowest, delay_s: None });
    }
    let centre = f64::from(best) * GRID_S;
    let refined = |delay_s: f64| cost(delay_s).unwrap_or(f64::INFINITY);
    Some(Fit { score: lowest, delay_s: Some(golden_section(refined, centre - GRID_S, centre + GRID_S)) })
}

/// Minimum of a unimodal function between `low` and `high`, to a microsecond.
fn golden_section(cost: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut cost_a, mut cost_b) = (cost(a), cost(b));
    while high - low > 1e-6 {
        if cost_a < cost_b {
            (high, b, cost_b) = (b, a, cost_a);
            a = high - ratio * (high - low);
            cost_a = cost(a);
        } else {
            (low, a, cost_a) = (a, b, cost_b);
            b = low + ratio * (high - low);
            cost_b = cost(b);
        }
    }
    0.5 * (low + high)
}
