//! The index keeps what counts, in whatever order it is found.

use super::*;

const PLACE: Place = Place { sector: 0, granule: 1 };

#[test]
fn the_nearest_temperature_is_chosen_and_of_equals_the_newest() {
    let mut index = Index::empty();
    for (number, t) in [(1, 20.0), (2, 60.0), (3, 100.0), (4, 62.0)] {
        index.keep(number, PLACE, Some([t, t + 5.0]));
    }
    index.keep(5, PLACE, None);
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
            index.keep(number, PLACE, Some([t, t]));
        }
        let mut numbers = index.kept.map(|slot| slot.map(|slot| slot.number));
        numbers.sort_unstable();
        numbers
    };
    let forwards = kept(&|i| i);
    assert_eq!(forwards, kept(&|i| 13 - i));
    assert_eq!(forwards, kept(&|i| (i * 5 + 3) % 14));
}
