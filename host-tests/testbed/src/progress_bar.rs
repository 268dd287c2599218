//! Progress of a long computation.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

use crate::console::is_quiet;

/// A progress bar on a terminal; hidden in a pipe, and where nothing is to be told.
#[must_use]
pub fn progress_bar(samples: usize) -> ProgressBar {
    if !io::stderr().is_terminal() || is_quiet() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta}").ok();
    let bar = ProgressBar::new(samples as u64);
    style.into_iter().fold(bar, ProgressBar::with_style)
}
