//! Rotation, vibration and shocks of a flight.

use meerkat_mwd::survey::{DrillingDynamics, Rotation, SHOCK_LEVELS, WhirlKind};

use super::{Chart, Page, Series, Told, in_s, line, table};
use testbed::flight::Watched;

/// Revolutions per minute in one radian per second.
const RPM: f64 = 60.0 / core::f64::consts::TAU;

/// The worst level of severity.
const WORST: u8 = 7;

/// Standard gravity, m/s^2.
const G: f64 = 9.80665;

/// Adds the plots.
pub(super) fn add(page: &mut Page, told: &Told) {
    let span = told.span_s();
    let about_axis =
        |output: &meerkat_mwd::probe::Output| [in_s(output.t_us), RPM * f64::from(output.rate_rad_s[2]), 0.0];
    let speed = told.flight.outputs.iter().map(about_axis).collect();
    let about = "Compensated rate about the tool's axis, clockwise looking down-hole.";
    let mut speeds = vec![line("speed", "after", speed, span)];
    speeds.extend(
        told.watched
            .map(|watched| series("mean of a window", "reference", watched, |d| Some(d.rotation?.mean_rpm.into()))),
    );
    page.chart(Chart::new("Rotation about the tool's axis", "rpm", about, speeds));
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
    page.add(&shocks_by_level(told, watched));
    let severity = vec![
        series("along the axis", "z", watched, |d| d.axial_severity().map(f64::from)),
        series("across the axis", "y", watched, |d| d.lateral_severity().map(f64::from)),
        series("stick-slip", "x", watched, |d| {
            d.rotation.as_ref().and_then(Rotation::stick_slip_severity).map(f64::from)
        }),
    ];
    let about = "Levels 0 to 7 of rms vibration, from 0.5, 1, 2, 3, 5, 8 and 15 g, and of the stick-slip index, from 0.2 in \
                 steps of 0.2; 7 is a string that turned backwards.";
    page.chart(Chart::new("Severity", "level", about, severity).of_levels(WORST));
    let whirling: Vec<&DrillingDynamics> = watched.dynamics.iter().filter(|d| d.whirl_kind().is_some()).collect();
    if let Some(first) = whirling.first() {
        let backward = whirling.iter().filter(|d| d.whirl_kind() == Some(WhirlKind::Backward)).count();
        page.add(&format!(
            "<p>The tool whirls in {} windows, in {backward} of them backwards; first from {:.0} s on.</p>\n",
            whirling.len(),
            in_s(first.t_start_us)
        ));
    }
    if watched.dynamics.iter().any(|dynamics| dynamics.shocks > 0) {
        let level_g = f64::from(told.config.survey.dynamics.shock_m_s2) / G;
        let about = format!("Times in a window that vibration passed {level_g:.1} g, or the accelerometer clipped.");
        let shocks = series("shocks", "x", watched, |d| Some(d.shocks.into()));
        page.chart(Chart::new("Shocks", "per window", &about, vec![shocks]).of_sizes());
    }
}

/// Table of how many shocks reached each level; empty without shocks.
fn shocks_by_level(told: &Told, watched: &Watched) -> String {
    let all: u32 = watched.dynamics.iter().map(|dynamics| dynamics.shocks).sum();
    if all == 0 {
        return String::new();
    }
    let first_g = f64::from(told.config.survey.dynamics.shock_m_s2) / G;
    let of_level = |k: usize| watched.dynamics.iter().filter_map(|dynamics| dynamics.shocks_over.get(k)).sum::<u32>();
    let levels = SHOCK_LEVELS.iter().enumerate().map(|(k, ratio)| (first_g * f64::from(*ratio), of_level(k)));
    let rows = std::iter::once((first_g, all)).chain(levels).filter(|(_, count)| *count > 0);
    let rows = rows.map(|(level_g, count)| (false, vec![format!("{level_g:.0}"), count.to_string()]));
    format!(
        "<h3>Shocks by level</h3>\n<p class=\"about\">How many shocks reached a level, as sampled. A short shock may be higher than its samples.</p>\n{}",
        table(&["over, g", "times"], rows)
    )
}

/// A figure of every window, as points in the windows' middles.
fn series(name: &str, class: &'static str, watched: &Watched, of: fn(&DrillingDynamics) -> Option<f64>) -> Series {
    let point = |d: &DrillingDynamics| [0.5 * (in_s(d.t_start_us) + in_s(d.t_end_us)), of(d).unwrap_or(f64::NAN), 0.0];
    let points = watched.dynamics.iter().map(point).collect();
    Series { name: name.to_owned(), class, points, bridged_s: f64::MAX, marked: true }
}
