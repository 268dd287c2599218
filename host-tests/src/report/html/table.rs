//! Tables of a page.

use super::escape::escape;

/// A row: whether it is highlighted, and its cells.
pub type Row = (bool, Vec<String>);

/// A table. Cells are plain text and are escaped here.
#[must_use]
pub fn table(head: &[&str], rows: impl IntoIterator<Item = Row>) -> String {
    let cells = |tag: &str, cells: &mut dyn Iterator<Item = &str>| -> String {
        cells.map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect()
    };
    let mut out = format!("<table>\n<tr>{}</tr>\n", cells("th", &mut head.iter().copied()));
    for (stands_out, row) in rows {
        let class = if stands_out { " class=\"added\"" } else { "" };
        out += &format!("<tr{class}>{}</tr>\n", cells("td", &mut row.iter().map(String::as_str)));
    }
    out + "</table>\n"
}

/// A number, or a dash if there is none.
#[must_use]
pub fn figure(x: Option<f64>) -> String {
    x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"))
}
