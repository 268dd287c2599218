extern crate std;
use super::*;
use std::string::ToString;

#[test]
fn what_is_displayed_is_read() {
    let id = ProbeId::of_words([0x0403_0201, 0x0807_0605, 0xfc0b_0a09]);
    assert_eq!(id.to_string(), "0102030405060708090a0bfc");
    assert_eq!(ProbeId::of_digits(&id.to_string()), Some(id));
    for bad in ["", "01", "0102030405060708090a0bf", "0102030405060708090a0bfg", "0102030405060708090a0b0c0d"] {
        assert_eq!(ProbeId::of_digits(bad), None, "{bad}");
    }
}
