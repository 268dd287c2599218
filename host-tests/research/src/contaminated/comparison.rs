//! Comparison of methods over every kind and share of contamination.

use super::{
    drilled::{Drilled, SHARES, in_parallel},
    effort::Spent,
    methods::Method,
    prior::Prior,
    readings::Readings,
    weak_form::TEST_WINDOW_S,
    window::Window,
};
use testbed::{
    simulate::Contamination,
    study::{Table, median_and_worst},
};

/// Ratio of an error to the clean fit's below which a fit is a success.
pub(super) const SUCCESS_RATIO: f64 = 2.0;

/// One window under one kind: each method's error over the clean fit's, and its cost.
struct Outcome {
    /// Kind of contamination; `None` if not hit.
    kind: Option<Contamination>,
    share_index: usize,
    found: Vec<(f64, Spent)>,
}

/// Percentage of ratios under [`SUCCESS_RATIO`].
pub(super) fn success_percent(ratios: impl IntoIterator<Item = f64>) -> String {
    let (count, good) =
        ratios.into_iter().fold((0_u32, 0_u32), |(n, good), x| (n + 1, good + u32::from(x < SUCCESS_RATIO)));
    if count == 0 { "-".to_owned() } else { format!("{:.1}", 100.0 * f64::from(good) / f64::from(count)) }
}

/// Heads of the kinds' columns, in the order of [`Contamination::ALL`].
pub(super) const KIND_HEADS: [&str; 7] = [
    "casing joints",
    "magnetic bursts",
    "attitude-dependent",
    "shock trains",
    "gyro clipped",
    "accel or mag clipped",
    "gyro bursts",
];

/// Compares the methods on test windows of the usual length.
pub(super) fn compare(title: String, runs: &[Drilled], methods: &[Method]) -> Table {
    compare_with(title, runs, methods, TEST_WINDOW_S, Clone::clone)
}

/// Compares the methods on readings that `prepare` changes first.
pub(super) fn compare_with(
    title: String,
    runs: &[Drilled],
    methods: &[Method],
    test_window_s: [f64; 2],
    prepare: impl Fn(&Readings) -> Readings + Sync,
) -> Table {
    let kinds: Vec<Option<Contamination>> = std::iter::once(None).chain(Contamination::ALL.map(Some)).collect();
    let prior = Prior::data_sheet();
    let outcomes = in_parallel(runs.len() * kinds.len(), |index| {
        let (run, kind) = (&runs[index / kinds.len()], kinds[index % kinds.len()]);
        let readings = prepare(&run.readings(kind, run.share()));
        let window = Window::with_test_windows(readings, &prior, run.seed, test_window_s);
        let found = methods.iter().map(|method| {
            let answer = (method.run)(&window);
            (run.ratio(&answer.theta), answer.spent)
        });
        Outcome { kind, share_index: run.share_index(), found: found.collect() }
    });
    let shares = SHARES.map(|share| format!("{:.0} %", 100.0 * share));
    let mut columns = vec!["method", "cost", "all"];
    columns.extend(KIND_HEADS);
    columns.extend(shares.iter().map(String::as_str));
    columns.push("not hit: error over clean fit's");
    let mut table = Table::new(title, &columns);
    for (row, method) in methods.iter().enumerate() {
        let of = |wanted: &dyn Fn(&Outcome) -> bool| -> Vec<f64> {
            outcomes.iter().filter(|o| wanted(o)).map(|o| o.found[row].0).collect()
        };
        let mut costs: Vec<u32> = outcomes.iter().map(|o| o.found[row].1.total()).collect();
        costs.sort_unstable();
        let mut cells = vec![method.name.clone(), costs.get(costs.len() / 2).map_or_else(String::new, u32::to_string)];
        cells.push(success_percent(of(&|o| o.kind.is_some())));
        cells.extend(Contamination::ALL.map(|kind| success_percent(of(&|o| o.kind == Some(kind)))));
        cells.extend((0..SHARES.len()).map(|k| success_percent(of(&|o| o.kind.is_some() && o.share_index == k))));
        cells.push(median_and_worst(&of(&|o| o.kind.is_none()), 2).text);
        table.row(cells);
    }
    table
}
