//! The `--json` file, schema `meerkat-mwd/1`. Fields may be added, never renamed. A number that does not
//! exist is `null`: serde_json writes NaN and infinities so.

use std::{
    collections::BTreeMap,
    io::{BufWriter, Write},
    path::Path,
};

use meerkat_mwd::{
    Config, SampleFlags, compensation::Effect, diagnosis::EffectReport, magnet::HardIronInterval, survey::SurveyReport,
};
use serde::Serialize;
use serde_json::{Map, Value};

mod configuration;
pub mod parameters;
mod probe_reports;
mod remainder;
mod surveys;
mod window;

pub(crate) use configuration::Configuration;
pub use probe_reports::{diagnosis_json, window_json};

use parameters::{Parameters, in_seconds};
use remainder::RemainderJson;
use surveys::surveys_json;
use window::Window;

use crate::{
    diagnosis::{Diagnosed, Found, HARD_IRON, VectorResidual},
    report::{
        account::verdict_name,
        explanation::Explanation,
        motion,
        window_note::{missing, why_no_window},
    },
};
use testbed::{
    console,
    failure::Failure,
    flight::Flight,
    score::Reference,
    trace::{Trace, clipping_is_known, motion::name},
};

/// The whole result of a flight.
#[derive(Debug, Serialize)]
pub struct ResultJson {
    schema: &'static str,
    version: &'static str,
    seed: u64,
    configuration: Configuration,
    trace: TraceFacts,
    identification: Identification,
    diagnosis: Diagnosis,
    reference: Option<Reference>,
    surveys: Vec<Map<String, Value>>,
}

#[derive(Debug, Serialize)]
struct TraceFacts {
    path: String,
    serial: Option<String>,
    date: Option<String>,
    samples: usize,
    duration_s: f64,
    rate_hz: Option<f64>,
    gaps: usize,
    clipped: Option<usize>,
    missing: Missing,
    dropped: DroppedRows,
    notes: Vec<String>,
    wrong: Vec<String>,
}

#[derive(Debug, Serialize)]
struct DroppedRows {
    repeated: usize,
    late: usize,
}

#[derive(Debug, Serialize)]
struct Missing {
    gyro: usize,
    accel: usize,
    mag: usize,
    temp: usize,
    reference: usize,
}

#[derive(Debug, Serialize)]
struct Identification {
    /// The kind of motion, and where it was stated.
    motion: &'static str,
    motion_from: &'static str,
    windows: Vec<Window>,
    note: Option<String>,
    hold_out_from_s: Option<f64>,
    #[serde(rename = "final")]
    last: Parameters,
}

#[derive(Debug, Serialize)]
struct Diagnosis {
    /// Verdict of the diagnosis; `null` if effects were not looked for.
    verdict: Option<&'static str>,
    /// Motion or readings that are missing; `null` if enough is there.
    missing: Option<String>,
    effects: Vec<EffectJson>,
    residual: VectorResidual,
    /// Remainder that the last diagnosis leaves unexplained; `null` if there is none.
    remainder: Option<RemainderJson>,
}

#[derive(Debug, Serialize)]
struct EffectJson {
    name: &'static str,
    aliases: Vec<&'static str>,
    parameters: BTreeMap<&'static str, f32>,
    sigma: BTreeMap<&'static str, f32>,
    active_s: Vec<[f64; 2]>,
    /// When the effect was found, and since when it is taken out, seconds; `null` if not.
    found_s: Option<f64>,
    taken_out_s: Option<f64>,
    /// Log Bayes factor.
    evidence: Option<f32>,
    /// True if it is taken out of the readings.
    taken_out: bool,
    residual_before: Option<f64>,
    residual_after: Option<f64>,
    residual_unit: &'static str,
}

impl EffectJson {
    fn new(found: &Found) -> Self {
        Self {
            residual_before: found.residual_deg().before,
            residual_after: found.residual_deg().after,
            ..Self::of_report(found.effect, &found.report, found.aliases(), found.active_s)
        }
    }

    /// Entry of an effect whose residual nobody has computed.
    fn of_report(effect: &dyn Effect, report: &EffectReport, aliases: Vec<&'static str>, active_s: [f64; 2]) -> Self {
        let by_name = |values: &[f32]| {
            let parameters = effect.parameters().iter().zip(values);
            parameters.map(|(parameter, value)| (parameter.name, value * parameter.in_unit)).collect()
        };
        Self {
            name: effect.name(),
            aliases,
            parameters: by_name(&report.found.parameters),
            sigma: by_name(&report.found.sigma),
            active_s: vec![active_s],
            found_s: Some(in_seconds(report.found_us)),
            taken_out_s: report.is_taken_out().then(|| in_seconds(report.taken_out_us)),
            evidence: Some(report.evidence),
            taken_out: report.is_taken_out(),
            residual_before: None,
            residual_after: None,
            residual_unit: "deg",
        }
    }

