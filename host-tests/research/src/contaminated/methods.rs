//! Methods that are compared.

use super::{
    consensus::ransac,
    effort::Spent,
    graduated::{Schedule, first_mu, reweighted},
    levenberg_marquardt::levenberg_marquardt,
    loss::{HUBER, Loss, TUKEY},
    population::{Search, search_about},
    rail::at_gyro_rail,
    readings::Theta,
    segments::SegmentCost,
    window::{Answer, Window, lm_huber, ls_graduated, ls_huber, polished, segment_cost},
};
use testbed::simulate::random::Random;

/// A method to find twelve parameters.
pub(super) struct Method {
    pub name: String,
    pub run: Box<dyn Fn(&Window<'_>) -> Answer + Sync>,
}

impl Method {
    pub fn new(name: impl Into<String>, run: impl Fn(&Window<'_>) -> Answer + Sync + 'static) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }
}

const TUKEY_LOSS: Loss = Loss::Tukey(TUKEY);

/// Loss that a search minimises before the polish: of Tukey's (c 6) and Geman-McClure's with c 2 and 3, the
/// one that suits searches on the weak form best.
const SEARCHED_LOSS: Loss = Loss::GemanMcClure(3.0, 1.0);

/// Reach of a search about the Huber least-squares point, which contamination may have moved far, in
/// posterior deviations: of 10, 30, 100 and 300 the best for each search on the weak form.
const WIDE: f64 = 300.0;

/// Reach about a point that is either right or beyond saving.
const NARROW: f64 = 10.0;

/// Every method, cheap ones first.
pub(super) fn all() -> Vec<Method> {
    let mut methods = vec![
        Method::new("clean samples known, LS", known_ls),
        Method::new("clean samples known, LM on segments", known_lm),
        Method::new("LS Huber", ls_huber),
        Method::new("LS Huber, LM Huber", lm_huber),
        Method::new("LS Huber, LM Tukey", |w| polished(w, ls_huber(w), TUKEY_LOSS)),
        Method::new("LS Huber, LM Tukey, segments built again, LM Tukey", |w| {
            polished(w, polished(w, ls_huber(w), TUKEY_LOSS), TUKEY_LOSS)
        }),
        Method::new("LS Huber, LS Tukey", ls_tukey),
        Method::new("graduated non-convexity on segments, LM Tukey", graduated_segments),
        Method::new("RANSAC 100", |w| ransac(w, 100)),
        Method::new("RANSAC 300", |w| ransac(w, 300)),
        Method::new("16 restarts of LM Tukey", restarts),
        Method::new("LS-GNC (c 3)", |w| ls_graduated(w, Schedule::HALVED, false)),
        Method::new("LS-GNC (c 3), LM Tukey on segments", |w| {
            polished(w, ls_graduated(w, Schedule::HALVED, false), TUKEY_LOSS)
        }),
        Method::new("LS-GNC (c 2), Tukey", |w| ls_graduated(w, Schedule::POLISHED, false)),
        Method::new("LS-GNC (c 2), Tukey, coupled", |w| ls_graduated(w, Schedule::POLISHED, true)),
        Method::new("the same, test windows at the gyro's rail left out", without_rail),
        Method::new("the same in 16 solves", |w| ls_graduated(w, Schedule::QUARTERED, true)),
        Method::new("the same in 12 solves, not graduated", |w| ls_graduated(w, Schedule::SHORT, true)),
    ];
    for (search, most) in Search::ALL.into_iter().flat_map(|search| [(search, 500), (search, 2_000)]) {
        let name = search.name();
        methods.push(Method::new(
            format!("{name} {most} on segments about LS Huber, LM Tukey, segments built again, LM Tukey"),
            move |w| polished(w, searched_segments(w, ls_huber(w), search, most, WIDE), TUKEY_LOSS),
        ));
        methods.push(Method::new(format!("{name} {most} on the weak form about LS Huber, Tukey"), move |w| {
            searched_weak_form(w, ls_huber(w), search, most, WIDE)
        }));
    }
    methods.push(Method::new("LS-GNC (c 3), IMOA 300 on segments instead of LM", |w| {
        searched_segments(w, ls_graduated(w, Schedule::HALVED, false), Search::Imoa, 300, NARROW)
    }));
    for search in Search::ALL {
        let name = search.name();
        methods
            .push(Method::new(format!("{name} 2000 on the weak form about LS-GNC (c 2), Tukey, coupled"), move |w| {
                searched_weak_form(w, ls_graduated(w, Schedule::POLISHED, true), search, 2_000, NARROW)
            }));
    }
    methods
}

/// The weak form of the untouched test windows, known to an oracle.
fn known_ls(window: &Window<'_>) -> Answer {
    let problem = window.weak_form(false);
    let weights: Vec<f64> = problem.equations.iter().map(|e| if e.hit { 0.0 } else { 1.0 }).collect();
    let mut spent = Spent::default();
    spent.solve();
    Answer { theta: problem.solve(&weights), spent }
}

/// Tukey's weights from the Huber point, not graduated.
fn ls_tukey(window: &Window<'_>) -> Answer {
    let Answer { theta, mut spent } = ls_huber(window);
    Answer { theta: reweighted(&window.weak_form(false), TUKEY_LOSS, theta, 8, &mut spent), spent }
}

/// The recipe without test windows that hold a reading at a full scale, if the readings show one.
fn without_rail(window: &Window<'_>) -> Answer {
    let mut readings = window.readings.clone();
    for (sample, at_rail) in readings.samples.iter_mut().zip(at_gyro_rail(&window.readings)) {
        sample.hit = [at_rail, false, false];
    }
    let mut kept = Window::new(readings, window.prior, window.seed);
    kept.equations.retain(|e| !e.hit);
    ls_graduated(&kept, Schedule::POLISHED, true)
}

/// The untouched segments after that, known to an oracle.
fn known_lm(window: &Window<'_>) -> Answer {
    let Answer { theta, mut spent } = known_ls(window);
    let mut segments = window.segments(&theta);
    segments.sightings.retain(|s| !s.hit);
    let cost = segment_cost(&segments, window.prior, Loss::Huber(HUBER));
    let delta = levenberg_marquardt(&cost, Theta::zeros(), 30, &mut spent);
    Answer { theta: theta + delta, spent }
}

/// A Gauss-Newton step for each mu, halved down to 1 (c = 3), then Tukey.
fn graduated_segments(window: &Window<'_>) -> Answer {
    const C: f64 = 3.0;
    let Answer { theta, mut spent } = ls_huber(window);
    let segments = window.segments(&theta);
    let mut delta = Theta::zeros();
    let step = |delta: &mut Theta, mu: f64, spent: &mut Spent| {
        let (normal, descent) = segment_cost(&segments, window.prior, Loss::GemanMcClure(C, mu)).normal(delta);
        *delta += normal.cholesky().map_or_else(Theta::zeros, |factor| factor.solve(&descent));
        spent.solve();
    };
    let mut mu = first_mu(&segment_cost(&segments, window.prior, Loss::Square).squares(&delta), C);
    while mu > 1.0 {
        step(&mut delta, mu, &mut spent);
        mu *= 0.5;
    }
    for _ in 0..4 {
        step(&mut delta, 1.0, &mut spent);
    }
    let cost = segment_cost(&segments, window.prior, TUKEY_LOSS);
    let delta = levenberg_marquardt(&cost, delta, 30, &mut spent);
    Answer { theta: theta + delta, spent }
}

/// The lowest end of 16 descents from normal draws, 10 posterior deviations wide, about the Huber
/// least-squares point.
fn restarts(window: &Window<'_>) -> Answer {
    let Answer { theta, mut spent } = ls_huber(window);
    let segments = window.segments(&theta);
    let cost = segment_cost(&segments, window.prior, TUKEY_LOSS);
    let (normal, _) = segment_cost(&segments, window.prior, Loss::Huber(HUBER)).normal(&Theta::zeros());
    spent.matrices += 1;
    let Some(factor) = normal.cholesky() else { return Answer { theta, spent } };
    let mut random = Random::new(window.seed);
    let mut best = (Theta::zeros(), f64::INFINITY);
    for start in 0..16 {
        let draw = Theta::from_fn(|_, _| if start == 0 { 0.0 } else { 10.0 * random.normal() });
        let from = factor.l().tr_solve_lower_triangular(&draw).unwrap_or_else(Theta::zeros);
        let end = levenberg_marquardt(&cost, from, 30, &mut spent);
        let found = cost.evaluate(&end);
        spent.evaluations += 1;
        if found < best.1 {
            best = (end, found);
        }
    }
    Answer { theta: theta + best.0, spent }
}

/// A search on the segments, and Levenberg-Marquardt from its end on the same segments.
fn searched_segments(window: &Window<'_>, from: Answer, search: Search, most: u32, radius: f64) -> Answer {
    let Answer { theta, mut spent } = from;
    let segments = window.segments(&theta);
    let cost: SegmentCost<'_> = segment_cost(&segments, window.prior, TUKEY_LOSS);
    let (normal, _) = segment_cost(&segments, window.prior, Loss::Huber(HUBER)).normal(&Theta::zeros());
    let searched = segment_cost(&segments, window.prior, SEARCHED_LOSS);
    let evaluate = |delta: &Theta| searched.evaluate(delta);
    let found = search_about(search, &evaluate, normal, radius, (most, window.seed), &mut spent);
    let delta = levenberg_marquardt(&cost, found, 30, &mut spent);
    Answer { theta: theta + delta, spent }
}

/// A search on the weak form, and six re-weighted solves from its end.
fn searched_weak_form(window: &Window<'_>, from: Answer, search: Search, most: u32, radius: f64) -> Answer {
    let Answer { theta, mut spent } = from;
    let problem = window.weak_form(false);
    let (normal, _) = problem.normal(&problem.weights(Loss::Huber(HUBER), &theta));
    let evaluate = |delta: &Theta| problem.cost(SEARCHED_LOSS, &(theta + delta));
    let found = search_about(search, &evaluate, normal, radius, (most, window.seed), &mut spent);
    let end = reweighted(&window.weak_form(true), TUKEY_LOSS, theta + found, 6, &mut spent);
    Answer { theta: end, spent }
}
