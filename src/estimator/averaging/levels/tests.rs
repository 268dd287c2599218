use super::*;
use crate::estimator::update::Update;

#[test]
fn the_rows_of_an_update_have_room_for_all_levels() {
    let mut update = Update::<f32>::zero();
    let needed = |variables: usize| variables + triangle(variables);
    let all = 2 * needed(VARIABLES) + needed(LEFT_AFTER[SHARED - 1]);
    let scratch = update.rows.as_flattened_mut();
    assert!(scratch.get_mut(..all).is_some_and(|enough| Levels::cut(enough).is_some()));
    assert!(scratch.get_mut(..all - 1).is_some_and(|few| Levels::cut(few).is_none()));
}
