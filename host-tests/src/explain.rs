//! What a window's report rests on, for who wants to know which sensor is to blame.

use std::io::{self, Write};

use meerkat_mwd::identification::{Decision, WindowReport};

use crate::flight::Flight;

/// Whose errors [`WindowReport::widths`] are.
const SENSORS: [&str; 3] = ["magnetometer matrix", "hard iron", "accelerometer"];

/// A sensor is to blame from this width on, times the data sheet's.
const TO_BLAME: f32 = 1.5;

/// One row for each window.
///
/// # Errors
/// When `out` takes no more.
pub fn print_explanation(out: &mut impl Write, flight: &Flight) -> io::Result<()> {
    writeln!(out, "explain  widths of the vector sensors' errors, times the data sheet's; sigma of P's diagonal, %")?;
    writeln!(
        out,
        "{:>21} {:>8} {:>10} {:>10} {:>6} {:>8} {:>8} {:>8} {:>20}  to blame",
        "window, s", "", "motion, s", "directions", "NIS", "matrix", "iron", "accel", "sigma x, y, z"
    )?;
    flight.reports.iter().try_for_each(|report| writeln!(out, "{}", row(report)))
}

fn row(report: &WindowReport) -> String {
    let window = format!("{:.1} to {:.1}", report.t_start_us as f64 * 1e-6, report.t_end_us as f64 * 1e-6);
    if report.t_effect_us.is_none() {
        return format!("{window:>21} no result in time");
    }
    let decision = if report.decision == Decision::Accepted { "accepted" } else { "refused" };
    let [matrix, iron, accelerometer] = report.widths;
    let [x, _, _, _, y, _, _, _, z] = p_sigma(report).map(|sigma| 100.0 * sigma);
    format!(
        "{window:>21} {decision:>8} {:>10.1} {:>10} {:>6.2} {matrix:>8.2} {iron:>8.2} {accelerometer:>8.2} {:>20}  {}",
        report.motion_s,
        report.directions_decided,
        report.innovation_nis,
        format!("{x:.2} {y:.2} {z:.2}"),
        blamed(report.widths)
    )
}

/// Of P's nine elements, row-major.
const fn p_sigma(report: &WindowReport) -> [f32; 9] {
    let [a, b, c, d, e, f, g, h, i, ..] = report.sigma;
    [a, b, c, d, e, f, g, h, i]
}

/// The sensors whose errors the data find larger than the data sheet says, the worst first.
fn blamed(widths: [f32; 3]) -> String {
    let mut wide: Vec<(&str, f32)> = SENSORS.into_iter().zip(widths).filter(|(_, width)| *width >= TO_BLAME).collect();
    wide.sort_by(|a, b| b.1.total_cmp(&a.1));
    let names: Vec<&str> = wide.into_iter().map(|(name, _)| name).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_is_blamed_first_and_none_within_the_data_sheet() {
        assert_eq!(blamed([0.3, 1.0, 1.2]), "none");
        assert_eq!(blamed([1.6, 1.0, 4.0]), "accelerometer, magnetometer matrix");
    }
}
