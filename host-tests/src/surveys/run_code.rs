//! Tool code of a run, by what was done to it.

use super::{
    settings::RunSettings,
    tool_codes::{Term, ToolCode},
};
use testbed::failure::Failure;

/// The code, and a warning where what was done has none of its own.
pub fn tool_code(settings: &RunSettings, sag: bool, multi_station: bool) -> (ToolCode, Option<String>) {
    let wanted = ToolCode { field: settings.field_class(), sag, multi_station };
    let code = wanted.published();
    let [wants, has] = [wanted, code].map(|code| code.name(false));
    (code, (code != wanted).then(|| format!("there is no tool code {wants}: positions are as uncertain as with {has}")))
}

/// Terms of a tool code with the run's factors.
///
/// # Errors
/// A factor is of no term, or is not a number from 0 on.
pub fn terms(code: ToolCode, settings: &RunSettings) -> Result<Vec<Term>, Failure> {
    let mut terms = code.terms(&settings.errors);
    for (name, factor) in &settings.term_factors {
        let term = terms.iter_mut().find(|term| term.name == name).filter(|_| factor.is_finite() && *factor >= 0.0);
        let bad =
            || Failure::BadInput(format!("term_factors: {name} = {factor}: no term of the tool code, or no factor"));
        term.ok_or_else(bad)?.sigma *= factor;
    }
    Ok(terms)
}
