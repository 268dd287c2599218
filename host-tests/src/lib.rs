//! What stands around `meerkat-mwd` on a desk: traces in, results and scores out.

pub mod attitude_csv;
pub mod bench;
pub mod cli;
pub mod configuration;
pub mod deadline;
pub mod diagnose;
pub mod emulate;
pub mod failure;
pub mod flight;
pub mod image;
pub mod known_error;
pub mod main_job;
pub mod rates_csv;
pub mod recordings;
pub mod refusal_text;
pub mod replay;
pub mod result_json;
pub mod score;
pub mod simulate;
pub mod summary;
pub mod toolchain;
pub mod trace;
pub mod window_note;
pub mod wire;
