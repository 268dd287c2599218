use std::fmt;

use serde::Serialize;

use crate::score::root_mean_square;

/// A table, as a page of measurements shows it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Table {
    /// Description of the figures, with units.
    pub title: String,
    /// Heads of the columns, the first one above the rows' names.
    pub columns: Vec<String>,
    /// Name and cells of each row.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell: printed text, and its numbers unrounded; a number that does not exist is left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cell {
    /// Text as printed.
    pub text: String,
    /// The number of a cell that shows one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The median of a cell that shows `median [worst]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub median: Option<f64>,
    /// The worst of such a cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst: Option<f64>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        Self { title: title.into(), columns: columns.iter().map(ToString::to_string).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells at its end are blank.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        let mut row: Vec<Cell> = cells.into_iter().map(Into::into).collect();
        row.resize(self.columns.len(), Cell::default());
        self.rows.push(row);
    }
}

impl Cell {
    /// A number; `-` for one that is not finite.
    #[must_use]
    pub fn number(value: f64, decimals: usize) -> Self {
        let exists = value.is_finite();
        let text = if exists { format!("{value:.decimals$}") } else { "-".to_owned() };
        Self { text, value: exists.then_some(value), ..Self::default() }
    }

    /// A share, shown in percent.
    #[must_use]
    pub fn percent(share: f64, decimals: usize) -> Self {
        Self::number(100.0 * share, decimals)
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

/// Prints the table as Markdown.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.title)?;
        writeln!(f, "| {} |", self.columns.join(" | "))?;
        writeln!(f, "|{}", "---|".repeat(self.columns.len()))?;
        for row in &self.rows {
            let texts: Vec<&str> = row.iter().map(|cell| cell.text.as_str()).collect();
            writeln!(f, "| {} |", texts.join(" | "))?;
        }
        Ok(())
    }
}

/// A cell `median [worst]` of values of which small ones are good.
#[must_use]
pub fn median_and_worst(values: &[f64], decimals: usize) -> Cell {
    of_sorted(&sorted(values), f64::INFINITY, decimals)
}

/// A cell `median [worst]` of values of which large ones are good.
#[must_use]
pub fn median_and_lowest(values: &[f64], decimals: usize) -> Cell {
    of_sorted(&sorted(values), f64::NEG_INFINITY, decimals)
}

/// Median, the upper one of an even number; NaN without values.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    sorted(values).get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// A cell of sorted values; the worst is the one towards `bad`.
fn of_sorted(sorted: &[f64], bad: f64, decimals: usize) -> Cell {
    let worst = if bad > 0.0 { sorted.last() } else { sorted.first() };
    match (sorted.get(sorted.len() / 2), worst) {
        (Some(&median), Some(&worst)) if median.is_finite() => Cell {
            text: format!("{median:.decimals$} [{worst:.decimals$}]"),
            median: Some(median),
            worst: Some(worst).filter(|x| x.is_finite()),
            value: None,
        },
        _ => "-".into(),
    }
}

/// Root mean square; NaN without values.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    root_mean_square(values.iter().copied()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_keeps_its_numbers_unrounded_and_has_none_where_there_is_none() {
        let cell = median_and_worst(&[0.123_4, 0.5, 0.001], 2);
        assert_eq!((cell.text.as_str(), cell.median, cell.worst), ("0.12 [0.50]", Some(0.123_4), Some(0.5)));
        assert_eq!(median_and_lowest(&[0.123_4, 0.5, 0.001], 2).worst, Some(0.001));
        assert_eq!(Cell::number(f64::NAN, 2), "-".into());
        assert_eq!(median_and_worst(&[], 2), "-".into());
        assert_eq!(Cell::percent(0.123, 1).text, "12.3");
        assert!((rms(&[3.0, 4.0]) - 12.5_f64.sqrt()).abs() < 1e-12);
    }
}
