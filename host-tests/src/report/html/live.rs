//! Live page of a probe: the plots and tables of a flight's page, from the probe's telemetry.

use meerkat_mwd::{Config, Sample};

use super::{Page, Told, attitude, dynamics, escape::escape, first_screen, surveys, windows};
use crate::diagnosis::diagnosed;
use testbed::{
    flight::{Flight, Watched},
    trace::Trace,
};

/// Data that was heard of a probe.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Its configuration, as far as it has told it.
    pub config: &'a Config,
    /// Attitudes and windows.
    pub flight: &'a Flight,
    /// Surveys and dynamics.
    pub watched: &'a Watched,
    /// The latest report of each kind, one line a subject.
    pub lines: &'a [String],
    /// Start and end of what was heard, microseconds; `None` before anything was.
    pub span_us: Option<[u64; 2]>,
}

/// The page with what was heard so far, and the script that asks for more.
#[must_use]
pub fn page(heard: &Heard) -> String {
    let mut page = told(heard);
    page.live();
    page.script(include_str!("live.js"));
    page.finish()
}

/// Update that the page asks for, as JSON.
#[must_use]
pub fn news(heard: &Heard) -> String {
    let mut news = told(heard).news();
    news["t_s"] = heard.span_us.map(|[_, end_us]| end_us as f64 * 1e-6).into();
    news.to_string()
}

fn told(heard: &Heard) -> Page {
    let Heard { config, flight, watched, lines, span_us } = *heard;
    // The plots take their span from the first and the last sample.
    let ends = span_us.unwrap_or_default().map(|t_us| Sample { t_us, ..Sample::default() });
    let trace = Trace { samples: ends.into(), ..Trace::default() };
    // Without readings nothing is worked out here: what the probe found itself is among the lines.
    let diagnosed = diagnosed(&Trace::default(), config, &Flight::default());
    let told = Told {
        trace: &trace,
        config,
        flight,
        diagnosed: &diagnosed,
        reference: None,
        watched: Some(watched),
        place: "",
    };
    let mut page = Page::new("Probe, live", told.span_s());
    let tiles = first_screen::tiles(&told, "Attitude as the probe said it last, ± one standard deviation.");
    page.head(&format!("<header>\n<h1>Probe, live</h1>\n<p class=\"trace\" id=\"age\"></p>\n</header>\n{tiles}"));
    page.section("Attitude");
    attitude::add(&mut page, &told);
    page.section("Rotation, vibration, shocks");
    dynamics::add(&mut page, &told);
    page.section("Surveys");
    surveys::add(&mut page, &told);
    if !flight.reports.is_empty() {
        page.section("What was identified");
        windows::add(&mut page, &told);
    }
    page.section("What the probe says");
    let lines = if lines.is_empty() { "nothing yet".to_owned() } else { lines.join("\n") };
    page.add(&format!("<pre tabindex=\"0\">{}</pre>\n", escape(&lines)));
    page
}
