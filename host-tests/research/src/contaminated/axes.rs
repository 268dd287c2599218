//! Unknown axes: a gyro whose axes are permuted and reversed, in a window that is hit as well.

use meerkat_mwd::optimizer::{Cost, OptimizerError, SearchSpace};
use nalgebra::Matrix3;

use super::{
    comparison::SUCCESS_RATIO,
    drilled::{Drilled, in_parallel},
    effort::Spent,
    graduated::{Schedule, graduated, reweighted},
    loss::{HUBER, Loss, TUKEY},
    population::Search,
    prior::Prior,
    readings::{Readings, Theta},
    weak_form::{WeakForm, equations, nominal_sigma},
    window::{Window, ls_graduated},
};
use testbed::{
    simulate::{Contamination, random::Random},
    study::Table,
};

/// The six orders of three axes.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Test windows for unknown rates, seconds: short, because the vectors turn within them.
pub(super) const SHORT_S: [f64; 2] = [0.4, 0.1];

/// Deviation of the elements of an unknown P.
const WIDE: f64 = 1.0;

/// All 48 signed permutations.
pub(super) fn signed_permutations() -> Vec<Matrix3<f64>> {
    let signs = |k: usize, axis: usize| if k >> axis & 1 == 0 { 1.0 } else { -1.0 };
    let one = |(order, k): (&[usize; 3], usize)| Matrix3::from_fn(|i, j| if order[i] == j { signs(k, i) } else { 0.0 });
    ORDERS.iter().flat_map(|order| (0..8).map(move |k| (order, k))).map(one).collect()
}

/// The signed permutation nearest to P.
fn nearest(theta: &Theta) -> Matrix3<f64> {
    let p = Matrix3::from_fn(|i, j| theta[3 * i + j]);
    let likeness = |s: &Matrix3<f64>| s.component_mul(&p).sum();
    signed_permutations()
        .into_iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .unwrap_or_else(Matrix3::identity)
}

/// The readings of a gyro whose axes are turned by `turn`.
fn turned(readings: &Readings, turn: &Matrix3<f64>) -> Readings {
    let mut turned = readings.clone();
    for sample in &mut turned.samples {
        sample.raw = turn * sample.raw;
    }
    turned
}

/// A prior that knows nothing of P.
pub(super) fn wide_prior() -> Prior {
    let data_sheet = Prior::data_sheet();
    let sigma = Theta::from_fn(|i, _| if i < 9 { WIDE } else { data_sheet.sigma[i] });
    Prior { mean: Theta::zeros(), sigma }
}

/// Way to find the axes.
#[derive(Clone, Copy, Debug)]
enum Finder {
    /// Takes them as they are.
    None,
    /// One linear solve with the wide prior, re-weighted if set.
    Linear(bool),
    /// The best of the 48 permutations by the recipe's cost.
    Every,
    /// A search of the wide box on the same equations' Geman-McClure cost (c 3).
    Search(Search, u32),
}

/// The Geman-McClure cost of the weak form itself.
struct Plain<'a>(WeakForm<'a>);

impl Cost<12> for Plain<'_> {
    fn evaluate(&self, x: &[f32; 12]) -> f32 {
        self.0.cost(Loss::GemanMcClure(3.0, 1.0), &Theta::from_fn(|i, _| f64::from(x[i]))) as f32
    }
}

