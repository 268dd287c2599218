extern crate std;
use super::*;

#[test]
fn a_number_means_one_kind() {
    let known: std::vec::Vec<u8> = (0..=255).filter(|&number| Kind::of_number(number).is_some()).collect();
    assert_eq!(known.len(), 18);
    assert!(known.iter().all(|&number| Kind::of_number(number).map(Kind::number) == Some(number)));
}
