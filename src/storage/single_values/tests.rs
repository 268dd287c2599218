//! A value of one copy counts, and is settled by two in a row.

use super::*;

#[test]
fn a_value_of_one_copy_counts_and_is_written_anew_before_anything_is_erased() {
    let mut counter = Rising::NONE;
    assert_eq!((counter.value(), counter.unsettled(None)), (None, None));
    (0..2).for_each(|_| counter.note(7, 0));
    assert_eq!((counter.value(), counter.unsettled(None), counter.unsettled(Some(1))), (Some(7), None, None));
    assert_eq!(counter.unsettled(Some(0)), Some(7));
    // Cut off after the first copy, in another sector.
    counter.note(8, 1);
    assert_eq!((counter.value(), counter.unsettled(None)), (Some(8), Some(8)));
    // A copy in each of two sectors is no pair in one: each may have been cut off.
    counter.note(8, 2);
    assert_eq!(counter.unsettled(None), Some(8));
    counter.note(8, 2);
    assert_eq!((counter.unsettled(None), counter.unsettled(Some(2))), (None, Some(8)));
    // A lower value that is found later changes nothing.
    (0..2).for_each(|_| counter.note(5, 1));
    assert_eq!((counter.value(), counter.unsettled(None)), (Some(8), None));
}

/// Every order in which up to six copies of three values can be found in two sectors.
#[test]
fn a_rising_value_is_the_highest_noted_and_settled_by_two_copies_in_a_row() {
    const CHOICES: u32 = 6;
    let length = if cfg!(miri) { 3 } else { 6 };
    for mut order in 0..CHOICES.pow(length) {
        let (mut rising, mut highest, mut before) = (Rising::NONE, None, None);
        // True once two copies of the highest value were noted one after the other in one sector.
        let mut is_settled = false;
        for _ in 0..length {
            let (value, sector) = (u64::from(order % 3), (order / 3 % 2) as u8);
            order /= CHOICES;
            rising.note(value, sector);
            if highest < Some(value) {
                (highest, is_settled) = (Some(value), false);
            }
            is_settled |= highest == Some(value) && before == Some((value, sector));
            before = Some((value, sector));
            assert_eq!(rising.value(), highest);
            assert_eq!(rising.unsettled(None), highest.filter(|_| !is_settled), "{rising:?}");
        }
    }
}
