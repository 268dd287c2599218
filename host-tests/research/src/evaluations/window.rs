use anyhow::Context;
use meerkat_mwd::{
    Probe,
    config::OptimizerKind,
    identification::{RADIUS, Searched, WindowCost},
    optimizer::{Cost, Found, LevenbergMarquardt, Optimizer},
};
use testbed::{
    flight::configuration::of_trace,
    simulate::{Hole, Random, Scenario, simulate},
};

/// The cost of one simulated window, in whitened coordinates over [`RADIUS`], and where it is lowest.
pub(super) struct Window {
    probe: Box<Probe>,
    optimum: [f32; 12],
    lowest: f32,
}

/// Outcome of Levenberg-Marquardt.
pub(super) struct Descent {
    pub lowest: f32,
    pub evaluations: u32,
}

impl Window {
    /// The first window of a drilling run.
    pub fn simulated(inclination_deg: f64, seed: u64) -> anyhow::Result<Self> {
        let hole = Hole { inclination_deg, ..Hole::default() };
        let (trace, _) = simulate(&Scenario { duration_s: 51.5, hole, ..Scenario::default() }, seed);
        let mut config = of_trace(&trace);
        // Only the identification is measured.
        config.effects = false;
        config.identification.optimizer = OptimizerKind::Ls;
        let mut probe = Box::new(Probe::new());
        probe.configure(&config)?;
        for sample in &trace.samples {
            probe.push(sample);
            probe.poll(probe.poll_budget());
        }
        let mut window = Self { probe, optimum: [0.0; 12], lowest: 0.0 };
        let cost = window.cost().with_context(|| format!("seed {seed} has no window"))?;
        let (found, descent) = levenberg_marquardt(&cost, [0.0; 12]);
        (window.optimum, window.lowest) = (found.map(|y| y / RADIUS), descent.lowest);
        Ok(window)
    }

    fn cost(&self) -> Option<WindowCost<'_>> {
        self.probe.window_cost()
    }

    /// Distance of a point from the optimum, posterior deviations.
    pub fn distance(&self, y: &[f32; 12]) -> f64 {
        let square: f64 = y.iter().zip(&self.optimum).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        f64::from(RADIUS) * square.sqrt()
    }

    /// Returns true if a cost, prior included, is within 1 % of the lowest.
    pub fn is_reached(&self, cost: f32) -> bool {
        cost < 1.01 * self.lowest
    }

    /// Levenberg-Marquardt from a point until it is done.
    pub fn descent(&self, y: &[f32; 12]) -> Option<Descent> {
        let cost = self.cost()?;
        let (_, descent) = levenberg_marquardt(&cost, y.map(|y| RADIUS * y));
        Some(descent)
    }
}

impl Cost<12> for Window {
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        self.cost().map_or(f32::NAN, |cost| Searched(&cost).evaluate(y))
    }
}

fn levenberg_marquardt(cost: &WindowCost<'_>, start: [f32; 12]) -> ([f32; 12], Descent) {
    let mut search = LevenbergMarquardt::<12, 78>::new(start, 1_000);
    search.run(cost, u32::MAX);
    let (y, lowest) = search.best();
    (*y, Descent { lowest, evaluations: search.evaluations() })
}

/// A point at this distance from the posterior's mean, in a random direction.
pub(super) fn away(deviations: f64, seed: u64) -> [f32; 12] {
    let mut random = Random::new(seed);
    let direction: [f64; 12] = std::array::from_fn(|_| random.normal());
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    direction.map(|x| (x / length * deviations) as f32 / RADIUS)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Near its optimum a window's cost has curvature 1 per posterior deviation, as whitening promises: one
    /// deviation off costs 1/2, apart from Huber's loss.
    #[test]
    fn a_deviation_off_the_optimum_costs_a_half() {
        let window = Window::simulated(45.0, 100).unwrap();
        assert!(window.distance(&window.optimum) == 0.0);
        for seed in 0..5 {
            let off = away(1.0, seed);
            let mut y = window.optimum;
            for (y, off) in y.iter_mut().zip(off) {
                *y += off;
            }
            assert!((window.distance(&y) - 1.0).abs() < 1e-4);
            let excess = window.evaluate(&y) - window.lowest;
            assert!((0.25..0.6).contains(&excess), "seed {seed}: {excess}");
        }
    }
}