    /// A magnet that came while the probe ran. It was decided at odds of a million to one and has no residual
    /// of its own.
    fn of_magnet(magnet: &HardIronInterval, end_s: f64) -> Self {
        let names = ["x_ut", "y_ut", "z_ut"];
        Self {
            name: HARD_IRON,
            aliases: Vec::new(),
            parameters: names.into_iter().zip(magnet.offset_ut).collect(),
            sigma: names.into_iter().zip(magnet.sigma_ut).collect(),
            active_s: vec![[in_seconds(magnet.from_us), magnet.to_us.map_or(end_s, in_seconds)]],
            found_s: None,
            taken_out_s: None,
            evidence: None,
            taken_out: magnet.is_corrected(),
            residual_before: None,
            residual_after: None,
            residual_unit: "deg",
        }
    }
}

/// The result of a flight over `trace`.
#[must_use]
pub fn result_json(
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    diagnosed: &Diagnosed,
    reference: Option<Reference>,
) -> ResultJson {
    let known = clipping_is_known(&config.full_scale);
    let (facts, period_us) = (trace.facts(), trace.nominal_period_us());
    ResultJson {
        schema: "meerkat-mwd/1",
        version: env!("CARGO_PKG_VERSION"),
        seed: config.seed,
        configuration: Configuration::of(config, flight),
        trace: TraceFacts {
            path: trace.path.to_string_lossy().into_owned(),
            serial: trace.keys.serial.clone(),
            date: trace.keys.date.map(|date| date.to_string()),
            samples: trace.len(),
            duration_s: in_seconds(trace.duration_us()),
            rate_hz: (period_us > 0).then(|| 1e6 / f64::from(period_us)),
            gaps: facts.gaps,
            clipped: known.then_some(facts.clipped),
            missing: Missing {
                gyro: facts.count(SampleFlags::GYRO_MISSING),
                accel: facts.count(SampleFlags::ACCEL_MISSING),
                mag: facts.count(SampleFlags::MAG_MISSING),
                temp: facts.count(SampleFlags::TEMPERATURE_MISSING),
                reference: facts.without_reference(),
            },
            dropped: DroppedRows { repeated: trace.dropped.repeated, late: trace.dropped.late },
            notes: trace.notes.clone(),
            wrong: trace.wrong.clone(),
        },
        identification: Identification {
            motion: name(config.identification.motion),
            motion_from: motion::origin(trace, config),
            windows: flight.reports.iter().map(|report| Window::new(report, config)).collect(),
            note: why_no_window(trace, config, flight),
            hold_out_from_s: flight.frozen_at_us.map(in_seconds),
            last: Parameters::at_the_end(config, flight),
        },
        diagnosis: Diagnosis {
            verdict: config.effects.then(|| verdict_name(diagnosed.verdict)),
            missing: missing(trace, config, flight, diagnosed).filter(|_| config.effects),
            effects: {
                let end_s = in_seconds(trace.last_us());
                let magnets = diagnosed.magnets.iter().map(|magnet| EffectJson::of_magnet(magnet, end_s));
                diagnosed.effects.iter().map(EffectJson::new).chain(magnets).collect()
            },
            residual: diagnosed.residual,
            remainder: diagnosed.remainder().map(RemainderJson::new),
        },
        reference,
        surveys: Vec::new(),
    }
}

impl ResultJson {
    /// Adds the surveys that were taken.
    #[must_use]
    pub fn with_surveys(mut self, surveys: &[SurveyReport]) -> Self {
        self.surveys = surveys_json(surveys);
        self
    }

    /// Adds the explanations to the windows.
    #[must_use]
    pub fn explained(mut self, explanation: &Explanation) -> Self {
        for (window, explained) in self.identification.windows.iter_mut().zip(explanation.windows()) {
            window.explanation = *explained;
        }
        self
    }

    /// The result as text.
    ///
    /// # Errors
    /// When a value cannot be written as JSON.
    pub fn text(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }

    /// Writes the result, indented.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let write = || -> std::io::Result<()> {
            let mut file = BufWriter::new(console::create(path)?);
            writeln!(file, "{}", self.text()?)?;
            file.flush()
        };
        write().map_err(|error| Failure::output(path, &error))
    }
}
