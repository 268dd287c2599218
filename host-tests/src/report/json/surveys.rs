//! Surveys in the result: the columns of `--surveys`, a number where there is one.

use meerkat_mwd::survey::SurveyReport;
use serde_json::{Map, Value, json};

use crate::report::surveys_csv::surveys_csv;

/// Columns that hold a word.
const WORDS: [&str; 4] = ["kind", "toolface", "grade", "reason"];

/// One object a survey.
pub(super) fn surveys_json(surveys: &[SurveyReport]) -> Vec<Map<String, Value>> {
    let text = surveys_csv(surveys);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let value = |name: &str, cell: &str| match name {
        _ if cell.is_empty() => Value::Null,
        "rotating" => json!(cell == "1"),
        name if WORDS.contains(&name) => json!(cell),
        _ => cell.parse::<f64>().map_or(Value::Null, |number| json!(number)),
    };
    let row = |line: &str| {
        names.iter().zip(line.split(',')).map(|(name, cell)| ((*name).to_owned(), value(name, cell))).collect()
    };
    lines.map(row).collect()
}
