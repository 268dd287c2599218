use super::{
    Prior,
    drift::{Drift, drift},
    job::{Context, Job},
    motion::Motion,
    prior::linear,
    weak_fit::WeakFit,
};
use crate::{
    algebra::{Packed, plus},
    objective::{InnovationFilter, Innovations, Noise, STRETCHES, Stretch, add_equations, rescale},
    window::{BodyMeans, Node, NodeWalk, VectorEffects, gyro_part},
};
use nalgebra::Vector3;

/// Length of a stretch of innovations, a tenth of the longest window, seconds.
const STRETCH_S: f32 = 5.0;

/// The innovations of one window, gathered once at its least-squares solution: what the search minimises.
pub(crate) struct InnovationFit {
    /// The least-squares solution.
    pub theta0: [f32; 12],
    walk: NodeWalk,
    filters: [InnovationFilter; 2],
    /// Gravity's and the field's.
    stretches: [[Stretch; STRETCHES]; 2],
    noise: Noise,
    pub motion: Motion,
    last_body: Option<BodyMeans>,
}

impl InnovationFit {
    pub const fn zero() -> Self {
        Self {
            theta0: [0.0; 12],
            walk: NodeWalk::zero(),
            filters: [InnovationFilter::start(); 2],
            stretches: [[Stretch::zero(); STRETCHES]; 2],
            noise: Noise { vectors: [0.0; 2], walk: 0.0 },
            motion: Motion::none(),
            last_body: None,
        }
    }

    /// Makes node `index` and takes its innovations; false when the window holds no such node, `None` when its samples have been
    /// overwritten.
    pub fn take_node(&mut self, context: &Context, job: &Job, weak: &WeakFit, index: usize) -> Option<bool> {
        let stream = context.stream;
        let grid = stream.grid;
        if index == 0 {
            self.start(context, weak);
        }
        let length = Node::length(grid) as u32;
        let from = job.from + index as u32 * length;
        if from + length > job.to {
            return Some(false);
        }
        if !stream.increments.holds(from) {
            return None;
        }
        let (p, c) = linear(&self.theta0);
        let [.., lag, x, y, z] = weak.solution;
        let effects = VectorEffects { mag_lag_s: lag, hard_iron_ut: Vector3::new(x, y, z) };
        let mut node = self.walk.node((|index| stream.increment(index), grid, from), (&p, &c), &effects);
        let stretch = (index * length as usize).checked_div(grid.increments_in(STRETCH_S)).unwrap_or(0);
        let [gravity_filter, field_filter] = &mut self.filters;
        let middle = (from - job.from + length / 2) as usize;
        if weak.distrusts(middle, stream.test_function.hop()) {
            node.vectors = [None; 2];
            field_filter.distrust();
        }
        let [gravity, field] = &mut self.stretches;
        if let (Some(gravity), Some(field)) = (gravity.get_mut(stretch), field.get_mut(stretch)) {
            // Gravity is too noisy to show when the gyro lost the way; the field shows it.
            if field_filter.take(&node, 1, &self.noise, field) {
                *gravity_filter = InnovationFilter::start();
            }
            gravity_filter.take(&node, 0, &self.noise, gravity);
        }
        if let (Some(before), Some(now)) = (&self.last_body, &node.body) {
            let node_s = length as f32 * grid.interval_s();
            self.motion.compare(before, now, node_s, [&(p, c), &linear(&weak.theta)]);
        }
        self.motion.second(&node, index, context.config.identification.max_bias_rad_s);
        self.last_body = node.body;
        Some(true)
    }

    fn start(&mut self, context: &Context, weak: &WeakFit) {
        let change = gyro_part(&weak.solution);
        self.theta0 = plus(&weak.theta, &change);
        self.walk = NodeWalk::start();
        self.filters = [InnovationFilter::start(); 2];
        self.stretches = [[Stretch::zero(); STRETCHES]; 2];
        self.motion = Motion::none();
        self.last_body = None;
        let grid = context.stream.grid;
        let length = Node::length(grid) as f32;
        // An equation's variance is its noise gain times that of an increment's vector; a node is the mean of some increments.
        let of_node = |variance: f32| variance / (context.stream.test_function.noise_gain(weak.quarters) * length);
        let walk = context.config.attitude.gyro_noise_rad_s_rthz;
        self.noise = Noise {
            vectors: [of_node(weak.variances.gravity), of_node(weak.variances.field)],
            walk: walk * walk * length * grid.interval_s(),
        };
    }

    /// Brings the noise to what the innovations show; `None` when there are none.
    pub fn rescale(&mut self) -> Option<()> {
        for stretches in &mut self.stretches {
            rescale(stretches);
        }
        self.stretches.as_flattened().iter().any(|stretch| stretch.count > 0.0).then_some(())
    }

    pub fn objective<'a>(&'a self, prior: &'a Prior) -> Innovations<'a> {
        Innovations { stretches: self.stretches.as_flattened(), prior, theta0: &self.theta0 }
    }

    /// How far c has walked by the window's end.
    /// `delta`: where the optimum is.
    pub fn drift(&self, context: &Context, job: &Job, delta: &[f32; 12]) -> Option<Drift> {
        let [gravity, field] = &self.stretches;
        // Stretches beyond the window's end are empty.
        let length_s = (job.t_end_us - job.t_start_us) as f32 * 1e-6;
        let count = (libm::ceilf(length_s / STRETCH_S) as usize).min(STRETCHES);
        let (gravity, field) = (gravity.get(..count)?, field.get(..count)?);
        let walk = context.forgetting().bias_walk_rad_s_rts;
        let start = context.config.identification.prior_sigma_bias_rad_s;
        drift([gravity, field], delta, start * start, walk * walk * STRETCH_S)
    }

    /// What the stretches within the first `learned_us` of the window say: their normal equations at `delta`. They know of none that
    /// comes after.
    pub fn lesson(&self, learned_us: u64, delta: &[f32; 12]) -> (Packed<12, 78>, [f32; 12]) {
        let stretch_us = (STRETCH_S * 1e6) as u64;
        let count = learned_us.checked_div(stretch_us).unwrap_or(0) as usize;
        let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
        for stretches in &self.stretches {
            add_equations(stretches.iter().take(count), delta, &mut normal, &mut descent);
        }
        (normal, descent)
    }
}
