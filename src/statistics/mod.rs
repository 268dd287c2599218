//! Statistical limits that more than one module uses.

pub(crate) mod chi_square;
