use super::{Prior, WindowCost, innovation_fit::InnovationFit, observability::Observability, search::Search};
use crate::{
    algebra::{Cholesky, Packed},
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
    /// What the window sees, at the optimum; there once it has been looked at.
    pub observability: Option<Observability>,
}

impl Refinement {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { innovations: InnovationFit::zero(), whitening: None, search: Search::None, observability: None }
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

    /// One step of the search.
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
        self.observability = Observability::new(&data_sheet.information, &self.information(prior));
    }

    /// Information at the optimum.
    pub fn information(&self, prior: &Prior) -> Packed<12, 78> {
        let (delta, _) = self.optimum(prior);
        let mut information = Packed::zero();
        self.objective(prior).normal_equations(&delta, &mut information, &mut [0.0; 12]);
        information
    }

    /// The optimum found, about theta0, and the evaluations spent.
    pub fn optimum(&self, prior: &Prior) -> ([f32; 12], u32) {
        (self.cost(prior).map_or([0.0; 12], |cost| self.search.best(&cost)), self.search.evaluations())
    }
}
