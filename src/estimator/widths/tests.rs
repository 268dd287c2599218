use super::*;

extern crate std;
use std::vec::Vec;

#[test]
fn near_a_set_is_every_other_width_of_each_group_once() {
    for grid in [Widths::HAND, Widths::DRILL_STRING] {
        let centre: Set = TAKEN.map(|group| (group % grid.count[group]) as u8);
        let mut sets: Vec<Set> = (0..).map_while(|index| grid.near(&centre, index)).collect();
        assert_eq!(sets[0], centre);
        assert!(sets.iter().all(|set| are_near(set, &centre)));
        assert!(sets.iter().all(|set| TAKEN.iter().zip(set).all(|(g, width)| usize::from(*width) < grid.count[*g])));
        let shared = sets.iter().take_while(|set| set[..SHARED] == centre[..SHARED]).count();
        assert_eq!(shared, 1 + TAKEN[SHARED..].iter().map(|group| grid.count[*group] - 1).sum::<usize>());
        sets.sort_unstable();
        sets.dedup();
        assert_eq!(sets.len(), 1 + grid.count.iter().map(|count| count - 1).sum::<usize>());
    }
}

#[test]
fn the_data_sheets_widths_come_first() {
    for grid in [Widths::HAND, Widths::DRILL_STRING] {
        assert!((0..GROUPS).all(|group| grid.parts[group][0] == grid.sheet[group]));
    }
}

#[test]
fn every_variable_is_another_column() {
    let mut columns: Vec<usize> = (0..VARIABLES).map(column).collect();
    columns.sort_unstable();
    columns.dedup();
    assert_eq!(columns.len(), VARIABLES);
    assert_eq!([column(0), column(11), column(VARIABLES - 1)], [28, 27, 12]);
    assert_eq!(LEFT_AFTER[GROUPS - 1], 12);
}
