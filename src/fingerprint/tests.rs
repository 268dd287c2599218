use super::*;

/// Values of the authors of the hash (draft-eastlake-fnv, appendix C).
#[test]
fn the_hash_is_fnv_1a() {
    for (text, hash) in [("", 0x811C_9DC5), ("a", 0xE40C_292C), ("foobar", 0xBF9C_F968)] {
        let mut print = Fingerprint::new();
        print.bytes(text.as_bytes());
        assert_eq!(print.value(), hash, "{text}");
    }
    let mut print = Fingerprint::new();
    print.numbers(&[1.5, -2.0]);
    let mut same = Fingerprint::new();
    same.bytes(&[0, 0, 0xC0, 0x3F, 0, 0, 0, 0xC0]);
    assert_eq!(print.value(), same.value());
}
