//! View of what a probe has reported so far, as a screen and as lines.

mod screen;
mod state;
mod summary;

pub use screen::draw;
pub use state::State;
pub use summary::summary_lines;
