//! View of what a probe has reported so far, as a screen, as lines and as a page.

mod history;
mod live_page;
mod screen;
mod self_test;
mod state;
mod summary;

pub use history::History;
pub use live_page::LivePage;
pub use screen::draw;
pub use self_test::self_test_text;
pub use state::State;
pub use summary::summary_lines;