/// The permutation to apply to the raw gyro, and its cost.
fn found(finder: Finder, readings: &Readings, seed: u64, spent: &mut Spent) -> Result<Matrix3<f64>, OptimizerError> {
    let prior = wide_prior();
    // Without a nominal rate the unknown is the rate itself, of whatever size.
    let problem = || WeakForm {
        equations: equations(readings, &Theta::zeros(), SHORT_S),
        sigma: nominal_sigma(readings.period_s, SHORT_S[0]),
        prior: &prior,
        coupled: true,
    };
    Ok(match finder {
        Finder::None => Matrix3::identity(),
        Finder::Linear(false) => {
            let problem = problem();
            let start = problem.unweighted(spent);
            nearest(&reweighted(&problem, Loss::Huber(HUBER), start, 8, spent))
        }
        Finder::Linear(true) => nearest(&graduated(&problem(), Schedule::POLISHED, spent)),
        Finder::Every => {
            let data_sheet = Prior::data_sheet();
            let mut best = (Matrix3::identity(), f64::INFINITY);
            for candidate in signed_permutations() {
                let window = Window::new(turned(readings, &candidate), &data_sheet, seed);
                let answer = ls_graduated(&window, Schedule::POLISHED, true);
                let cost = window.weak_form(true).cost(Loss::Tukey(TUKEY), &answer.theta);
                spent.evaluations += answer.spent.evaluations + 1;
                spent.matrices += answer.spent.matrices;
                if cost < best.1 {
                    best = (candidate, cost);
                }
            }
            best.0
        }
        Finder::Search(search, most) => {
            let bound: [f32; 12] = std::array::from_fn(|i| if i < 9 { 1.3 } else { 0.1 });
            let space = SearchSpace::within(bound.map(|b| -b), bound)?;
            spent.evaluations += most;
            let best = search.best(&Plain(problem()), &space, most, seed)?;
            nearest(&Theta::from_fn(|i, _| f64::from(best[i])))
        }
    })
}

/// Share of windows whose axes are found, and whose fit is good after that.
pub(super) fn table(runs: &[Drilled]) -> anyhow::Result<Table> {
    let title = "Gyro axes exchanged and turned round (one of 48, drawn) in windows that are hit, the kinds by turns: axes found, % / fit \
                 good after that, %"
        .to_owned();
    let shares = [0.0, 0.3, 0.5];
    let mut table = Table::new(title, &["how the axes are found", "cost", "not hit", "30 % hit", "50 % hit"]);
    let finders = [
        ("taken as they are", Finder::None),
        ("one linear problem, wide prior, Huber", Finder::Linear(false)),
        ("the same, LS-GNC (c 2), Tukey, coupled", Finder::Linear(true)),
        ("all 48 tried by LS-GNC", Finder::Every),
        ("IMOA 2000 in the wide box", Finder::Search(Search::Imoa, 2_000)),
        ("PSO 2000 in the wide box", Finder::Search(Search::Pso, 2_000)),
        ("DE 2000 in the wide box", Finder::Search(Search::DifferentialEvolution, 2_000)),
    ];
    for (name, finder) in finders {
        let outcomes: Result<Vec<(bool, bool, u32)>, OptimizerError> =
            in_parallel(runs.len() * shares.len(), |index| {
                let (run, share) = (&runs[index / shares.len()], shares[index % shares.len()]);
                let kind = Contamination::ALL[run.seed as usize % Contamination::ALL.len()];
                let readings = run.readings((share > 0.0).then_some(kind), share);
                let drawn = (Random::new(run.seed ^ 0xA7E5).uniform() * 48.0) as usize;
                let truth = signed_permutations()[drawn];
                let readings = turned(&readings, &truth);
                let mut spent = Spent::default();
                let back = found(finder, &readings, run.seed, &mut spent)?;
                let prior = Prior::data_sheet();
                let window = Window::new(turned(&readings, &back), &prior, run.seed);
                let answer = ls_graduated(&window, Schedule::POLISHED, true);
                let right = back == truth.transpose();
                Ok((right, right && run.ratio(&answer.theta) < SUCCESS_RATIO, spent.total()))
            })
            .into_iter()
            .collect();
        let outcomes = outcomes?;
        let mut costs: Vec<u32> = outcomes.iter().map(|o| o.2).collect();
        costs.sort_unstable();
        let cell = |column: usize| {
            let of: Vec<_> = outcomes.iter().skip(column).step_by(shares.len()).collect();
            let percent = |good: usize| 100.0 * good as f64 / of.len() as f64;
            let (right, good) = (of.iter().filter(|o| o.0).count(), of.iter().filter(|o| o.1).count());
            format!("{:.0} / {:.0}", percent(right), percent(good))
        };
        table.row([name.to_owned(), costs[costs.len() / 2].to_string(), cell(0), cell(1), cell(2)]);
    }
    Ok(table)
}
