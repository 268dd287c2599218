//! Progress of a long computation.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar on a terminal; hidden in a pipe.
#[must_use]
pub fn progress_bar(samples: usize) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta}").ok();
    let bar = ProgressBar::new(samples as u64);
    style.into_iter().fold(bar, ProgressBar::with_style)
}
