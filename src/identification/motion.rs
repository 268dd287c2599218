use crate::{
    algebra::{Cholesky, Packed, dot},
    objective::rotation_disagreement,
    window::{BodyMeans, Node},
};
use nalgebra::{Matrix3, Vector3};

/// Nodes from one comparison of sensitivities to the next: a second.
const NODES_PER_SECOND: usize = 5;

/// |ln| of the ratio of eq 6 from which gyro and accelerometer disagree on how far the body turned: twice or half as far.
const DISAGREEMENT: f32 = core::f32::consts::LN_2;

/// What a window's motion makes of a change of theta, and whether the accelerometer agrees that it took place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Sum over the moving seconds of D' D, D (3 x 12) being what theta's change does to the rotation over the second.
    sum: Packed<12, 78>,
    seconds: f32,
    /// The sensitivity a second ago; `None` where the walk was broken since, and at the beginning.
    earlier: Option<[[f32; 12]; 3]>,
    square_rate: f32,
    /// Pairs of nodes that eq 6 could compare, and in how many the fit and the flown model disagreed with the accelerometer.
    compared: u32,
    disagreed: [u32; 2],
}

impl Motion {
    pub const fn none() -> Self {
        Self { sum: Packed::zero(), seconds: 0.0, earlier: None, square_rate: 0.0, compared: 0, disagreed: [0; 2] }
    }

    /// Takes the node with this number.
    pub fn second(&mut self, node: &Node, number: usize, moving_rate_rad_s: f32) {
        self.square_rate += node.square_rate;
        if node.broken {
            self.earlier = None;
        }
        if !number.is_multiple_of(NODES_PER_SECOND) {
            return;
        }
        let moving = self.square_rate > moving_rate_rad_s * moving_rate_rad_s * NODES_PER_SECOND as f32;
        if let Some(earlier) = self.earlier.filter(|_| moving) {
            let mut change = node.sensitivity;
            for (c, b) in change.as_flattened_mut().iter_mut().zip(earlier.as_flattened()) {
                *c -= b;
            }
            self.sum.add_outers(&change, 1.0);
            self.seconds += 1.0;
        }
        self.earlier = Some(node.sensitivity);
        self.square_rate = 0.0;
    }

    /// Compares by eq 6 how far the body turned from one node to the next, by the fit and by the flown model (P, c).
    pub fn compare(
        &mut self,
        before: &BodyMeans,
        now: &BodyMeans,
        node_s: f32,
        models: [&(Matrix3<f32>, Vector3<f32>); 2],
    ) {
        let raw = (before.raw_rad_s + now.raw_rad_s) * 0.5;
        let sigma_rad = libm::sqrtf(before.sigma_rad * before.sigma_rad + now.sigma_rad * now.sigma_rad);
        let ends = (&before.gravity_m_s2, &now.gravity_m_s2);
        let found = models.map(|(p, c)| rotation_disagreement(&(p * raw - c), ends, node_s, sigma_rad));
        if let [Some(fit), Some(flown)] = found {
            self.compared += 1;
            for (count, found) in self.disagreed.iter_mut().zip([fit, flown]) {
                *count += u32::from(found > DISAGREEMENT);
            }
        }
    }

    /// By how many more of the comparisons the fit disagrees with the accelerometer than the flown model does, in standard
    /// deviations of a difference of chance.
    pub fn disagreement(&self) -> f32 {
        let [fit, flown] = self.disagreed.map(|count| count as f32);
        let deviation = libm::sqrtf(if fit + flown > 1.0 { fit + flown } else { 1.0 });
        (fit - flown) / deviation
    }

    /// Root mean square over the moving seconds of the rotation that a change of theta makes, rad. `None` when nothing moved.
    #[inline(never)]
    pub fn turned_by(&self, change: &[f32; 12]) -> Option<f32> {
        (self.seconds > 0.0).then(|| libm::sqrtf(self.sum.quadratic(change) / self.seconds))
    }

    /// The same of a random change with a covariance, rad.
    pub fn deviation(&self, covariance: &Packed<12, 78>) -> f32 {
        libm::sqrtf(self.sum.inner(covariance) / self.seconds)
    }

