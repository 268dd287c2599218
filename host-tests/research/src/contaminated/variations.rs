//! Dependence of the recipe on test windows, nominal scale and schedule.

use super::{
    comparison::{compare, compare_with},
    drilled::Drilled,
    effort::Spent,
    graduated::{Schedule, graduated},
    methods::Method,
    readings::{Reading, Readings},
    weak_form::{TEST_WINDOW_S, nominal_sigma},
    window::{Answer, ls_graduated},
};
use nalgebra::Vector3;
use testbed::study::Table;

/// The recipe with another scale.
fn scaled(name: String, length_s: f64, factors: [f64; 2]) -> Method {
    Method::new(name, move |window| {
        let nominal = nominal_sigma(window.readings.period_s, length_s);
        let sigma = [nominal[0] * factors[0], nominal[1] * factors[1]];
        let mut spent = Spent::default();
        let theta = graduated(&window.scaled_weak_form(true, sigma), Schedule::POLISHED, &mut spent);
        Answer { theta, spent }
    })
}

/// Success by length and hop of the test windows, at the sensors' rate and summed to half of it.
pub(super) fn test_windows(runs: &[Drilled]) -> Table {
    let title = "Test windows: LS-GNC (c 2), Tukey, coupled".to_owned();
    let mut all: Option<Table> = None;
    for test_window_s in [[0.5, 0.125], [1.0, 0.5], [1.0, 0.25], [1.6, 0.4], [2.0, 0.5], [2.0, 1.0], [3.0, 0.75]] {
        let [length_s, hop_s] = test_window_s;
        for (rate, parts) in [("100 Hz", 1), ("50 Hz", 2)] {
            let name = format!("{length_s} s every {hop_s} s, {rate}");
            let method = [scaled(name, length_s, [1.0; 2])];
            let table = compare_with(title.clone(), runs, &method, test_window_s, |r| averaged(r, parts));
            match &mut all {
                None => all = Some(table),
                Some(all) => all.rows.extend(table.rows),
            }
        }
    }
    all.unwrap_or_default()
}

/// Means over `parts` samples.
fn averaged(readings: &Readings, parts: usize) -> Readings {
    let mean = |group: &[Reading]| {
        let count = group.len() as f64;
        Reading {
            raw: group.iter().map(|s| s.raw).sum::<Vector3<f64>>() / count,
            vectors: [0, 1].map(|v| group.iter().map(|s| s.vectors[v]).sum::<Vector3<f64>>() / count),
            hit: [0, 1, 2].map(|h| group.iter().any(|s| s.hit[h])),
        }
    };
    let samples = readings.samples.chunks_exact(parts).map(mean).collect();
    Readings { period_s: readings.period_s * parts as f64, samples }
}

/// Success when the nominal scale is wrong.
pub(super) fn scales(runs: &[Drilled]) -> Table {
    let both = [0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0].map(|f| (format!("both times {f}"), [f, f]));
    let gravity = [0.25, 4.0].map(|f| (format!("gravity's times {f}"), [f, 1.0]));
    let field = [0.5, 2.0].map(|f| (format!("the field's times {f}"), [1.0, f]));
    let methods: Vec<Method> = both
        .into_iter()
        .chain(gravity)
        .chain(field)
        .map(|(name, factors)| scaled(name, TEST_WINDOW_S[0], factors))
        .collect();
    compare("Nominal scale of the equations wrong: LS-GNC (c 2), Tukey, coupled".to_owned(), runs, &methods)
}

/// Success by schedule of non-convexity.
pub(super) fn schedules(runs: &[Drilled]) -> Table {
    let halved = Schedule::POLISHED;
    let quartered = Schedule::QUARTERED;
    let at_once = Schedule { most: 1.0, ..halved };
    let methods = [
        ("c 2, mu halved, 10 solves at mu = 1, 12 Tukey", Schedule { last: 10, tukey: 12, ..halved }),
        ("c 2, mu halved, 4 at mu = 1, 6 Tukey", halved),
        ("c 3, the same", Schedule { constant: 3.0, ..halved }),
        ("c 2, mu quartered, 3 at mu = 1, 4 Tukey", quartered),
        ("c 3, the same", Schedule { constant: 3.0, ..quartered }),
        ("not graduated: 9 at c 3, mu = 1, 3 Tukey", Schedule { constant: 3.0, last: 9, tukey: 3, ..at_once }),
        ("not graduated: 3 Huber, 5 at c 3, mu = 1, 3 Tukey", Schedule { constant: 3.0, ..Schedule::SHORT }),
        ("not graduated: 3 Huber, 5 at c 2, mu = 1, 3 Tukey", Schedule::SHORT),
        (
            "not graduated: 3 Huber, 3 at c 3, mu = 1, 2 Tukey",
            Schedule { constant: 3.0, last: 3, tukey: 2, ..Schedule::SHORT },
        ),
    ]
    .map(|(name, schedule)| Method::new(name, move |window| ls_graduated(window, schedule, true)));
    compare("Schedules, coupled".to_owned(), runs, &methods)
}
