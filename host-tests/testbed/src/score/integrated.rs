use nalgebra::{UnitQuaternion, Vector3};

/// Rotation integrated from a rate track, between any two times that it covers without a gap.
///
/// Between readings the rate is taken to change linearly. The rotation vector of a step is its mean rate
/// times its length and the coning term of a linear rate, so what is left is the chord: a rate that swings at
/// w rad/s keeps 1 - (w dt)^2 / 12 of itself. At 1 Hz and 100 Hz sampling that is 3 parts in 10,000.
pub(super) struct Integrated {
    /// Readings that are kept, in their order.
    kept: Vec<Reading>,
    is_empty: bool,
}

/// A reading with what was integrated until then.
#[derive(Clone, Copy)]
struct Reading {
    t_s: f64,
    rate: Vector3<f64>,
    /// Rotation from the body here to the body at the first reading of its run.
    rotation: UnitQuaternion<f64>,
    /// Number of the gap-free run that it belongs to.
    run: u32,
}

/// Intervals of time at which rotations will be asked for, in their order and apart from each other: only readings
/// about these are kept.
pub(super) struct Asked(Vec<[f64; 2]>);

impl Asked {
    /// Makes one of intervals in any order.
    pub(super) fn of(mut intervals: Vec<[f64; 2]>) -> Self {
        intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut apart: Vec<[f64; 2]> = Vec::with_capacity(intervals.len());
        for [from_s, to_s] in intervals.into_iter().map(|[from_s, to_s]| [from_s - ROUNDING_S, to_s + ROUNDING_S]) {
            match apart.last_mut() {
                Some(last) if last[1] >= from_s => last[1] = last[1].max(to_s),
                _ => apart.push([from_s, to_s]),
            }
        }
        Self(apart)
    }
}

/// Times come from whole microseconds: a tenth of one is rounding. Twice that, so that no reading is lost to it.
const ROUNDING_S: f64 = 2e-7;

/// Integrates readings as they come.
pub(super) struct Integrator<'a> {
    gap_s: f64,
    /// Intervals that have not passed.
    asked: &'a [[f64; 2]],
    kept: Vec<Reading>,
    /// The reading before the last, and the last, of which it is not known yet whether it is kept.
    before_s: f64,
    last: Option<Reading>,
}

impl<'a> Integrator<'a> {
    /// Begins; steps longer than `gap_s` begin a new run.
    pub(super) fn new(gap_s: f64, asked: &'a Asked) -> Self {
        Self { gap_s, asked: &asked.0, kept: Vec::new(), before_s: f64::NEG_INFINITY, last: None }
    }

    /// Takes a reading in; one that is not later than that before is left out.
    pub(super) fn push(&mut self, t_s: f64, rate: Vector3<f64>) {
        let (rotation, run) = match self.last {
            None => (UnitQuaternion::identity(), 0),
            Some(last) if t_s <= last.t_s => return,
            Some(last) if t_s - last.t_s > self.gap_s => (last.rotation, last.run + 1),
            Some(last) => (last.rotation * step(&last.rate, &rate, t_s - last.t_s), last.run),
        };
        self.keep_last(t_s);
        self.last = Some(Reading { t_s, rate, rotation, run });
    }

    /// Keeps the last reading if an interval lies between its neighbours.
    fn keep_last(&mut self, next_s: f64) {
        let Some(last) = self.last else { return };
        while let Some((_, rest)) = self.asked.split_first().filter(|([_, to_s], _)| *to_s < self.before_s) {
            self.asked = rest;
        }
        if self.asked.first().is_some_and(|[from_s, _]| *from_s <= next_s) {
            self.kept.push(last);
        }
        self.before_s = last.t_s;
    }

    /// All that was kept.
    pub(super) fn ended(mut self) -> Integrated {
        self.keep_last(f64::INFINITY);
        self.kept.shrink_to_fit();
        Integrated { kept: self.kept, is_empty: self.last.is_none() }
    }
}

impl Integrated {
    /// Rotation from the body at `to_s` to the body at `from_s`; `None` if the track does not reach or a gap
    /// lies between.
    pub(super) fn rotation(&self, from_s: f64, to_s: f64) -> Option<UnitQuaternion<f64>> {
        let (from, from_run) = self.at(from_s)?;
        let (to, to_run) = self.at(to_s)?;
        (from_run == to_run).then(|| from.inverse() * to)
    }

    /// Returns true if there is no reading at all.
    pub(super) const fn is_empty(&self) -> bool {
        self.is_empty
    }

    fn at(&self, t_s: f64) -> Option<(UnitQuaternion<f64>, u32)> {
        // A tenth of a microsecond is rounding.
        let after = self.kept.partition_point(|reading| reading.t_s <= t_s + 1e-7);
        let Reading { t_s: at_s, rate, rotation, run } = *self.kept.get(after.checked_sub(1)?)?;
        let elapsed_s = t_s - at_s;
        if elapsed_s <= 1e-7 {
            return Some((rotation, run));
        }
        let next = self.kept.get(after)?;
        let rate_there = rate + (next.rate - rate) * (elapsed_s / (next.t_s - at_s));
        (next.run == run).then(|| (rotation * step(&rate, &rate_there, elapsed_s), run))
    }
}

