use super::{
    super::{
        chi_square::CLIPPED,
        field_filter::{IN_BODY, IN_EARTH},
        field_node::FieldNode,
        field_noise::CORRELATED,
        hypothesis::follow,
    },
    HardIronWatch, LEAST_SIZE,
};

impl HardIronWatch {
    /// Compares the hypotheses by a node while the change is undecided.
    pub(super) fn compare(&mut self, t_us: u64, node: &FieldNode) {
        let error_ut = self.error_ut();
        let (noise, quiet_noise) =
            (self.noise.variance_ut2(error_ut, CORRELATED), self.noise.variance_ut2(error_ut, 1.0));
        let iron = follow(&mut self.iron, node, noise, Some(IN_BODY));
        let earth = follow(&mut self.earth, node, noise, Some(IN_EARTH));
        let unchanged = self.tracked.innovation(node);
        let lost_ut2 = 9.0 * error_ut * error_ut;
        let quiet = unchanged.squared(quiet_noise).is_some_and(|(squared, _)| squared < CLIPPED)
            && unchanged.predicted.trace() < 3.0 * lost_ut2;
        let better = if iron.squared < earth.squared { &iron } else { &earth };
        let (squared, predicted) = (better.squared, better.predicted);
        self.noise.learn(squared, noise, &predicted, node.time_s);

        let jump = self.iron.in_body() - self.tracked.in_body();
        let least_ut = LEAST_SIZE * error_ut;
        let matters = jump.norm_squared() > least_ut * least_ut;
        if let Some(verdict) = self.suspicion.weigh((t_us, node), [&iron, &earth], quiet, matters) {
            self.conclude(verdict);
        }
    }
}
