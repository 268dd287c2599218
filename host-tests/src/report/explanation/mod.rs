//! Explanation of each window: which sensor is to blame, what moved P, and how far P is from a known one.

mod known_p;
mod watched;

use std::io::{self, Write};

use meerkat_mwd::{
    Config, Probe,
    identification::{Decision, WindowReport},
};
use nalgebra::Matrix3;
use serde::Serialize;

use crate::report::window_note::span;
use known_p::KnownP;
use testbed::{
    flight::Flight,
    score::nees::{covariance, normalised},
    trace::Trace,
};
use watched::{Moved, Update, updates};

/// Sensors of [`WindowReport::widths`], in its order.
const SENSORS: [&str; 5] =
    ["magnetometer matrix", "hard iron", "accelerometer", "magnetometer misalignment", "accelerometer bias"];

/// Width, times the data sheet's, from which a sensor is blamed.
const TO_BLAME: f32 = 1.5;

/// Explanations of a flight's windows.
pub struct Explanation {
    known: Option<KnownP>,
    windows: Vec<Option<Window>>,
}

/// Explanation of one window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Window {
    /// Log Bayes factor of free widths of all vector sensors' errors over the data sheets' widths.
    pub evidence_of_widths: f32,
    /// Log Bayes factor of a free width of one sensor alone.
    pub evidence_of_width: BySensor,
    /// Normalised estimation error squared of P, over 9; `null` without a known P.
    pub nees_of_p: Option<f64>,
    /// Change of the filter's P since the window before by each kind of rows, as degrees in a turn.
    pub moved_deg_per_turn: ByRows,
}

/// One number for each vector sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct BySensor {
    pub magnetometer_matrix: f32,
    pub magnetometer_misalignment: f32,
    pub hard_iron: f32,
    pub accelerometer: f32,
    pub accelerometer_bias: f32,
}

/// One number for each kind of rows. The changes add up as vectors; their sizes do not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct ByRows {
    pub field: f64,
    pub velocity: f64,
    pub position: f64,
    pub rest: f64,
    pub all: f64,
}

impl Explanation {
    /// Flies `probe`, started like the one that flew, over the samples again and watches its estimator.
    #[must_use]
    pub fn of(probe: Box<Probe>, trace: &Trace, config: &Config, flight: &Flight) -> Self {
        let known = KnownP::of(trace, config);
        let updates = updates(probe, trace);
        let mut before = Moved::default();
        let window = |report: &WindowReport| {
            let update = updates.iter().find(|update| update.t_us == report.t_end_us)?;
            let moved = since(&update.moved, &std::mem::replace(&mut before, update.moved));
            report.t_effect_us.map(|_| Window::new(report, update, &moved, known.as_ref()))
        };
        let windows = flight.reports.iter().map(window).collect();
        Self { known, windows }
    }

    /// Explanations by window; `None` for a window without a result.
    #[must_use]
    pub fn windows(&self) -> &[Option<Window>] {
        &self.windows
    }
}

impl Window {
    fn new(report: &WindowReport, update: &Update, moved: &Moved, known: Option<&KnownP>) -> Self {
        let [magnetometer_matrix, hard_iron, accelerometer, magnetometer_misalignment, accelerometer_bias] =
            update.evidence.of_group;
        let p = report.fitted.p_matrix().map(f64::from);
        let [field, velocity, position, rest] = moved.map(|change| deg_per_turn(&change, &p));
        let all = std::array::from_fn(|k| moved.iter().filter_map(|kind| kind.get(k)).sum());
        let against = |known: &KnownP| {
            normalised(report.fitted.p.as_flattened(), &(covariance(report) + known.covariance), &known.p)
        };
        Self {
            evidence_of_widths: update.evidence.all,
            evidence_of_width: BySensor {
                magnetometer_matrix,
                magnetometer_misalignment,
                hard_iron,
                accelerometer,
                accelerometer_bias,
            },
            nees_of_p: known.and_then(against),
            moved_deg_per_turn: ByRows { field, velocity, position, rest, all: deg_per_turn(&all, &p) },
        }
    }
}

fn since(now: &Moved, before: &Moved) -> Moved {
    let mut moved = *now;
    moved.as_flattened_mut().iter_mut().zip(before.as_flattened()).for_each(|(now, before)| *now -= before);
    moved
}

