//! Tables of a page.

use super::{escape::escape, fixed};

/// A row: whether it is highlighted, and its cells.
pub type Row = (bool, Vec<String>);

/// Letters from which a cell is text that needs room.
const LONG: usize = 40;

/// A table that scrolls where it is wider than the page. Cells are plain text and are escaped here. A head of empty
/// cells is left out.
#[must_use]
pub fn table(head: &[&str], rows: impl IntoIterator<Item = Row>) -> String {
    let mut out = "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"Table\">\n<table>\n".to_owned();
    if head.iter().any(|name| !name.is_empty()) {
        let cell = |name: &&str| match *name {
            "" => "<td></td>".to_owned(),
            name => format!("<th scope=\"col\">{}</th>", escape(name)),
        };
        let cells: String = head.iter().map(cell).collect();
        out += &format!("<tr>{cells}</tr>\n");
    }
    for (stands_out, row) in rows {
        let class = if stands_out { " class=\"added\"" } else { "" };
        let cell = |text: &String| {
            let class = if text.len() >= LONG && text.contains(' ') {
                " class=\"text\""
            } else if text.len() >= LONG {
                " class=\"hash\""
            } else {
                ""
            };
            format!("<td{class}>{}</td>", escape(text))
        };
        let cells: String = row.iter().map(cell).collect();
        out += &format!("<tr{class}>{cells}</tr>\n");
    }
    out + "</table>\n</div>\n"
}

/// A number, or nothing if there is none.
#[must_use]
pub fn figure(x: Option<f64>) -> String {
    x.map_or_else(String::new, |x| fixed(x, 3))
}
