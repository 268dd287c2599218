//! Export and import of the filter's state: the globals' mean and the root of their information, number by number, so
//! that no buffer holds all of them. `storage/learnt_parts.rs` writes them to flash.

use super::{
    Estimator,
    columns::{GLOBALS, NUISANCES},
    drift,
    filter::Task,
    globals::Globals,
    reading::REFERRED,
};
use crate::{config::Config, fingerprint::Fingerprint};

/// Count of the exported numbers: the mean, then the triangular root.
pub const NUMBERS: usize = GLOBALS * (GLOBALS + 1) / 2 + GLOBALS;

/// Version of the numbers' order and meaning.
const LAYOUT: u32 = 2;

/// Head of an exported state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearntHead {
    /// Names what the numbers are relative to: [`LearntHead::fingerprint`] of the configuration.
    pub fingerprint: u32,
    /// Number of the filter's update that the state is of: numbers of different updates must not be mixed.
    pub update: u32,
    /// Seconds of motion that the state comes from.
    pub motion_s: f32,
}

/// Learnt state of the filter, to be read while no update is under way.
#[derive(Clone, Copy)]
pub struct Learnt<'a> {
    /// Head of the numbers.
    pub head: LearntHead,
    globals: &'a Globals<f32>,
}

/// Why a filter does not go on from what was stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum NotContinued {
    /// The probe has not been configured, or has already taken a sample.
    NotAtTheBeginning,
    /// The state was learnt with another configuration, or by a filter with other unknowns.
    OtherFilter,
    /// Numbers are missing.
    Incomplete,
    /// A number is infinite or not one, or an unknown has no information.
    NotARoot,
}

impl LearntHead {
    /// Names everything that the numbers are relative to: the unknowns, their priors, and the calibrations that they
    /// are deviations from.
    #[must_use]
    pub fn fingerprint(config: &Config) -> u32 {
        let settings = super::Settings::new(config);
        let mut print = Fingerprint::new();
        for count in [LAYOUT, GLOBALS as u32, NUISANCES as u32, config.sample_period_us] {
            print.bytes(&count.to_le_bytes());
        }
        let (noise, latency) = (&settings.noise, &config.latency);
        print.numbers(&settings.sigma);
        print.numbers(&[noise.rotation_rad_rts, noise.field_share, noise.p_walk_rts, noise.position_m]);
        print.numbers(&[latency.gyro_s, latency.accel_s, latency.mag_s].map(|late| late.unwrap_or(-1.0)));
        print.numbers(&[settings.gravity_m_s2]);
        print.numbers(config.gyro.p.as_flattened());
        print.numbers(&config.gyro.b_rad_s);
        for model in [&config.accel, &config.mag] {
            print.numbers(model.matrix.as_flattened());
            print.numbers(&model.offset);
        }
        print.value()
    }
}

/// Row and column of the root's number `k`; column `GLOBALS` is that of the mean.
const fn place(k: usize) -> Option<(usize, usize)> {
    if k < GLOBALS {
        return Some((k, GLOBALS));
    }
    let (mut row, mut left) = (0, k - GLOBALS);
    while row < GLOBALS {
        let count = GLOBALS - row;
        if left < count {
            return Some((row, row + left));
        }
        left -= count;
        row += 1;
    }
    None
}

impl Learnt<'_> {
    /// Number `k` of [`NUMBERS`]: the mean, in units of the prior's widths, and then the root's rows.
    #[must_use]
    pub fn number(&self, k: usize) -> f32 {
        let number = match place(k) {
            Some((row, GLOBALS)) => self.globals.x.get(row),
            Some((row, column)) => self.globals.root.get(row).and_then(|row| row.get(column)),
            None => None,
        };
        number.copied().unwrap_or(0.0)
    }
}

impl<const NODES: usize, const E: usize> Estimator<f32, NODES, E> {
    /// Returns the filter's state; `None` while an update changes it.
    #[must_use]
    pub fn learnt(&self, fingerprint: u32) -> Option<Learnt<'_>> {
        // Before its first column no noise has been added.
        let is_whole =
            matches!(self.filter.task, Task::Idle | Task::Eliminating | Task::Weighing | Task::AddingNoise(0));
        let head = LearntHead { fingerprint, update: self.filter.updates, motion_s: self.filter.course.motion_s };
        is_whole.then_some(Learnt { head, globals: &self.filter.globals })
    }

    /// Sets number `k` of what an earlier session learnt, and does nothing beyond the last. Call
    /// [`Estimator::go_on`] when all are set.
    pub fn set_learnt(&mut self, k: usize, number: f32) {
        match place(k) {
            Some((row, GLOBALS)) => {
                if let Some(x) = self.filter.globals.x.get_mut(row) {
                    *x = number;
                }
            }
            Some((row, column)) => {
                if let Some(x) = self.filter.globals.root.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *x = number;
                }
            }
            None => {}
        }
    }

    /// Resets the globals to their prior, so that numbers that were set no longer count.
    pub fn drop_learnt(&mut self) {
        self.filter.globals.start();
    }

    /// Continues from the root and the mean that were set, inflated by the drift while the probe was off. P begins at
    /// the model that flew, see [`Estimator::restore`]: a mean over widths, inflations and scales. The stored mean has
    /// one width alone, and a P from it would be nearer to the factory's.
    ///
    /// # Errors
    /// The numbers are no root; the filter then starts without them.
    pub fn go_on(&mut self, motion_s: f32) -> Result<(), NotContinued> {
        let is_root = self.filter.globals.is_root() && motion_s >= 0.0 && motion_s.is_finite();
        for (column, width) in self.filter.prior.sigma.iter().enumerate() {
            // A column that is not in use keeps its prior.
            self.filter.globals.relax(column, drift::kept(column, *width));
        }
        // Finite numbers may have been too large to be squared.
        if !(is_root && self.filter.globals.is_root()) {
            self.drop_learnt();
            return Err(NotContinued::NotARoot);
        }
        self.filter.course.motion_s = motion_s;
        if self.filter.settings.reference.is_some() {
            // The learnt root holds the declared field.
            self.filter.node.referred = REFERRED;
        }
        self.filter.linearise();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
