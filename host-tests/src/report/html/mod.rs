//! HTML pages, each one file that needs nothing else: its plots are drawn without scripts, and drawn anew by a script
//! to be zoomed.

mod attitude;
pub mod calibration;
mod chart;
mod dial;
pub mod diagnosis;
mod dynamics;
mod effects;
pub mod escape;
mod first_screen;
pub mod fleet;
pub mod live;
mod page;
mod path_in_space;
mod provenance;
mod readings;
pub mod replay;
mod regressor;
mod residual;
mod spark;
mod strip;
mod surveys;
pub mod survey_run;
mod svg;
mod table;
mod thinned;
mod windows;

use std::path::Path;

use meerkat_mwd::Config;

pub use chart::{Chart, Mark};
pub use page::Page;
pub use provenance::Sources;
pub use svg::{Plot, Series};
pub use table::{figure, table};

use crate::{diagnosis::Diagnosed, number::fixed};
use testbed::{
    failure::Failure,
    flight::{Flight, Watched},
    score::{Reference, Settings},
    trace::Trace,
};

/// Data that a page tells of.
#[derive(Clone, Copy)]
pub struct Told<'a> {
    /// The recording.
    pub trace: &'a Trace,
    /// The configuration that flew.
    pub config: &'a Config,
    /// The flight.
    pub flight: &'a Flight,
    /// Findings of the flight.
    pub diagnosed: &'a Diagnosed,
    /// Scores, where there is something to score against.
    pub reference: Option<&'a Reference>,
    /// Surveys, dynamics and calibrated vectors, where the flight was watched.
    pub watched: Option<&'a Watched>,
    /// Where it was flown, in words.
    pub place: &'a str,
}

impl Told<'_> {
    /// Time of the first and the last sample, seconds.
    fn span_s(&self) -> [f64; 2] {
        let samples = &self.trace.samples;
        [samples.first(), samples.last()].map(|sample| sample.map_or(0.0, |sample| in_s(sample.t_us)))
    }

    /// Settings of the scores.
    fn settings(&self) -> Settings {
        Settings::of(self.trace, self.config, self.flight)
    }

    /// Name of the trace's file.
    fn file_name(&self) -> String {
        self.trace.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }
}

/// Writes a page.
///
/// # Errors
/// When the file cannot be written.
pub fn write_page(path: &Path, page: &str) -> Result<(), Failure> {
    testbed::console::save(path, page).map_err(|error| Failure::output(path, &error))
}

/// Text with a capital first letter.
#[must_use]
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Microseconds in seconds.
fn in_s(t_us: u64) -> f64 {
    t_us as f64 * 1e-6
}

/// A line of a plot. It breaks where nothing was read for a hundredth of the plot.
fn line(name: &str, class: &'static str, points: Vec<[f64; 3]>, [from_s, to_s]: [f64; 2]) -> Series {
    Series { name: name.to_owned(), class, points, bridged_s: 0.01 * (to_s - from_s), marked: false }
}

#[cfg(test)]
mod tests {
    use super::*;
    use escape::escape;

    #[test]
    fn what_means_something_in_a_page_is_escaped() {
        assert_eq!(escape("a<b> & \"c\"\u{1}'"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}&#39;");
        assert_eq!(sentence("what"), "What");
    }
}
