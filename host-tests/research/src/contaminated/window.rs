use super::{
    effort::Spent,
    graduated::{Schedule, graduated, reweighted},
    levenberg_marquardt::levenberg_marquardt,
    loss::{HUBER, Loss},
    prior::Prior,
    readings::{Readings, Theta, identity},
    segments::{NOMINAL_SIGMA, SegmentCost, Segments},
    weak_form::{Equation, TEST_WINDOW_S, WeakForm, equations, nominal_sigma},
};

/// Input of every method.
pub(super) struct Window<'a> {
    pub readings: Readings,
    /// Equations about the factory's rates.
    pub equations: Vec<Equation>,
    pub prior: &'a Prior,
    /// Seed of what a method draws.
    pub seed: u64,
}

/// Result of a method, and its cost.
pub(super) struct Answer {
    pub theta: Theta,
    pub spent: Spent,
}

impl<'a> Window<'a> {
    pub fn new(readings: Readings, prior: &'a Prior, seed: u64) -> Self {
        Self::with_test_windows(readings, prior, seed, TEST_WINDOW_S)
    }

    pub fn with_test_windows(readings: Readings, prior: &'a Prior, seed: u64, test_window_s: [f64; 2]) -> Self {
        let equations = equations(&readings, &identity(), test_window_s);
        Self { readings, equations, prior, seed }
    }

    /// The weak form with the nominal scale of test windows of the usual length.
    pub fn weak_form(&self, coupled: bool) -> WeakForm<'a> {
        self.scaled_weak_form(coupled, nominal_sigma(self.readings.period_s, TEST_WINDOW_S[0]))
    }

    pub fn scaled_weak_form(&self, coupled: bool, sigma: [f64; 2]) -> WeakForm<'a> {
        WeakForm { equations: self.equations.clone(), sigma, prior: self.prior, coupled }
    }

    pub fn segments(&self, theta: &Theta) -> Segments {
        Segments::new(&self.readings, theta)
    }
}

/// The cost of segments with the nominal scale.
pub(super) fn segment_cost<'b>(segments: &'b Segments, prior: &'b Prior, loss: Loss) -> SegmentCost<'b> {
    SegmentCost { segments, sigma: NOMINAL_SIGMA, prior, loss }
}

/// The weak form with Huber's weights, where every method on segments starts.
pub(super) fn ls_huber(window: &Window<'_>) -> Answer {
    let mut spent = Spent::default();
    let problem = window.weak_form(false);
    let start = problem.unweighted(&mut spent);
    let theta = reweighted(&problem, Loss::Huber(HUBER), start, 8, &mut spent);
    Answer { theta, spent }
}

/// Segments at an answer, and Levenberg-Marquardt on them.
pub(super) fn polished(window: &Window<'_>, from: Answer, loss: Loss) -> Answer {
    let Answer { theta, mut spent } = from;
    let segments = window.segments(&theta);
    let cost = segment_cost(&segments, window.prior, loss);
    let delta = levenberg_marquardt(&cost, Theta::zeros(), 30, &mut spent);
    Answer { theta: theta + delta, spent }
}

pub(super) fn lm_huber(window: &Window<'_>) -> Answer {
    polished(window, ls_huber(window), Loss::Huber(HUBER))
}

pub(super) fn ls_graduated(window: &Window<'_>, schedule: Schedule, coupled: bool) -> Answer {
    let mut spent = Spent::default();
    let theta = graduated(&window.weak_form(coupled), schedule, &mut spent);
    Answer { theta, spent }
}
