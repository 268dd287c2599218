//! Surveys on a desk: stations from files, their corrections, paths, and the files that others read.

mod analysis;
pub(crate) mod cells;
mod chosen;
mod column_names;
pub mod depth_by_time;
pub mod files;
pub(crate) mod far_off;
pub mod measured;
pub mod path;
mod placed;
pub mod position_errors;
pub mod reference;
pub mod run;
mod run_code;
pub mod sag;
pub mod settings;
pub(crate) mod settings_file;
pub mod simulated_run;
mod station_columns;
pub mod stations_csv;
pub mod surveyed;
pub mod term_weights;
pub mod tool_codes;
