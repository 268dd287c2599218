//! Layout of figures in rows: a table for a reader at a terminal, and elsewhere lines of which each says by
//! itself what it shows, for a search or a program that reads them.

use testbed::console;

/// Layout of rows of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Columns under a header.
    Table,
    /// A line for each row, with the names of its columns.
    Lines,
}

impl Layout {
    /// The layout for where a command tells what it did.
    #[must_use]
    pub fn of_told() -> Self {
        if console::tells_a_terminal() { Self::Table } else { Self::Lines }
    }
}

/// Cells with the names of their columns, as one line says them.
#[must_use]
pub fn named<const N: usize>(columns: [&str; N], cells: &[String; N]) -> String {
    let pairs: Vec<String> = columns.iter().zip(cells).map(|(column, cell)| format!("{column} {cell}")).collect();
    pairs.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_names_its_columns() {
        assert_eq!(named(["raw", "flown"], &["3.1".to_owned(), "0.2".to_owned()]), "raw 3.1, flown 0.2");
    }
}
