//! The library itself on the same contaminated samples.

use meerkat_mwd::{
    Config, SampleFlags,
    compensation::GyroModel,
    config::{OptimizerKind, VectorErrors},
    identification::{Decision, WindowReport},
};

use super::{
    comparison::{KIND_HEADS, SUCCESS_RATIO},
    drilled::{Drilled, WINDOW, in_parallel},
};
use testbed::{
    flight::{configuration::of_trace, fly_frozen},
    simulate::{Contamination, Hits},
    study::{Table, one_window::CALIBRATED},
    trace::Trace,
};

/// Ratio of errors from which what is flown counts as worse than the factory's P with the bias from rest.
const NO_WORSE: f64 = 1.05;

/// Errors of the fit, of the bias alone and as flown, over the clean fit's.
struct Flown {
    kind: Option<usize>,
    share: usize,
    fitted: f64,
    bias_only: f64,
    flown: f64,
    accepted: bool,
}

/// Success of the fit, and how often what is flown is worse than the bias alone.
pub(super) fn table(which: &str, runs: &[Drilled]) -> anyhow::Result<Table> {
    let title = format!(
        "The library on {which} (frozen after one window): fits with an error under twice that of the clean fit, %; \
                 accepted, %; flown worse than bias only, %"
    );
    let mut columns = vec!["search", "all hit", "accepted", "flown worse", "bad fits accepted"];
    columns.extend(KIND_HEADS);
    columns.extend(["not hit", "not hit, accepted", "10 %", "20 %", "30 %", "40 %", "50 %"]);
    let mut table = Table::new(title, &columns);
    let kinds: Vec<Option<usize>> = std::iter::once(None).chain((0..Contamination::ALL.len()).map(Some)).collect();
    let sheet = VectorErrors::default();
    // Flights without the readings that were hit show the most that any treatment of these could give.
    let searches = [
        ("IMOA", OptimizerKind::Imoa, sheet, false),
        ("LM", OptimizerKind::Lm, sheet, false),
        ("LS", OptimizerKind::Ls, sheet, false),
        ("IMOA, told which readings are hit", OptimizerKind::Imoa, sheet, true),
        ("IMOA, vector sensors declared to be calibrated, as they are", OptimizerKind::Imoa, CALIBRATED, false),
        ("the same, told which readings are hit", OptimizerKind::Imoa, CALIBRATED, true),
    ];
    for (name, optimizer, errors, is_told) in searches {
        let flights: anyhow::Result<Vec<Flown>> = in_parallel(runs.len() * kinds.len(), |index| {
            let (run, kind) = (&runs[index / kinds.len()], kinds[index % kinds.len()]);
            let (mut trace, hits) = run.hit(kind.map(|kind| Contamination::ALL[kind]), run.share());
            if let Some(hits) = hits.filter(|_| is_told) {
                leave_out(&mut trace, &hits);
            }
            flown(run, kind, trace, (optimizer, errors))
        })
        .into_iter()
        .collect();
        let flights = flights?;
        let percent = |among: &dyn Fn(&Flown) -> bool, of: &dyn Fn(&Flown) -> bool| {
            let all: Vec<&Flown> = flights.iter().filter(|f| among(f)).collect();
            let some = all.iter().filter(|f| of(f)).count();
            if all.is_empty() { "-".to_owned() } else { format!("{:.1}", 100.0 * some as f64 / all.len() as f64) }
        };
        let good = |f: &Flown| f.fitted < SUCCESS_RATIO;
        let hit = |f: &Flown| f.kind.is_some();
        let mut cells = vec![name.to_owned(), percent(&hit, &good), percent(&hit, &|f| f.accepted)];
        cells.push(percent(&hit, &|f| f.flown > NO_WORSE * f.bias_only));
        cells.push(percent(&|f| hit(f) && !good(f), &|f| f.accepted));
        cells.extend((0..KIND_HEADS.len()).map(|kind| percent(&|f| f.kind == Some(kind), &good)));
        cells.push(percent(&|f| !hit(f), &good));
        cells.push(percent(&|f| !hit(f), &|f| f.accepted));
        for share in 0..5 {
            cells.push(percent(&|f| hit(f) && f.share == share, &good));
        }
        table.row(cells);
    }
    Ok(table)
}

/// Marks the readings that were hit as missing.
fn leave_out(trace: &mut Trace, hits: &Hits) {
    for (index, sample) in trace.samples.iter_mut().enumerate() {
        for (hit, flag) in [
            (&hits.gyro, SampleFlags::GYRO_MISSING),
            (&hits.accel, SampleFlags::ACCEL_MISSING),
            (&hits.mag, SampleFlags::MAG_MISSING),
        ] {
            sample.flags.set(flag, sample.flags.contains(flag) || hit.get(index) == Some(&true));
        }
    }
}

/// Flies the window from its first sample on, so that the library's window is the study's.
fn flown(
    run: &Drilled,
    kind: Option<usize>,
    mut trace: Trace,
    (optimizer, errors): (OptimizerKind, VectorErrors),
) -> anyhow::Result<Flown> {
    trace.samples.drain(..WINDOW.start);
    let mut config: Config = of_trace(&trace);
    // Only the identification is measured.
    config.effects = false;
    let (window_s, latency_s) = (config.identification.window_s, config.identification.latency_s);
    let freeze_us = trace.first_us() + (f64::from(window_s + latency_s) * 1e6) as u64;
    config.identification.optimizer = optimizer;
    config.identification.vector_errors = errors;
    config.seed = run.seed;
    let flight = fly_frozen(&config, freeze_us, &trace.samples)?;
    let report: Option<&WindowReport> = flight.reports.last();
    let ratio =
        |model: Option<GyroModel>| run.model_error_rad_s(&model.unwrap_or(GyroModel::IDENTITY)) / run.clean_error_rad_s;
    Ok(Flown {
        kind,
        share: run.share_index(),
        fitted: ratio(report.map(|r| r.fitted)),
        bias_only: ratio(report.map(|r| r.bias_only)),
        flown: ratio(report.map(|r| r.flown)),
        accepted: report.is_some_and(|r| r.decision == Decision::Accepted),
    })
}
