//! Ways to read one gyro after one window, side by side.

use meerkat_mwd::{compensation::GyroModel, config::OptimizerKind, identification::Decision};

use testbed::study::{cramer_rao::Vibration, one_window::Run};

/// Searches with their names; all have the same budget, start and box.
const SEARCHES: [(OptimizerKind, &str); 4] = [
    (OptimizerKind::Pso, "PSO"),
    (OptimizerKind::Moa, "MOA"),
    (OptimizerKind::Imoa, "IMOA"),
    (OptimizerKind::Lm, "Levenberg-Marquardt"),
];

/// Names of the models, in the order of [`Contenders::models`].
pub const NAMES: [&str; 9] = [
    "raw",
    "bias only",
    SEARCHES[0].1,
    SEARCHES[1].1,
    SEARCHES[2].1,
    SEARCHES[3].1,
    "flown (IMOA behind its gate)",
    "true parameters",
    "an estimate at the Cramer-Rao bound",
];

/// Index of IMOA's model among [`NAMES`].
pub const IMOA: usize = 4;
/// Index of the true parameters.
pub const TRUE: usize = 7;
/// Index of the estimate at the Cramer-Rao bound.
pub const AT_BOUND: usize = 8;

/// The models of one run.
pub struct Contenders {
    /// True if IMOA's P flies.
    pub accepted: bool,
    /// The models, in the order of [`NAMES`]. A search's model is the better of its answer and the least-squares point;
    /// where the window is refused it is that point.
    pub models: [GyroModel; NAMES.len()],
}

impl Contenders {
    /// Identifies the run's window with every search. `seed` draws the estimate at the bound.
    ///
    /// # Errors
    /// A window cannot be identified.
    pub fn of(run: &Run, seed: u64) -> anyhow::Result<Self> {
        let [pso, moa, imoa, lm] = SEARCHES.map(|(optimizer, _)| run.identify(optimizer));
        let imoa = imoa?;
        let truth = run.true_model();
        let at_bound = run.bound(Vibration::Coloured.into()).draw(&truth, seed);
        Ok(Self {
            accepted: imoa.decision == Decision::Accepted,
            models: [
                GyroModel::IDENTITY,
                imoa.bias_only,
                pso?.fitted,
                moa?.fitted,
                imoa.fitted,
                lm?.fitted,
                imoa.flown,
                truth,
                at_bound,
            ],
        })
    }
}
