//! What stands around `meerkat-mwd` on a desk: traces in, results and scores out.

pub mod flight;
pub mod known_error;
pub mod score;
pub mod simulate;
pub mod trace;