/// Change of a whole turn about an axis, degrees, rms of the three axes. NaN if P has no inverse.
fn deg_per_turn(change: &[f64; 9], p: &Matrix3<f64>) -> f64 {
    let change = p.try_inverse().map(|inverse| Matrix3::from_row_slice(change) * inverse);
    change.map_or(f64::NAN, |change| 360.0 * (change.norm_squared() / 3.0).sqrt())
}

/// Prints two tables with one row a window.
///
/// # Errors
/// When `out` takes no more.
pub fn print_explanation(out: &mut impl Write, flight: &Flight, explanation: &Explanation) -> io::Result<()> {
    writeln!(out, "explain  widths of the vector sensors' errors, times the data sheet's; sigma of P's diagonal, %")?;
    writeln!(
        out,
        "{:>21} {:>8} {:>10} {:>10} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>20}  to blame",
        "window, s", "", "motion, s", "directions", "NIS", "matrix", "turn", "iron", "accel", "bias", "sigma x, y, z"
    )?;
    flight.reports.iter().try_for_each(|report| writeln!(out, "{}", row(report)))?;
    let known = explanation.known.as_ref().map_or("none: neither a reference nor a simulator's truth", |p| p.source);
    writeln!(
        out,
        "evidence  that the widths are not the data sheets', log Bayes factor (3: 20 to 1); rows  by how much they moved the filter's own P \
         since the window before, deg in a turn; NEES / 9  of P, held against one {known}"
    )?;
    writeln!(
        out,
        "{:>21} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>8} {:>8} {:>9}",
        "window, s",
        "evidence",
        "matrix",
        "turn",
        "iron",
        "accel",
        "bias",
        "field",
        "velocity",
        "position",
        "rest",
        "all rows",
        "NEES / 9"
    )?;
    let rows = flight.reports.iter().zip(explanation.windows());
    rows.filter_map(|(report, window)| Some((report, window.as_ref()?)))
        .try_for_each(|(report, window)| writeln!(out, "{}", second_row(report, window)))
}

fn second_row(report: &WindowReport, window: &Window) -> String {
    let BySensor { magnetometer_matrix, magnetometer_misalignment, hard_iron, accelerometer, accelerometer_bias } =
        window.evidence_of_width;
    let ByRows { field, velocity, position, rest, all } = window.moved_deg_per_turn;
    let nees = window.nees_of_p.map_or_else(|| "-".to_owned(), |nees| format!("{nees:.2}"));
    format!(
        "{:>21} {:>8.1} {magnetometer_matrix:>8.1} {magnetometer_misalignment:>8.1} {hard_iron:>8.1} {accelerometer:>8.1} {accelerometer_bias:>8.1} {field:>8.2} {velocity:>9.2} {position:>9.2} \
         {rest:>8.2} {all:>8.2} {nees:>9}",
        span(report),
        window.evidence_of_widths
    )
}

fn row(report: &WindowReport) -> String {
    let window = span(report);
    if report.t_effect_us.is_none() {
        return format!("{window:>21} no result in time");
    }
    let decision = if report.decision == Decision::Accepted { "accepted" } else { "refused" };
    let [matrix, iron, accelerometer, turn, bias] = report.widths;
    let [x, _, _, _, y, _, _, _, z] = p_sigma(report).map(|sigma| 100.0 * sigma);
    format!(
        "{window:>21} {decision:>8} {:>10.1} {:>10} {:>6.2} {matrix:>8.2} {turn:>8.2} {iron:>8.2} {accelerometer:>8.2} {bias:>8.2} {:>20}  {}",
        report.motion_s,
        report.directions_decided,
        report.innovation_nis,
        format!("{x:.2} {y:.2} {z:.2}"),
        blamed(report.widths)
    )
}

/// Sigmas of P's nine elements, row-major.
const fn p_sigma(report: &WindowReport) -> [f32; 9] {
    let [a, b, c, d, e, f, g, h, i, ..] = report.sigma;
    [a, b, c, d, e, f, g, h, i]
}

/// Sensors whose errors the data show to be wider than the data sheet says, the widest first.
fn blamed(widths: [f32; 5]) -> String {
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
        assert_eq!(blamed([0.3, 1.0, 1.2, 1.0, 1.0]), "none");
        assert_eq!(blamed([1.6, 1.0, 4.0, 0.1, 1.0]), "accelerometer, magnetometer matrix");
    }
}