/// Rotation over `dt_s` under a rate that changes linearly from `start` to `end`, rad/s.
fn step(start: &Vector3<f64>, end: &Vector3<f64>, dt_s: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis((start + end) * (0.5 * dt_s) + start.cross(end) * (dt_s * dt_s / 12.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Integrates a track of which everything is asked.
    fn integrated(t_s: &[f64], rates: &[Vector3<f64>], gap_s: f64) -> Integrated {
        let all = Asked::of(vec![[f64::NEG_INFINITY, f64::INFINITY]]);
        let mut integrator = Integrator::new(gap_s, &all);
        t_s.iter().zip(rates).for_each(|(t_s, rate)| integrator.push(*t_s, *rate));
        integrator.ended()
    }

    /// Classical coning: the body axis z describes a cone of half angle `a` at `f` Hz; its rate is known in
    /// closed form.
    fn coning_error(rate_hz: f64) -> f64 {
        let (a, w) = (0.1_f64, 2.0 * std::f64::consts::PI);
        let attitude = |t: f64| {
            let axis = Vector3::new((w * t).cos(), (w * t).sin(), 0.0);
            UnitQuaternion::from_scaled_axis(axis * a)
        };
        let rate = |t: f64| {
            Vector3::new(-a.sin() * (w * t).sin(), a.sin() * (w * t).cos(), -2.0 * (a / 2.0).sin().powi(2)) * w
        };
        let count = (10.0 * rate_hz) as usize;
        let t_s: Vec<f64> = (0..=count).map(|i| i as f64 / rate_hz).collect();
        let rates: Vec<Vector3<f64>> = t_s.iter().map(|&t| rate(t)).collect();
        let rotation = integrated(&t_s, &rates, 1.0).rotation(0.0, 10.0).unwrap();
        (attitude(0.0).inverse() * attitude(10.0)).angle_to(&rotation)
    }

    #[test]
    fn coning_errs_by_the_chord_alone_and_so_with_the_square_of_the_step() {
        // The swing's amplitude loses (w dt)^2 / 12 to the chord, the drift a^2 w / 2 that it makes twice
        // that.
        let w_dt = 2.0 * std::f64::consts::PI / 100.0;
        let chord = (w_dt * w_dt / 12.0) * 0.1 * 0.1 * 2.0 * std::f64::consts::PI * 10.0;
        assert!((coning_error(100.0) / chord - 1.0).abs() < 0.02, "{} {chord}", coning_error(100.0));
        assert!((coning_error(100.0) / coning_error(200.0) - 4.0).abs() < 0.1);
    }

    #[test]
    fn an_instant_between_readings_splits_a_rotation_without_a_remainder() {
        let rates = [1.0, 3.0, -2.0, 4.0].map(|z| Vector3::new(0.0, 0.0, z));
        let whole = integrated(&[0.0, 0.01, 0.02, 0.03], &rates, 1.0);
        let parts = whole.rotation(0.0, 0.0137).unwrap() * whole.rotation(0.0137, 0.03).unwrap();
        assert!(parts.angle_to(&whole.rotation(0.0, 0.03).unwrap()) < 1e-12);
        // Trapezoids: 0.02 + 0.005 + 0.01 rad.
        assert!((whole.rotation(0.0, 0.03).unwrap().angle() - 0.035).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_integrated_across_a_gap_or_beyond_the_ends() {
        let integrated = integrated(&[0.0, 0.01, 0.02, 0.12, 0.13], &[Vector3::new(1.0, 0.0, 0.0); 5], 0.03);
        assert!(integrated.rotation(0.0, 0.02).is_some());
        assert!(integrated.rotation(0.01, 0.12).is_none());
        assert!(integrated.rotation(0.01, 0.05).is_none());
        assert!(integrated.rotation(0.12, 0.14).is_none());
        assert!(integrated.rotation(-0.01, 0.01).is_none());
    }

    #[test]
    fn what_is_kept_about_the_times_asked_gives_the_rotations_of_the_whole() {
        let t_s: Vec<f64> = (0..4_000).filter(|k| k % 977 > 40).map(|k| f64::from(k) * 0.01).collect();
        let rates: Vec<_> = t_s.iter().map(|t| Vector3::new(t.sin(), (3.0 * t).cos(), 0.1 * t)).collect();
        let whole = integrated(&t_s, &rates, 0.03);
        let asked: Vec<[f64; 2]> = (-1..21).map(|k| [2.0 * f64::from(k) - 0.02, 2.0 * f64::from(k) + 0.02]).collect();
        let asked_of = Asked::of(asked.iter().rev().copied().collect());
        let mut integrator = Integrator::new(0.03, &asked_of);
        t_s.iter().zip(&rates).for_each(|(t_s, rate)| integrator.push(*t_s, *rate));
        let thin = integrator.ended();
        assert!(thin.kept.len() < 200, "{}", thin.kept.len());
        let mut known = 0;
        for pair in asked.windows(2) {
            for share in [0.0, 0.13, 0.5, 0.77, 1.0] {
                let at = |[from_s, to_s]: [f64; 2]| from_s + share * (to_s - from_s);
                let rotation = whole.rotation(at(pair[0]), at(pair[1]));
                assert_eq!(thin.rotation(at(pair[0]), at(pair[1])), rotation);
                known += usize::from(rotation.is_some());
            }
        }
        assert!((40..100).contains(&known), "{known}");
    }
}
