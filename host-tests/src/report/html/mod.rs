//! HTML pages, each one file that needs nothing else.

pub mod diagnosis;
pub mod escape;
pub mod replay;
mod svg;
mod table;

use std::path::Path;

use escape::escape;
pub use svg::{Plot, Series};
pub use table::{figure, table};

use crate::failure::Failure;

/// Writes a page.
///
/// # Errors
/// When the file cannot be written.
pub fn write_page(path: &Path, page: &str) -> Result<(), Failure> {
    std::fs::write(path, page).map_err(|error| Failure::output(path, &error))
}

/// A whole page around a body. The title is plain text and is escaped here.
#[must_use]
pub fn document(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n{body}</body>\n</html>\n",
        escape(title),
        include_str!("style.css"),
    )
}

/// Text with a capital first letter.
#[must_use]
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_means_something_in_a_page_is_escaped() {
        assert_eq!(escape("a<b> & \"c\"\u{1}'"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}&#39;");
        assert_eq!(sentence("what"), "What");
    }
}
