use super::{SampleStream, TestEquations, WeakForm, rows::GYRO};

/// Most test windows of one window: two a second of the longest, on the grid that rounds half a second down the furthest.
pub(crate) const TESTS: usize = 100;

/// The test windows of one stretch of increments, made from the increments that are kept.
pub(crate) struct TestWindows {
    weak_form: WeakForm,
    made: [TestEquations; TESTS],
    count: usize,
    next: u32,
    to: u32,
    noise_gain: f32,
}

impl TestWindows {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            weak_form: WeakForm::zero(),
            made: [TestEquations::zero(); TESTS],
            count: 0,
            next: 0,
            to: 0,
            noise_gain: 0.0,
        }
    }

    /// Begins with increments `from..to`, the nominal model w = P w_raw - c, and test windows of `quarters` of the longest.
    pub fn start(&mut self, stream: &SampleStream, (from, to): (u32, u32), theta: &[f32; GYRO], quarters: usize) {
        self.weak_form.start(theta, stream.moving_rate_rad_s(), quarters);
        self.noise_gain = stream.test_function.noise_gain(quarters);
        (self.count, self.next, self.to) = (0, from, to);
    }

    /// Goes through so many increments, as they are without the active effects; false when there is none left, `None` when they have been
    /// overwritten.
    pub fn make(&mut self, stream: &SampleStream, increments: u32) -> Option<bool> {
        for _ in 0..increments {
            if self.next >= self.to {
                return Some(false);
            }
            if !stream.increments.holds(self.next) {
                return None;
            }
            let test = self.weak_form.push(&stream.increment(self.next), &stream.test_function);
            self.next += 1;
            if let (Some(test), Some(slot)) = (test, self.made.get_mut(self.count)) {
                *slot = test;
                self.count += 1;
            }
        }
        Some(true)
    }

    /// Variance of an equation whose vector has a white noise of variance 1 in each increment.
    pub const fn noise_gain(&self) -> f32 {
        self.noise_gain
    }

    /// Those that are made.
    pub fn all(&self) -> impl Iterator<Item = &TestEquations> {
        self.made.iter().take(self.count)
    }

    /// The same with their numbers.
    pub fn numbered(&self) -> impl Iterator<Item = (usize, &TestEquations)> {
        self.all().enumerate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::{Grid, TestFunction, UNDER_WAY};

    #[test]
    fn there_is_room_for_the_test_windows_of_the_longest_window_on_every_grid() {
        const LONGEST_S: f32 = 50.0;
        for period in 100..=20_000 {
            let grid = Grid::new(period);
            let mut function = TestFunction::zero();
            function.configure(grid);
            let begun = grid.increments_in(LONGEST_S) / function.hop();
            assert!(begun + 1 - UNDER_WAY <= TESTS, "{period}: {begun}");
        }
    }
}
