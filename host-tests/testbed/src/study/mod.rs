//! Common parts of studies: their tables, effort and seeds, a simulated window, and the bound of Cramer and Rao.

pub mod cramer_rao;
mod effort;
pub mod gyro_grade;
pub mod one_window;
pub mod seeds;
mod table;

pub use effort::Effort;
pub use table::{Cell, Table, median, median_and_lowest, median_and_worst, rms};
