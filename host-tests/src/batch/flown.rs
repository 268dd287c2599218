//! One recording of a batch: read, flown once with its surveys, and described.

use std::path::Path;

use meerkat_mwd::{
    Config, Sample,
    config::ConfigError,
    survey::{SurveyNews, SurveyReport, Surveyor},
};

use super::{options::Options, parts::Part};
use crate::{
    diagnosis::diagnosed,
    failure::Failure,
    flight::{Flight, configuration::configuration, started},
    import::plausible::checked,
    report::{attitude_csv::write_attitude_csv, json::result_json, surveys_csv::surveys_csv},
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
    let mut config = configuration(&trace, options.config.as_deref(), |config| options.set(config, &trace))?;
    trace.mark_clipped(&config.full_scale);
    checked(&mut trace, &mut config, options.force)?;
    let (flight, mut surveys) = surveyed(&config, &trace.samples)?;
    surveys.iter_mut().for_each(|report| trace.grade(report));
    Ok(Result { trace, config, flight, surveys })
}

/// The flight of [`crate::flight::fly`] and the surveys of [`crate::flight::surveys`] in one run.
fn surveyed(config: &Config, samples: &[Sample]) -> std::result::Result<(Flight, Vec<SurveyReport>), Failure> {
    let mut probe = started(config, None)?;
    let mut surveyor = Surveyor::new();
    surveyor.configure(&config.earth, &config.survey).map_err(|error: ConfigError| Failure::Config(error))?;
    let mut flight = Flight { outputs: Vec::with_capacity(samples.len()), ..Flight::default() };
    let mut taken = Vec::new();
    for sample in samples {
        if let Some(output) = probe.push(sample) {
            let news = surveyor.push(&probe.survey_input(sample, &output));
            taken.extend(surveyor.stationary().filter(|_| news.contains(SurveyNews::STATIONARY)).copied());
            taken.extend(surveyor.rotating().filter(|_| news.contains(SurveyNews::ROTATING)).copied());
            flight.outputs.push(output);
        }
        flight.reports.extend(probe.poll(probe.poll_budget()));
        flight.diagnoses.extend(probe.take_diagnosis());
    }
    flight.reports.extend(std::iter::from_fn(|| probe.poll(0)));
    flight.diagnoses.extend(std::iter::from_fn(|| probe.take_diagnosis()));
    flight.magnets = probe.hard_iron_intervals().copied().collect();
    flight.counters = probe.counters();
    Ok((flight, taken))
}

impl Result {
    /// The result as `--json` has it.
    ///
    /// # Errors
    /// A value that JSON does not hold; there is none.
    pub fn json(&self) -> serde_json::Result<String> {
        let Self { trace, config, flight, surveys } = self;
        let reference = score::score(trace, flight, &score::Settings::of(trace, config));
        let diagnosed = diagnosed(trace, config, flight);
        result_json(trace, config, flight, &diagnosed, reference).with_surveys(surveys).text()
    }
}

/// The part of one recording; its attitude goes into a file, if there is one.
pub(super) fn fly(path: &Path, options: &Options, attitude: Option<&Path>) -> anyhow::Result<Part> {
    let flown = result(Trace::read(path)?, options)?;
    if let Some(file) = attitude {
        write_attitude_csv(&flown.flight.outputs, file)?;
    }
    // By way of the text: a number is then the one that a reader of the JSON has.
    let result = serde_json::from_str(&flown.json()?)?;
    Ok(Part { error: None, result, surveys: surveys_csv(&flown.surveys) })
}
