//! The `--dynamics` and `--burst` files.

use std::{
    fmt::{Display, Write},
    path::Path,
};

use meerkat_mwd::survey::{BurstSample, DrillingDynamics, Rotation, SHOCK_LEVELS, WhirlKind};

use testbed::{console::save, failure::Failure, trace::seconds};

/// Standard gravity, m/s^2.
const G: f32 = 9.806_65;

/// Columns before and after those of the higher levels of shocks.
const COLUMNS: [&str; 2] = [
    "t_start_s,t_end_s,axial_rms_g,axial_peak_g,axial_severity,lateral_rms_g,lateral_peak_g,lateral_severity,shocks",
    "clipped,min_rpm,mean_rpm,max_rpm,stick_slip_index,stick_slip_severity,whirl,whirl_rpm,whirl_circularity",
];

/// Names of all columns, with the higher levels of shocks in g: `shocks_over_25_g` where a shock is one over 10 g.
fn header(shock_m_s2: f32) -> String {
    let over = SHOCK_LEVELS.map(|ratio| {
        let tenths = libm::roundf(10.0 * ratio * shock_m_s2 / G);
        format!("shocks_over_{}_g", tenths / 10.0)
    });
    [COLUMNS[0], &over.join(","), COLUMNS[1]].join(",")
}

/// Writes one row a window; empty cells where there is no number. `shock_m_s2` is the configured level of a shock.
///
/// # Errors
/// When the file cannot be written.
pub fn write_dynamics_csv(windows: &[DrillingDynamics], shock_m_s2: f32, path: &Path) -> Result<(), Failure> {
    let rows: Vec<String> = windows.iter().map(row).collect();
    let text = format!("{}\n{}", header(shock_m_s2), rows.concat());
    save(path, &text).map_err(|error| Failure::output(path, &error))
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
    save(path, &text).map_err(|error| Failure::output(path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_shocks_are_named_in_g() {
        let columns = |shock_g: f32| header(shock_g * G).split(',').skip(8).take(5).collect::<Vec<_>>().join(" ");
        assert_eq!(columns(10.0), "shocks shocks_over_25_g shocks_over_50_g shocks_over_100_g clipped");
        assert_eq!(columns(4.6), "shocks shocks_over_11.5_g shocks_over_23_g shocks_over_46_g clipped");
    }
}
