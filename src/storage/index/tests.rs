//! The index keeps what counts, in whatever order it is found.

use super::*;

const PLACE: Place = Place { sector: 0, granule: 1 };

#[test]
fn the_nearest_temperature_is_chosen_and_of_equals_the_newest() {
    let mut index = Index::empty();
    for (number, t) in [(1, 20.0), (2, 60.0), (3, 100.0), (4, 62.0)] {
        index.keep(number, PLACE, Some([t, t + 5.0]), true);
    }
    index.keep(5, PLACE, None, true);
    index.keep(6, PLACE, Some([100.0, 105.0]), false);
    let chosen = |t: Option<f32>| index.nearest(t).map(|slot| slot.number);
    assert_eq!(chosen(Some(21.0)), Some(1));
    assert_eq!(chosen(Some(-40.0)), Some(1));
    assert_eq!(chosen(Some(64.0)), Some(4), "2 is of the same band and older");
    assert_eq!(chosen(Some(170.0)), Some(3));
    assert_eq!(chosen(None), Some(5));
    // 105 is in no range; 100 to 105 is no farther than a band.
    assert_eq!(chosen(Some(114.0)), Some(3));
}

#[test]
fn what_is_kept_does_not_depend_on_the_order() {
    let models: [(u32, f32); 14] = core::array::from_fn(|i| (i as u32 + 1, ((i * 7) % 11) as f32 * 11.0));
    let kept = |order: &dyn Fn(usize) -> usize| {
        let mut index = Index::empty();
        for i in 0..models.len() {
            let (number, t) = models[order(i)];
            index.keep(number, PLACE, Some([t, t]), number % 4 != 0);
        }
        let mut numbers = index.kept.map(|slot| slot.map(|slot| slot.number));
        numbers.sort_unstable();
        numbers
    };
    let forwards = kept(&|i| i);
    assert_eq!(forwards, kept(&|i| 13 - i));
    assert_eq!(forwards, kept(&|i| (i * 5 + 3) % 14));
}

/// Every other one of fourteen models, each of another temperature, may fly.
#[test]
fn a_model_that_may_not_fly_takes_the_place_of_none_that_may() {
    let mut index = Index::empty();
    for number in 1..=14 {
        index.keep(number, PLACE, Some([20.0 * number as f32; 2]), number % 2 == 0);
    }
    let mut numbers = index.kept.map(|slot| slot.map(|slot| slot.number));
    numbers.sort_unstable();
    assert_eq!(numbers, [2, 4, 6, 8, 10, 12, 13, 14].map(Some));
    assert_eq!(index.flyable().count(), 7);
}
