/// Cost of a method: evaluations of all residuals, and normal matrices, which count as five evaluations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Spent {
    pub evaluations: u32,
    pub matrices: u32,
}

impl Spent {
    /// Weights from the residuals, a normal matrix and its solution.
    pub const fn solve(&mut self) {
        self.evaluations += 1;
        self.matrices += 1;
    }

    pub const fn total(self) -> u32 {
        self.evaluations + 5 * self.matrices
    }
}
