//! Explanation of an update, for tools on a host: rows that moved P, and the evidence of the widths. Nothing here
//! changes the filter.

use super::{
    Estimator,
    averaging::Averaging,
    candidates::Candidates,
    columns::{GLOBALS, P},
    filter::Task,
    real::Real,
    rows::SCRATCH,
    rows::WIDTH,
    update::{BY_REST, FIELD_READ, POSITION_BOUND, VELOCITY_BOUND},
    widths::{GROUPS, Widths},
};

/// Change of P, row-major, by each kind of rows, in one node or in several. The sum is the change of the filter's mean.
///
/// A node's update is linear: gain times the constants of its rows, which are their residuals at the linearisation
/// point. Each kind's share is the gain of all rows times the constants of that kind. Rows of rotation, of the field's
/// walk, and of the path have zero constants, as the next states are predicted with them: they say how the others'
/// residuals are shared among attitude, P and the rest, and move nothing themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MovedByRows {
    /// Change of P by rows of the read field: the magnetometer's part.
    pub field: [f32; 9],
    /// Change of P by bounds of velocity: with those of position the accelerometer's part.
    pub velocity: [f32; 9],
    /// Change of P by bounds of position.
    pub position: [f32; 9],
    /// Change of P by rows of rests.
    pub rest: [f32; 9],
}

/// Evidence that the widths of the vector sensors' errors are others than the data sheets': log Bayes factors of a
/// width that is anywhere on the grid, each equally likely, over the data sheet's. Negative where the data sheet is
/// right, though no lower than minus the logarithm of how many widths there are. Positive where a sensor is worse
/// than its data sheet, and where it is better: [`super::Posterior::widths`] say which.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WidthEvidence {
    /// Evidence of all groups together.
    pub all: f32,
    /// Evidence of each group alone, averaged over the widths of the others: magnetometer shape, hard iron,
    /// accelerometer matrix, magnetometer misalignment, accelerometer bias.
    pub of_group: [f32; GROUPS],
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Change of P by each kind of rows, in the node whose rows have just been written; `None` at any other step of the
    /// work. To be asked after each [`Estimator::step`].
    #[must_use]
    pub fn moved_by_rows(&self) -> Option<MovedByRows> {
        let is_fresh = self.filter.task == Task::Eliminating && self.filter.update.is_fresh();
        is_fresh.then(|| {
            let [field, velocity, position, rest] =
                [FIELD_READ, VELOCITY_BOUND, POSITION_BOUND, BY_REST].map(|block| self.moved_by(block));
            MovedByRows { field, velocity, position, rest }
        })
    }

    /// Change of P by the constants of this block of rows alone.
    fn moved_by(&self, block: usize) -> [f32; 9] {
        let (mut update, mut globals) = (self.filter.update, self.filter.globals);
        update.keep_constants(block);
        let mut none = [[T::ZERO; 0]; SCRATCH];
        let mut candidates = Candidates::zero();
        while update.eliminate(&candidates, &mut none) {}
        let mut column = 0;
        while column < GLOBALS {
            column = candidates.absorb(&mut none, &mut globals, update.left_over(), column);
        }
        let change = globals.solve();
        let mut moved = [0.0; 9];
        for (moved, column) in moved.iter_mut().zip(P.columns()) {
            let of = |all: &[T; GLOBALS]| all.get(column).copied().unwrap_or(T::ZERO);
            *moved = (of(&change) * of(&self.filter.prior.sigma)).narrow();
        }
        moved
    }

    /// Evidence about the widths, when the posterior is about to be averaged; `None` at any other step of the work.
    /// To be asked after each [`Estimator::step`].
    #[must_use]
    pub fn width_evidence(&self) -> Option<WidthEvidence> {
        self.closing.fresh_average()?;
        let grid = &self.filter.settings.widths;
        let mut scratch = [[T::ZERO; WIDTH]; SCRATCH];
        let mut all = LogMean::new();
        let mut of_group = [LogMean::new(); GROUPS];
        let mut sheet = 0.0;
        for set in Sets::of(grid) {
            let widths = grid.only(set);
            let mut one = Averaging::zero();
            one.start(&self.filter.globals, &widths, &mut scratch);
            one.gather(0..GLOBALS, &mut scratch);
            while one.step(&mut scratch) {}
            let log = one.log_evidence().narrow();
            all.add(log);
            let sheets = grid.sheets(set);
            for (group, mean) in of_group.iter_mut().enumerate() {
                // Mean over the sets with this group's data sheet width, held against that over all sets below.
                if sheets.get(group) == Some(&true) {
                    mean.add(log);
                }
            }
            if sheets == [true; GROUPS] {
                sheet = log;
            }
        }
        let all_widths = all.get();
        Some(WidthEvidence { all: all_widths - sheet, of_group: of_group.map(|sheets| all_widths - sheets.get()) })
    }
}

/// Every choice of one width a group.
struct Sets {
    count: [usize; GROUPS],
    next: usize,
}

impl Sets {
    const fn of(grid: &Widths) -> Self {
        Self { count: grid.count, next: 0 }
    }
}

impl Iterator for Sets {
    type Item = [usize; GROUPS];

    fn next(&mut self) -> Option<[usize; GROUPS]> {
        let mut rest = self.next;
        let mut set = [0; GROUPS];
        for (slot, count) in set.iter_mut().zip(self.count) {
            *slot = rest.checked_rem(count)?;
            rest = rest.checked_div(count)?;
        }
        self.next += 1;
        (rest == 0).then_some(set)
    }
}

/// Logarithm of the mean of numbers of which the logarithms are known.
#[derive(Clone, Copy)]
struct LogMean {
    unit: f32,
    sum: f32,
    count: u16,
}

impl LogMean {
    const fn new() -> Self {
        Self { unit: f32::NEG_INFINITY, sum: 0.0, count: 0 }
    }

    fn add(&mut self, log: f32) {
        if log > self.unit {
            self.sum *= libm::expf(self.unit - log);
            self.unit = log;
        }
        self.sum += libm::expf(log - self.unit);
        self.count += 1;
    }

    fn get(&self) -> f32 {
        self.unit + libm::logf(self.sum / f32::from(self.count))
    }
}

#[cfg(test)]
mod tests;
