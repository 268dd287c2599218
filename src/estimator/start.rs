//! Start of the filter: from the factory's prior, or about a stored model.

use super::{
    Estimator, Settings, Task,
    averaging::Averaging,
    parameters::Parameters,
    prior::Prior,
    real::{Real, V3},
    share::Shares,
};
use crate::compensation::{ActiveEffects, Effect, GyroModel, Theta};

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Sets the configuration and starts afresh.
    pub fn configure(&mut self, settings: &Settings, library: &'static [&'static dyn Effect]) {
        self.candidates.configure(library);
        self.settings = *settings;
        (self.has_sample, self.waited_s) = (false, 0.0);
        self.waiting.clear();
        self.compose_with(&settings.factory);
        self.builder.start(settings.sample_period_s, settings.is_instant);
        self.remainder.start();
        self.was_unexplained = false;
        self.shares = Shares::zero();
        self.rests.start();
        let [x, y, z] = self.settings.factory.b_rad_s.map(T::of);
        self.bias = V3::new(x, y, z);
        self.begin();
        self.posterior.clear();
        self.known_attitude.clear();
    }

    /// Starts from the factory's prior.
    pub(super) fn begin(&mut self) {
        self.prior = Prior::of(&self.settings);
        self.task = Task::Next;
        self.course.begin();
        self.candidates.begin();
        self.evidence.clear();
        self.globals.start();
        self.node.referred = 0;
        self.updates = self.updates.wrapping_add(1);
        self.rests.interrupt();
        self.start_node();
        self.left_over.start();
        self.averaging = Averaging::zero();
        self.centre.clear();
        self.linearise();
    }

    /// Computes the parameters at the present globals.
    pub(super) fn linearise(&mut self) {
        let mut x = self.globals.x;
        for (x, sigma) in x.iter_mut().zip(&self.prior.sigma) {
            *x *= *sigma;
        }
        self.parameters = Parameters::new(&x, &self.bias, &self.prior.p);
    }

    /// Starts about a stored model with its deviations: P's prior is about the model's P, as wide as that was known and may
    /// have drifted. The bias is another one at every start, and is as unknown as without the
    /// model. The effects that were taken out still are. If the samples contradict the model, it is forgotten.
    pub fn restore(&mut self, model: &GyroModel, deviations: &Theta, effects: &ActiveEffects) {
        self.prior.restore(model, deviations);
        self.candidates.restore(effects);
        self.linearise();
    }
}
