//! Means of the truth over one sample interval, which sensors measure.

use nalgebra::Vector3;

use super::{
    drilling::{Drilling, Motion},
    sensors::Ideal,
};

/// Means over one sample interval, and the tool at its middle and end.
pub(super) struct Interval {
    pub(super) ideal: Ideal,
    /// Mean rate relative to the earth, rad/s.
    pub(super) rate_rad_s: Vector3<f64>,
    pub(super) middle: Motion,
    pub(super) end: Motion,
}

impl Interval {
    /// Trapezoid means over the interval centred on `t_s` that begins at `start`.
    pub(super) fn mean(
        drilling: &mut Drilling<'_>,
        start: Motion,
        t_s: f64,
        period_s: f64,
        steps: u32,
        ideal: impl Fn(&Motion) -> Ideal,
    ) -> Self {
        let zero = Vector3::zeros();
        let sum = Ideal { rate_rad_s: zero, specific_force_m_s2: zero, gravity_m_s2: zero, field_ut: zero };
        let mut interval = Self { ideal: sum, rate_rad_s: zero, middle: start, end: start };
        interval.add(&start, &ideal(&start), 0.5 / f64::from(steps));
        for step in 1..=steps {
            let motion = drilling.advance(t_s + period_s * (f64::from(step) / f64::from(steps) - 0.5));
            let weight = if step == steps { 0.5 } else { 1.0 };
            interval.add(&motion, &ideal(&motion), weight / f64::from(steps));
            if 2 * step == steps {
                interval.middle = motion;
            }
            interval.end = motion;
        }
        interval
    }

    fn add(&mut self, motion: &Motion, ideal: &Ideal, weight: f64) {
        self.ideal.rate_rad_s += ideal.rate_rad_s * weight;
        self.ideal.specific_force_m_s2 += ideal.specific_force_m_s2 * weight;
        self.ideal.gravity_m_s2 += ideal.gravity_m_s2 * weight;
        self.ideal.field_ut += ideal.field_ut * weight;
        self.rate_rad_s += motion.rate_rad_s * weight;
    }
}
