//! The `--dynamics` and `--burst` files.

use std::{
    fmt::{Display, Write},
    path::Path,
};

use meerkat_mwd::survey::{BurstSample, DrillingDynamics, Rotation, WhirlKind};

use crate::{failure::Failure, trace::seconds};

/// Standard gravity, m/s^2.
const G: f32 = 9.806_65;

const HEADER: &str = "t_start_s,t_end_s,axial_rms_g,axial_peak_g,axial_severity,lateral_rms_g,lateral_peak_g,lateral_severity,shocks,\
                      shocks_over_2.5,shocks_over_5,shocks_over_10,clipped,min_rpm,mean_rpm,max_rpm,stick_slip_index,\
                      stick_slip_severity,whirl,whirl_rpm,whirl_circularity";

/// Writes one row a window; empty cells where there is no number. Shocks over 2.5, 5 and 10 are those over so many
/// times the configured level.
///
/// # Errors
/// When the file cannot be written.
pub fn write_dynamics_csv(windows: &[DrillingDynamics], path: &Path) -> Result<(), Failure> {
    let rows: Vec<String> = windows.iter().map(row).collect();
    let text = format!("{HEADER}\n{}", rows.concat());
    std::fs::write(path, text).map_err(|error| Failure::output(path, &error))
}

fn row(window: &DrillingDynamics) -> String {
    let in_g = |x: Option<f32>| x.map(|x| format!("{:.4}", x / G));
    let rotation = |of: fn(&Rotation) -> f32| window.rotation.as_ref().map(|rotation| format!("{:.2}", of(rotation)));
    let [over, far_over, farthest_over] = window.shocks_over;
    let kind = window.whirl_kind().map(|kind| match kind {
        WhirlKind::Forward => "forward",
        WhirlKind::Backward => "backward",
    });
    [
        cell(Some(seconds(window.t_start_us))),
        cell(Some(seconds(window.t_end_us))),
        cell(in_g(window.axial_rms_m_s2)),
        cell(in_g(window.axial_peak_m_s2)),
        cell(window.axial_severity()),
        cell(in_g(window.lateral_rms_m_s2)),
        cell(in_g(window.lateral_peak_m_s2)),
        cell(window.lateral_severity()),
        cell(Some(window.shocks)),
        cell(Some(over)),
        cell(Some(far_over)),
        cell(Some(farthest_over)),
        cell(Some(window.clipped)),
        cell(rotation(|rotation| rotation.min_rpm)),
        cell(rotation(|rotation| rotation.mean_rpm)),
        cell(rotation(|rotation| rotation.max_rpm)),
        cell(window.rotation.and_then(|rotation| rotation.stick_slip_index).map(|index| format!("{index:.3}"))),
        cell(window.rotation.as_ref().and_then(Rotation::stick_slip_severity)),
        cell(kind),
        cell(window.whirl.map(|whirl| format!("{:.1}", whirl.rpm))),
        cell(window.whirl.map(|whirl| format!("{:.3}", whirl.circularity))),
    ]
    .join(",")
        + "\n"
}

fn cell(value: Option<impl Display>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// Writes the raw samples of a burst.
///
/// # Errors
/// When the file cannot be written.
pub fn write_burst_csv(burst: &[BurstSample], path: &Path) -> Result<(), Failure> {
    let mut text = "t_s,ax,ay,az,axial_rate_rad_s\n".to_owned();
    for BurstSample { t_us, accel_m_s2: [x, y, z], axial_rate_rad_s } in burst {
        // Writing to memory does not fail.
        let _ = writeln!(text, "{},{x},{y},{z},{axial_rate_rad_s}", seconds(*t_us));
    }
    std::fs::write(path, text).map_err(|error| Failure::output(path, &error))
}