    /// The same of a change whose information has a factor, rad: the trace of the sum times the inverse, column by column.
    pub fn deviation_of(&self, information: &Cholesky<12, 78>) -> f32 {
        let mut trace = 0.0;
        for i in 0..12 {
            let mut unit = [0.0; 12];
            if let Some(one) = unit.get_mut(i) {
                *one = 1.0;
            }
            trace += dot(&self.sum.times(&unit), &information.solve(&unit));
        }
        libm::sqrtf(trace / self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVING_RAD_S: f32 = 0.1;

    /// A node of a body whose sensitivity has grown for `seconds` by `rate` per second.
    fn node(seconds: f32, rate: &[[f32; 12]; 3]) -> Node {
        Node {
            vectors: [None; 2],
            sensitivity: rate.map(|row| row.map(|growth| growth * seconds)),
            square_rate: 1.0,
            body: None,
            broken: false,
        }
    }

    const RATE: [[f32; 12]; 3] = [
        [0.3, -0.1, 0.4, 0.0, 0.2, 0.1, -0.3, 0.5, 0.0, -1.0, 0.1, 0.0],
        [0.0, 0.6, -0.2, 0.1, 0.0, 0.3, 0.2, -0.1, 0.4, 0.0, -1.0, 0.2],
        [0.5, 0.0, 0.1, -0.4, 0.3, 0.0, 0.1, 0.2, -0.6, 0.3, 0.0, -1.0],
    ];
    const CHANGE: [f32; 12] = [0.01, -0.02, 0.03, 0.0, 0.01, 0.02, -0.01, 0.0, 0.02, 0.003, -0.002, 0.001];

    fn through(nodes: impl Iterator<Item = Node>) -> Motion {
        let mut motion = Motion::none();
        for (number, node) in nodes.enumerate() {
            motion.second(&node, number, MOVING_RAD_S);
        }
        motion
    }

    /// The rotation that `CHANGE` makes in a second.
    fn expected() -> f32 {
        libm::sqrtf(RATE.iter().map(|row| dot(row, &CHANGE)).map(|turn| turn * turn).sum())
    }

    #[test]
    fn a_sensitivity_that_grows_steadily_turns_each_second_alike() {
        let motion = through((0..51).map(|number| node(0.2 * number as f32, &RATE)));
        let turned = motion.turned_by(&CHANGE).unwrap();
        assert!((turned / expected() - 1.0).abs() < 1e-4, "{turned} {}", expected());
        // A random change of one direction's variance is that change.
        let mut covariance = Packed::zero();
        covariance.add_outer(&CHANGE, 1.0);
        assert!((motion.deviation(&covariance) / turned - 1.0).abs() < 1e-4);
        // An information of 4 about everything is a covariance of a quarter.
        let (mut information, mut quarter) = (Packed::zero(), Packed::zero());
        for i in 0..12 {
            information.add(i, i, 4.0);
            quarter.add(i, i, 0.25);
        }
        let factor = information.cholesky().unwrap();
        assert!((motion.deviation_of(&factor) / motion.deviation(&quarter) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn seconds_at_rest_and_across_a_break_do_not_count() {
        assert_eq!(Motion::none().turned_by(&CHANGE), None);
        let still = |number: usize| Node { square_rate: 0.0, ..node(0.2 * number as f32, &RATE) };
        assert_eq!(through((0..51).map(still)).turned_by(&CHANGE), None);
        assert_eq!(through((0..5).map(|number| node(0.2 * number as f32, &RATE))).turned_by(&CHANGE), None);
        // Half of it at rest, with another sensitivity, changes nothing of the mean over the moving seconds.
        let other = RATE.map(|row| row.map(|x| 9.0 * x));
        let rest = |number: usize| Node { square_rate: 0.0, ..node(0.2 * number as f32, &other) };
        let moving = |number: usize| node(9.0 * 5.0 + 0.2 * (number as f32 - 25.0), &RATE);
        let motion = through((0..51).map(|number| if number <= 25 { rest(number) } else { moving(number) }));
        assert!((motion.turned_by(&CHANGE).unwrap() / expected() - 1.0).abs() < 1e-3);
        // A jump of the sensitivity where the walk is broken is nobody's turn.
        let torn = |number: usize| {
            let seconds = 0.2 * number as f32 + if number >= 23 { 100.0 } else { 0.0 };
            Node { broken: number == 23, ..node(seconds, &RATE) }
        };
        let motion = through((0..51).map(torn));
        assert!((motion.turned_by(&CHANGE).unwrap() / expected() - 1.0).abs() < 1e-3);
        assert_eq!(motion.seconds, 9.0);
    }

    /// Means of two nodes between which the body turned by `rate` across gravity.
    fn turned(rate: f32, sigma_rad: f32) -> [BodyMeans; 2] {
        let at = |angle: f32| BodyMeans {
            raw_rad_s: Vector3::new(0.0, 0.0, rate),
            gravity_m_s2: Vector3::new(libm::cosf(angle), -libm::sinf(angle), 0.0) * 9.81,
            sigma_rad,
        };
        [at(0.0), at(0.2 * rate)]
    }

    fn scaled(scale: f32) -> (Matrix3<f32>, Vector3<f32>) {
        (Matrix3::identity() * scale, Vector3::zeros())
    }

    #[test]
    fn only_the_model_that_turns_twice_or_half_as_far_disagrees() {
        let [before, now] = turned(1.5, 0.01);
        let (right, wrong) = (scaled(1.0), [scaled(2.5), scaled(0.4)]);
        for wrong in &wrong {
            let (mut bad_fit, mut good_fit) = (Motion::none(), Motion::none());
            for _ in 0..25 {
                bad_fit.compare(&before, &now, 0.2, [wrong, &right]);
                good_fit.compare(&before, &now, 0.2, [&right, wrong]);
            }
            assert_eq!((bad_fit.compared, bad_fit.disagreed), (25, [25, 0]));
            assert_eq!((good_fit.compared, good_fit.disagreed), (25, [0, 25]));
            // 25 in deviations of a difference of chance, the root of 25.
            assert!((bad_fit.disagreement() - 5.0).abs() < 1e-6 && (good_fit.disagreement() + 5.0).abs() < 1e-6);
        }
        let mut both = Motion::none();
        both.compare(&before, &now, 0.2, [&wrong[0], &wrong[1]]);
        both.compare(&before, &now, 0.2, [&scaled(1.3), &scaled(0.8)]);
        assert_eq!((both.compared, both.disagreed, both.disagreement()), (2, [1, 1], 0.0));
    }

    #[test]
    fn an_angle_within_its_noise_compares_nothing() {
        let [before, now] = turned(1.5, 0.1);
        let mut motion = Motion::none();
        motion.compare(&before, &now, 0.2, [&scaled(9.0), &scaled(1.0)]);
        let [before, _] = turned(1.5, 0.0);
        motion.compare(&before, &before, 0.2, [&scaled(9.0), &scaled(1.0)]);
        let nowhere = BodyMeans { gravity_m_s2: Vector3::repeat(f32::NAN), ..before };
        motion.compare(&before, &nowhere, 0.2, [&scaled(9.0), &scaled(1.0)]);
        assert_eq!((motion.compared, motion.disagreement()), (0, 0.0));
    }
}
