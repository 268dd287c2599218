//! Power cuts of the storage: at each word and each erasure of what it does, and what a start finds then.

use super::does_not_hold::DoesNotHold;
use crate::power_cuts::{Left, Starts, doses, factory_records, images, learnt, models, settings};
use testbed::study::{Cell, Effort, Table};

/// Kinds of cut, in the order of `mock_flash::CUTS`.
const CUTS: [&str; 3] =
    ["before it begins", "in it: bits are left as they were, programmed, erased or random", "after it, unreported"];

pub fn run(_effort: Effort) -> anyhow::Result<Vec<Table>> {
    let script = models::script_cut_everywhere();
    let mut actions: Vec<(&str, Left)> = models::KINDS.into_iter().zip(script).collect();
    actions.extend([
        ("a model is stored with what the filter has learnt", learnt::cut_everywhere()),
        ("a configuration is stored", settings::cut_everywhere()),
        ("a vibration dose is stored", doses::cut_everywhere()),
        ("the factory writes a record", factory_records::cut_everywhere()),
        ("the program is updated", images::cut_everywhere()),
    ]);
    tables(&actions)
}

fn count(number: u64) -> Cell {
    Cell::number(number as f64, 0)
}

/// # Errors
/// Something was lost.
fn tables(actions: &[(&str, Left)]) -> anyhow::Result<Vec<Table>> {
    let of_starts = ["cuts", "before the action", "after it", "lost"];
    let mut by_action = Table::new(
        "The power is cut before, in and after each word that is programmed and each sector that is erased; what a start finds then",
        &[&["action", "times", "words and erasures"], &of_starts[..]].concat(),
    );
    let row = |starts: Starts| [count(starts.all()), count(starts.old), count(starts.new), count(starts.lost)];
    let mut of_cuts = [Starts::default(); CUTS.len()];
    for (name, left) in actions {
        let first = [Cell::from(*name), count(left.actions), count(left.operations)];
        by_action.row(first.into_iter().chain(row(left.starts())));
        for (all, starts) in of_cuts.iter_mut().zip(left.cuts) {
            *all = all.and(starts);
        }
    }
    let all = of_cuts.into_iter().fold(Starts::default(), Starts::and);
    let sum = |of: fn(&Left) -> u64| count(actions.iter().map(|(_, left)| of(left)).sum());
    let first = [Cell::from("all"), sum(|left| left.actions), sum(|left| left.operations)];
    by_action.row(first.into_iter().chain(row(all)));
    let mut by_cut =
        Table::new("The same by kind of cut of a word or an erasure", &[&["cut"], &of_starts[..]].concat());
    for (name, starts) in CUTS.into_iter().zip(of_cuts) {
        by_cut.row([Cell::from(name)].into_iter().chain(row(starts)));
    }
    let tables = vec![by_action, by_cut];
    if all.lost == 0 {
        return Ok(tables);
    }
    let told = |(name, left): &(&str, Left)| left.first.as_ref().map(|first| format!("{name}: {first}"));
    let words = actions.iter().filter_map(told).collect::<Vec<_>>().join("\n");
    Err(DoesNotHold { tables, words: format!("something was lost:\n{words}") }.into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_loss_is_in_the_tables_and_ends_with_an_error() {
        let sound = Left { actions: 1, operations: 2, cuts: [Starts { old: 1, new: 1, lost: 0 }; 3], first: None };
        let [by_action, _] = &tables(&[("one", sound.clone())]).unwrap()[..] else { panic!("two tables") };
        assert!(by_action.to_string().ends_with("| one | 1 | 2 | 6 | 3 | 3 | 0 |\n| all | 1 | 2 | 6 | 3 | 3 | 0 |\n"));
        let mut lossy = Left { first: Some("operation 7".to_owned()), ..sound.clone() };
        lossy.cuts[1].lost = 4;
        let told: DoesNotHold = tables(&[("one", sound), ("other", lossy)]).unwrap_err().downcast().unwrap();
        assert_eq!(told.words, "something was lost:\nother: operation 7");
        assert!(told.tables[0].to_string().contains("| all | 2 | 4 | 16 | 6 | 6 | 4 |"), "{}", told.tables[0]);
    }
}
