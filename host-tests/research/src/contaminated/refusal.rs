//! Refusal: how hopeless windows are told from the others.

use super::{
    comparison::{KIND_HEADS, SUCCESS_RATIO},
    drilled::{Drilled, in_parallel},
    graduated::Schedule,
    loss::{Loss, TUKEY},
    prior::Prior,
    window::{Window, ls_graduated},
};
use testbed::{simulate::Contamination, study::Table};

/// Shares of the study, and hopeless ones beyond them.
const SHARES: [f64; 8] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];

/// Index of the last share of the study.
const LAST_OF_STUDY: usize = 4;

struct Judged {
    /// Kind and share; `None` if not hit.
    hit: Option<(usize, usize)>,
    ratio: f64,
    statistic: f64,
}

/// Mean final Tukey weight over the field's equations at the nominal scale: the share of the window that
/// agrees with the fit. For clean windows it is the mean of (1 - z^2 / c^2)^2 over a chi-square z^2 with
/// three degrees of freedom, 0.84 at c = 6: an expectation that needs no recording.
fn agreement(window: &Window<'_>, theta: &super::readings::Theta) -> f64 {
    let problem = window.weak_form(false);
    let weights = problem.weights(Loss::Tukey(TUKEY), theta);
    let field: Vec<f64> =
        problem.equations.iter().zip(&weights).filter(|(e, _)| e.sensor == 1).map(|(_, w)| *w).collect();
    field.iter().sum::<f64>() / field.len() as f64
}

/// Rates of refusal by threshold; and success and the statistic by kind and share.
pub(super) fn tables(runs: &[Drilled]) -> [Table; 2] {
    let prior = Prior::data_sheet();
    let cases: Vec<Option<(usize, usize)>> = std::iter::once(None)
        .chain((0..Contamination::ALL.len()).flat_map(|kind| (0..SHARES.len()).map(move |share| Some((kind, share)))))
        .collect();
    let judged = in_parallel(runs.len() * cases.len(), |index| {
        let (run, hit) = (&runs[index / cases.len()], cases[index % cases.len()]);
        let (kind, share) = hit.map_or((None, 0.0), |(kind, share)| (Some(Contamination::ALL[kind]), SHARES[share]));
        let window = Window::new(run.readings(kind, share), &prior, run.seed);
        let theta = ls_graduated(&window, Schedule::POLISHED, true).theta;
        Judged { hit, ratio: run.ratio(&theta), statistic: agreement(&window, &theta) }
    });
    [thresholds(&judged), by_share(&judged)]
}

fn thresholds(judged: &[Judged]) -> Table {
    let title =
        "Refusal when the mean final weight of the field's equations is under a threshold, % of windows".to_owned();
    let columns = [
        "threshold",
        "not hit, refused",
        "10 to 50 % hit and good, refused",
        "10 to 50 % hit and bad, refused",
        "60 to 80 % hit and bad, refused",
        "60 to 80 % hit, refused",
        "bad among the accepted, 10 to 50 %",
        "bad among the accepted, 60 to 80 %",
        "bad among the accepted, gyro not clipped, all shares",
    ];
    let clipped = Contamination::ALL.iter().position(|kind| *kind == Contamination::GyroClipping);
    let mut table = Table::new(title, &columns);
    for threshold in [0.0, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5] {
        let refused = |j: &Judged| j.statistic < threshold;
        let bad = |j: &Judged| j.ratio.partial_cmp(&SUCCESS_RATIO) != Some(std::cmp::Ordering::Less);
        let studied = |j: &Judged| j.hit.is_some_and(|(_, share)| share <= LAST_OF_STUDY);
        let beyond = |j: &Judged| j.hit.is_some_and(|(_, share)| share > LAST_OF_STUDY);
        let not_clipped = |j: &Judged| j.hit.is_some_and(|(kind, _)| Some(kind) != clipped);
        let percent = |among: &dyn Fn(&Judged) -> bool, of: &dyn Fn(&Judged) -> bool| {
            let all: Vec<&Judged> = judged.iter().filter(|j| among(j)).collect();
            let some = all.iter().filter(|j| of(j)).count();
            format!("{:.1} of {}", 100.0 * some as f64 / all.len().max(1) as f64, all.len())
        };
        table.row([
            format!("{threshold}"),
            percent(&|j| j.hit.is_none(), &refused),
            percent(&|j| studied(j) && !bad(j), &refused),
            percent(&|j| studied(j) && bad(j), &refused),
            percent(&|j| beyond(j) && bad(j), &refused),
            percent(&beyond, &refused),
            percent(&|j| studied(j) && !refused(j), &bad),
            percent(&|j| beyond(j) && !refused(j), &bad),
            percent(&|j| not_clipped(j) && !refused(j), &bad),
        ]);
    }
    table
}

fn by_share(judged: &[Judged]) -> Table {
    let heads = SHARES.map(|share| format!("{:.0} %", 100.0 * share));
    let mut columns = vec!["kind"];
    columns.extend(heads.iter().map(String::as_str));
    let title =
        "Success, % (median of the statistic) by share of the samples hit: LS-GNC (c 2), Tukey, coupled".to_owned();
    let mut table = Table::new(title, &columns);
    let cell = |among: &dyn Fn(&Judged) -> bool| {
        let mut statistics: Vec<f64> = judged.iter().filter(|j| among(j)).map(|j| j.statistic).collect();
        statistics.sort_by(f64::total_cmp);
        let ratios = judged.iter().filter(|j| among(j)).map(|j| j.ratio);
        let percent = super::comparison::success_percent(ratios);
        format!("{percent} ({:.2})", statistics.get(statistics.len() / 2).copied().unwrap_or(f64::NAN))
    };
    for (kind, head) in KIND_HEADS.into_iter().enumerate() {
        let cells = (0..SHARES.len()).map(|share| cell(&|j| j.hit == Some((kind, share))));
        table.row(std::iter::once(head.to_owned()).chain(cells));
    }
    table.row(["not hit".to_owned(), cell(&|j| j.hit.is_none())]);
    table
}
