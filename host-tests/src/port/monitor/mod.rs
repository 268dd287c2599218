//! What a probe has said so far, on a screen and in lines.

mod screen;
mod state;
mod summary;

pub use screen::draw;
pub use state::State;
pub use summary::summary_lines;
