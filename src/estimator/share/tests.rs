use super::*;

#[test]
fn it_is_the_mean_from_the_first_second_on_and_forgets_what_is_long_ago() {
    let mut share = Share::<f64>::zero();
    share.add(1.0, 0.5);
    assert_eq!(share.get(), 1.0);
    share.add(0.0, 1.5);
    assert_eq!(share.get(), 0.25);
    (0..400).for_each(|_| share.add(1.0, 0.5));
    assert!(share.get() > 0.95);
    share.add(0.0, 60.0);
    assert_eq!(share.get(), 0.0);
}
