//! One recording of a batch: read, flown once with its surveys, and described.

use std::path::{Path, PathBuf};

use meerkat_mwd::{
    Config, Probe,
    config::ConfigError,
    survey::{SurveyNews, SurveyReport, Surveyor},
};

use super::{key::Key, options::Options, parts::Part};
use crate::{
    diagnosis::diagnosed,
    import::plausible::checked,
    report::{
        attitude_csv::write_attitude_csv,
        flight_notes::add_flight_notes,
        html::{Told, replay::page, write_page},
        json::result_json,
        surveys_csv::surveys_csv,
    },
};
use testbed::{
    failure::Failure,
    flight::{
        Flight,
        configuration::{configuration, frozen_from_us},
        started, watched,
    },
    score,
    trace::Trace,
};

/// A recording with all that was made of it.
#[derive(Clone, Debug)]
pub struct Result {
    /// The trace.
    pub trace: Trace,
    /// The configuration that flew.
    pub config: Config,
    /// The flight.
    pub flight: Flight,
    /// Its surveys.
    pub surveys: Vec<SurveyReport>,
}

/// Flies a trace once, with its surveys.
///
/// # Errors
/// The configuration cannot be used.
pub fn result(mut trace: Trace, options: &Options) -> std::result::Result<Result, Failure> {
    let mut config = configuration(&trace, options.config.as_deref(), |config| options.set(config))?;
    trace.mark_clipped(&config.full_scale);
    checked(&mut trace, &mut config, options.force)?;
    let freeze_at_us = frozen_from_us(&trace, options.hold_out, options.config.as_deref())?;
    let probe = started(&config, freeze_at_us, None)?;
    let (flight, mut surveys) = surveyed(probe, &trace)?;
    surveys.iter_mut().for_each(|report| trace.grade(report));
    add_flight_notes(&mut trace, &config, &flight);
    Ok(Result { trace, config, flight, surveys })
}

/// The flight of [`testbed::flight::fly`] and the surveys of [`testbed::flight::surveys`] in one run.
fn surveyed(mut probe: Box<Probe>, trace: &Trace) -> std::result::Result<(Flight, Vec<SurveyReport>), Failure> {
    let config = *probe.config();
    let mut surveyor = Surveyor::new();
    surveyor.configure(&config.earth, &config.survey).map_err(|error: ConfigError| Failure::Config(error))?;
    let mut flight = Flight::before(trace);
    let mut taken = Vec::new();
    for sample in trace.samples() {
        let output = probe.push(&sample);
        flight.flown(&probe, &sample, output.as_ref());
        if let Some(output) = output {
            let news = surveyor.push(&probe.survey_input(&sample, &output));
            taken.extend(surveyor.stationary().filter(|_| news.contains(SurveyNews::STATIONARY)).copied());
            taken.extend(surveyor.rotating().filter(|_| news.contains(SurveyNews::ROTATING)).copied());
        }
        flight.reports.extend(probe.poll(probe.poll_budget()));
        flight.diagnoses.extend(probe.take_diagnosis());
    }
    flight.ended(&mut probe);
    Ok((flight, taken))
}

impl Result {
    /// The result as `--json` has it.
    ///
    /// # Errors
    /// A value that JSON does not hold; there is none.
    pub fn json(&self) -> serde_json::Result<String> {
        let Self { trace, config, flight, surveys } = self;
        let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight));
        let diagnosed = diagnosed(trace, config, flight);
        result_json(trace, config, flight, &diagnosed, reference).with_surveys(surveys).text()
    }
}

/// Files of one recording beside the tables.
pub(super) struct Beside {
    attitude: Option<PathBuf>,
    html: Option<PathBuf>,
}

impl Beside {
    /// Their names.
    pub fn of(path: &Path, key: &Key, options: &Options) -> Self {
        let file = |folder: &Option<PathBuf>, ending| folder.as_ref().map(|folder| folder.join(key.file(path, ending)));
        Self { attitude: file(&options.attitude_dir, "csv"), html: file(&options.html_dir, "html") }
    }

    /// Returns true if nothing is left to write.
    pub fn is_there(&self) -> bool {
        [&self.attitude, &self.html].into_iter().flatten().all(|file| file.exists())
    }
}

/// The part of one recording; the files beside the tables are written.
pub(super) fn fly(path: &Path, options: &Options, beside: &Beside) -> anyhow::Result<Part> {
    // A page goes through its trace more than forwards.
    let trace = if beside.html.is_some() { Trace::read(path)? } else { Trace::spooled(path)? };
    // Before anything is said of rows that may lack.
    trace.all_read()?;
    let flown = result(trace, options)?;
    if let Some(file) = &beside.attitude {
        write_attitude_csv(flown.flight.rows(), file)?;
    }
    if let Some(file) = &beside.html {
        let Result { trace, config, flight, .. } = &flown;
        let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight));
        let (diagnosed, reference) = (&diagnosed(trace, config, flight), reference.as_ref());
        let watched = Some(&watched(started(config, flight.frozen_at_us, None)?, trace)?);
        write_page(
            file,
            &page(&Told { trace, config, flight, diagnosed, reference, watched, place: "on this machine" }),
        )?;
    }
    flown.trace.all_read()?;
    flown.flight.all_read()?;
    let (json, surveys) = (flown.json()?, surveys_csv(&flown.surveys));
    // Drop the flight first: it need not be in memory beside the values that are read from its JSON.
    drop(flown);
    // By way of the text: a number is then the one that a reader of the JSON has.
    Ok(Part { recording: None, error: None, result: serde_json::from_str(&json)?, surveys })
}
