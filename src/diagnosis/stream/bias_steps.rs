use nalgebra::Vector3;

/// Steps that are known at a time: a diagnosis finds one at most, and less than two of them fit in what is kept.
const MOST: usize = 2;

/// The gyro's bias became another.
#[derive(Clone, Copy)]
struct BiasStep {
    /// First increment after it; 0: there is none.
    until: u32,
    /// What a raw reading before it lacks to be as after it, rad/s.
    step_rad_s: Vector3<f32>,
}

/// The latest steps of the gyro's bias that increments that are kept may lie before, the newest first.
pub(super) struct BiasSteps([BiasStep; MOST]);

impl BiasSteps {
    pub const NONE: Self = Self([BiasStep { until: 0, step_rad_s: Vector3::new(0.0, 0.0, 0.0) }; MOST]);

    pub const fn add(&mut self, until: u32, step_rad_s: Vector3<f32>) {
        let [last, _] = self.0;
        self.0 = [BiasStep { until, step_rad_s }, last];
    }

    /// A raw rate of an increment, rad/s, as it would be with the bias after all of them.
    pub fn taken_out(&self, index: u32, rate_rad_s: Vector3<f32>) -> Vector3<f32> {
        let before = self.0.iter().filter(|step| index < step.until);
        before.fold(rate_rad_s, |rate, step| rate + step.step_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_is_in_what_comes_before_it_once() {
        let mut steps = BiasSteps::NONE;
        steps.add(100, Vector3::x());
        steps.add(300, Vector3::y());
        for (index, expected) in [(0, [1.0, 1.0, 0.0]), (99, [1.0, 1.0, 0.0]), (100, [0.0, 1.0, 0.0]), (300, [0.0; 3])]
        {
            assert_eq!(steps.taken_out(index, Vector3::zeros()), Vector3::from(expected), "{index}");
        }
    }
}
