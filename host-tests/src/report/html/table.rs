//! Tables of a page.

use super::{escape::escape, fixed};

/// A row: whether it is highlighted, and its cells.
pub type Row = (bool, Vec<String>);

/// Letters from which a cell of several words may break its line.
const LONG: usize = 24;

/// Letters from which a word may break.
const LONG_WORD: usize = 40;

/// Rows up to which a narrow screen shows each as a list of its cells, beside the names of their columns; a
/// longer table scrolls there.
const FEW: usize = 12;

/// A table that scrolls where it is wider than the page. Cells are plain text and are escaped here. A head of empty
/// cells is left out.
#[must_use]
pub fn table(head: &[&str], rows: impl IntoIterator<Item = Row>) -> String {
    let rows: Vec<Row> = rows.into_iter().collect();
    let is_few = rows.len() <= FEW;
    // Rows that are shown as lists are no longer a table for the browser: roles say that they are.
    let role = |name: &str| if is_few { format!(" role=\"{name}\"") } else { String::new() };
    let class = if is_few { " class=\"few\"" } else { "" };
    let names: Vec<&str> = head.iter().copied().filter(|name| !name.is_empty()).collect();
    let label = if names.is_empty() { "Table".to_owned() } else { format!("Table of {}", escape(&names.join(", "))) };
    let mut out = format!(
        "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"{label}\">\n<table{class}{}>\n",
        role("table")
    );
    if !names.is_empty() {
        let cell = |name: &&str| match *name {
            "" => format!("<td{}></td>", role("cell")),
            name => format!("<th scope=\"col\"{}>{}</th>", role("columnheader"), escape(name)),
        };
        let cells: String = head.iter().map(cell).collect();
        out += &format!("<thead><tr{}>{cells}</tr></thead>\n", role("row"));
    }
    for (stands_out, row) in rows {
        let class = if stands_out { " class=\"added\"" } else { "" };
        let cell = |(number, text): (usize, &String)| {
            let class = if text.len() >= LONG && text.contains(' ') {
                " class=\"text\""
            } else if text.len() >= LONG_WORD {
                " class=\"hash\""
            } else {
                ""
            };
            let name = head.get(number).filter(|name| is_few && !name.is_empty());
            let name = name.map_or_else(String::new, |name| format!(" data-name=\"{}\"", escape(name)));
            format!("<td{class}{name}{}>{}</td>", role("cell"), escape(text))
        };
        let cells: String = row.iter().enumerate().map(cell).collect();
        out += &format!("<tr{class}{}>{cells}</tr>\n", role("row"));
    }
    out + "</table>\n</div>\n"
}

/// A number, or nothing if there is none.
#[must_use]
pub fn figure(x: Option<f64>) -> String {
    x.map_or_else(String::new, |x| fixed(x, 3))
}
