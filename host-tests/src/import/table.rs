//! A table of numbers as a source holds it: named columns, before anything is known of their meaning.

/// Columns of one file, topic or variable, all of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name by which a map refers to it: the file's name without its ending, the topic, the variable.
    pub name: String,
    /// Its columns, in their order.
    pub columns: Vec<Column>,
    /// `key = value` lines that stand above the header row.
    pub keys: Vec<(String, String)>,
}

/// Contents of a file, or of several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Its tables.
    pub tables: Vec<Table>,
    /// Reasons for which a part of it is not read: it is cut off or damaged.
    pub lost: Vec<String>,
    /// Remarks on what is there and was passed over.
    pub notes: Vec<String>,
}

impl Contents {
    /// Tables that were read as a whole.
    #[must_use]
    pub fn whole(tables: Vec<Table>) -> Self {
        Self { tables, ..Self::default() }
    }
}

/// A named column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Name as the source has it, with its unit if that stands in it.
    pub name: String,
    /// One number a row; NaN for a cell that is empty or no number.
    pub values: Vec<f64>,
    /// True if the cells are clock times, here in seconds.
    pub is_clock: bool,
    /// True if a date stands before any of these times.
    pub has_date: bool,
    /// First cell that is no number, with its line.
    pub not_a_number: Option<(u64, String)>,
    /// Number of such cells.
    pub not_numbers: usize,
}

impl Column {
    /// A column of numbers.
    #[must_use]
    pub fn of(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), values, ..Self::default() }
    }
}

impl Table {
    /// The column of this name; case and blanks around it do not count.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name.trim().eq_ignore_ascii_case(name.trim()))
    }

    /// Names of its columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}

/// Names that a message tells of those that there are.
pub const TOLD: usize = 40;

/// Names in a row, the first `most` of them, and how many more there are.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<&str> = names.collect();
    let more = if names.len() > most { format!(" and {} more", names.len() - most) } else { String::new() };
    format!("{}{more}", names[..names.len().min(most)].join(", "))
}
