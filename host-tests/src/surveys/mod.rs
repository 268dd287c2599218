//! Surveys on a desk: stations from files, their corrections, paths, and the files that others read.

mod cells;
mod chosen;
mod column_names;
pub mod files;
mod far_off;
pub mod path;
mod placed;
pub mod position_errors;
pub mod reference;
mod run_code;
pub mod sag;
pub mod settings;
mod settings_file;
pub mod simulated_run;
pub mod stations_csv;
pub mod surveyed;
pub mod term_weights;
pub mod tool_codes;
