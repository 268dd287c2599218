//! Rotation, vibration and shocks of a flight.

use meerkat_mwd::survey::DrillingDynamics;

use super::{Chart, Page, Series, Told, in_s, line, table};
use crate::flight::Watched;

/// Revolutions per minute in one radian per second.
const RPM: f64 = 60.0 / core::f64::consts::TAU;

/// Standard gravity, m/s^2.
const G: f64 = 9.80665;

/// Adds the plots.
pub(super) fn add(page: &mut Page, told: &Told) {
    let span = told.span_s();
    let about_axis =
        |output: &meerkat_mwd::probe::Output| [in_s(output.t_us), RPM * f64::from(output.rate_rad_s[2]), 0.0];
    let speed = told.flight.outputs.iter().map(about_axis).collect();
    let about = "Compensated rate about the tool's axis, clockwise looking down-hole.";
    page.chart(Chart::new("Rotation about the tool's axis", "rpm", about, vec![line("speed", "after", speed, span)]));
    let Some(watched) = told.watched else { return };
    let index = series("stick-slip", "x", watched, |d| Some(d.rotation?.stick_slip_index?.into()));
    let about = "(largest - least) / (2 mean) of the speed over a window: 0 is steady, from 1 on the string sticks.";
    page.chart(Chart::new("Stick-slip index", "ratio", about, vec![index]).of_sizes());
    let vibration = vec![
        series("along the axis, rms", "z", watched, |d| Some(f64::from(d.axial_rms_m_s2?) / G)),
        series("across the axis, rms", "y", watched, |d| Some(f64::from(d.lateral_rms_m_s2?) / G)),
        series("largest", "x", watched, |d| Some(f64::from(d.peak_m_s2?) / G)),
    ];
    let about = "Specific force less gravity, over each window.";
    page.chart(Chart::new("Vibration", "g", about, vibration).of_sizes());
    page.add(&shocks_by_level(watched));
    if watched.dynamics.iter().any(|dynamics| dynamics.shocks > 0) {
        let level_g = f64::from(told.config.survey.dynamics.shock_m_s2) / G;
        let about = format!("Times in a window that vibration passed {level_g:.1} g, or the accelerometer clipped.");
        let shocks = series("shocks", "x", watched, |d| Some(d.shocks.into()));
        page.chart(Chart::new("Shocks", "per window", &about, vec![shocks]).of_sizes());
    }
}

/// Levels of shocks, g.
const LEVELS_G: [f64; 7] = [2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

/// Table of how often the specific force left gravity by more than each level; empty if it never did.
fn shocks_by_level(watched: &Watched) -> String {
    let away_g = |force: [f32; 3]| (force.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt() / G - 1.0).abs();
    let mut counts = [0_usize; LEVELS_G.len()];
    let mut is_above = [false; LEVELS_G.len()];
    for force in watched.calibrated.iter().filter_map(|calibrated| calibrated.force_m_s2) {
        let away_g = away_g(force);
        for ((count, is_above), level_g) in counts.iter_mut().zip(&mut is_above).zip(LEVELS_G) {
            *count += usize::from(away_g > level_g && !*is_above);
            // A shock rings: it is over when half of the level is left.
            *is_above = away_g > if *is_above { 0.5 * level_g } else { level_g };
        }
    }
    if counts[0] == 0 {
        return String::new();
    }
    let rows = LEVELS_G.iter().zip(counts).filter(|(_, count)| *count > 0);
    let rows = rows.map(|(level_g, count)| (false, vec![format!("{level_g:.0}"), count.to_string()]));
    format!(
        "<h3>Shocks by level</h3>\n<p class=\"about\">How often the specific force, as sampled, left gravity by more than a level. A short shock may be higher than its samples.</p>\n{}",
        table(&["over, g", "times"], rows)
    )
}

/// A figure of every window, as points in the windows' middles.
fn series(name: &str, class: &'static str, watched: &Watched, of: fn(&DrillingDynamics) -> Option<f64>) -> Series {
    let point = |d: &DrillingDynamics| [0.5 * (in_s(d.t_start_us) + in_s(d.t_end_us)), of(d).unwrap_or(f64::NAN), 0.0];
    let points = watched.dynamics.iter().map(point).collect();
    Series { name: name.to_owned(), class, points, bridged_s: f64::MAX, marked: true }
}
