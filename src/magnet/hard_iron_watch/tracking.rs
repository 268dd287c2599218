use super::{
    super::{
        chi_square::{CLIPPED, IN_A_HUNDRED, IN_A_MILLION, IN_A_THOUSAND},
        field_filter::{IN_BODY, IN_EARTH},
        field_node::FieldNode,
        field_noise::CORRELATED,
        hypothesis::{JUMP_UT, follow},
    },
    HardIronWatch, LEAST_SIZE, STEADY_NODES, State, Suspicion, TOLD_RAD,
};

/// Consecutive nodes beyond one in a hundred that are as unlikely as one beyond one in a million.
const UNLIKELY_NODES: u8 = 3;

impl HardIronWatch {
    /// Tests a node against the single filter's prediction.
    pub(super) fn track(&mut self, t_us: u64, node: &FieldNode) {
        let error_ut = self.error_ut();
        let noise = self.noise.variance_ut2(error_ut, 1.0);
        let innovation = self.tracked.innovation(node);
        let Some((squared, _)) = innovation.squared(noise) else { return };
        let size2 = innovation.innovation_ut.norm_squared();
        self.unlikely = if squared > IN_A_HUNDRED { self.unlikely.saturating_add(1) } else { 0 };
        let changed = squared > IN_A_MILLION || self.unlikely >= UNLIKELY_NODES;
        if changed && size2 > LEAST_SIZE * LEAST_SIZE * error_ut * error_ut {
            let unknown = self.turned_rad < TOLD_RAD;
            let turned_ut = JUMP_UT * self.noise.recent_rad();
            if unknown && turned_ut * turned_ut > size2 {
                // The offset may have been there all the time, unseen before the first turn.
                self.tracked.open(IN_BODY, JUMP_UT);
                self.tracked.open(IN_EARTH, JUMP_UT);
                return;
            }
            self.kept.suspect();
            self.state = State::Undecided;
            self.unlikely = 0;
            self.suspicion = Suspicion::new(t_us, self.calm >= STEADY_NODES);
            self.calm = 0;
            (self.iron, self.earth) = (self.tracked, self.tracked);
            self.iron.open(IN_BODY, JUMP_UT);
            self.earth.open(IN_EARTH, JUMP_UT);
            self.compare(t_us, node);
            return;
        }
        self.calm = if squared > IN_A_THOUSAND {
            0
        } else if self.calm < STEADY_NODES {
            self.calm + 1
        } else {
            STEADY_NODES
        };
        self.noise.learn(squared, noise, &innovation.predicted, node.time_s);
        let noise = self.noise.variance_ut2(error_ut, CORRELATED);
        follow(&mut self.tracked, node, noise, None);
        if self.kept.on && squared < CLIPPED {
            self.refine(t_us);
        }
    }

    /// Refines the offset of the lasting interval; ends an interval whose offset faded too slowly for any
    /// node to show.
    fn refine(&mut self, t_us: u64) {
        let offset = self.tracked.in_body() - self.base_ut;
        let least_ut = 0.5 * LEAST_SIZE * self.error_ut();
        if offset.norm_squared() < least_ut * least_ut {
            self.kept.close(t_us);
        }
        if self.frozen || !self.kept.on {
            return;
        }
        let variance = self.tracked.in_body_covariance().diagonal() + self.base_variance_ut2;
        if let Some(last) = self.kept.last_mut() {
            last.offset_ut = offset.into();
            last.sigma_ut = variance.map(libm::sqrtf).into();
        }
    }
}
