use super::{
    Prior, WindowCost, innovation_fit::InnovationFit, observability::Observability, search::Search, weak_fit::WeakFit,
};
use crate::{
    algebra::{Cholesky, Packed, dot, minus, plus},
    config::Config,
    objective::Innovations,
    optimizer::{LeastSquaresCost, Progress},
};

/// What follows the least-squares solution: the innovations there, and the search over them.
pub(super) struct Refinement {
    pub innovations: InnovationFit,
    /// Of the cost about the least-squares solution; there once the innovations are whitened.
    whitening: Option<Cholesky<12, 78>>,
    search: Search,
    /// Of the optimum, once it is found: what the window sees there, the factor of its information, and by how much the window contradicts
    /// the ones before.
    pub observability: Option<Observability>,
    pub posterior: Option<Cholesky<12, 78>>,
    pub contradiction: f32,
}

impl Refinement {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            innovations: InnovationFit::zero(),
            whitening: None,
            search: Search::None,
            observability: None,
            posterior: None,
            contradiction: 0.0,
        }
    }

    /// Noise scales and whitening, and the search that the configuration names; `None` when there is nothing to search over.
    pub fn whiten(&mut self, prior: &Prior, config: &Config, t_end_us: u64) -> Option<()> {
        self.innovations.rescale()?;
        let mut normal = Packed::zero();
        self.objective(prior).normal_equations(&[0.0; 12], &mut normal, &mut [0.0; 12]);
        self.whitening = Some(normal.cholesky()?);
        let id = &config.identification;
        self.search = Search::new(id.optimizer, id.max_evaluations, config.seed ^ t_end_us);
        Some(())
    }

    /// One step of the search. A function of its own, so that what it takes can be counted.
    #[inline(never)]
    pub fn step(&mut self, prior: &Prior) -> Progress {
        let Some(factor) = &self.whitening else { return Progress::Done };
        self.search.step(&WindowCost { objective: self.innovations.objective(prior), factor })
    }

    pub fn objective<'a>(&'a self, prior: &'a Prior) -> Innovations<'a> {
        self.innovations.objective(prior)
    }

    /// What the search minimises, once the innovations are whitened.
    pub fn cost<'a>(&'a self, prior: &'a Prior) -> Option<WindowCost<'a>> {
        let factor = self.whitening.as_ref()?;
        Some(WindowCost { objective: self.objective(prior), factor })
    }

    /// Looks at what the window sees at the optimum, against the data sheet's prior: a rest counts as an observation of the bias.
    pub fn observe(&mut self, prior: &Prior, config: &Config) {
        let data_sheet = Prior::new(&config.identification, &config.gyro, None);
        let (information, _) = self.equations(prior);
        self.posterior = information.cholesky();
        self.observability = Observability::new(&data_sheet.information, &information);
    }

    /// Normal equations at the optimum.
    fn equations(&self, prior: &Prior) -> (Packed<12, 78>, [f32; 12]) {
        let (delta, _) = self.optimum(prior);
        let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
        self.objective(prior).normal_equations(&delta, &mut normal, &mut descent);
        (normal, descent)
    }

    /// Finds the squared distance between what the window says by itself and what was carried into it, in their deviations: chi-square
    /// with 12 degrees of freedom when nothing has changed.
    ///
    /// At the optimum the carried information pulls with u = L (m - x), L its matrix and m its mean, and all else holds against it.
    /// Without it the optimum would lie W^-1 u farther from m, W being the information of all else, so the two are
    /// (W^-1 + L^-1) u apart and the distance is u' (W^-1 + L^-1) u.
    pub fn compare(&mut self, weak: &WeakFit) {
        let carried = weak.carried();
        let (delta, _) = self.optimum(&weak.prior);
        let theta = plus(&self.innovations.theta0, &delta);
        let (mut normal, _) = self.equations(&weak.prior);
        normal.add_scaled(&carried.information, -1.0);
        let pull = carried.information.times(&minus(&carried.mean, &theta));
        let of_window = normal.cholesky().map_or(0.0, |alone| dot(&alone.solve(&pull), &pull));
        self.contradiction = of_window + carried.distance(&theta);
    }

    /// The optimum found, about theta0, and the evaluations spent.
    pub fn optimum(&self, prior: &Prior) -> ([f32; 12], u32) {
        (self.cost(prior).map_or([0.0; 12], |cost| self.search.best(&cost)), self.search.evaluations())
    }
}
