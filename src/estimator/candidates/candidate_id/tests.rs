use super::{super::MAX_CANDIDATES, *};

#[test]
fn a_set_holds_every_candidate_and_only_those_that_were_put_in() {
    for (a, b) in [(0, 1), (31, 5), (MAX_CANDIDATES - 1, 0)].map(|(a, b)| (CandidateId::new(a), CandidateId::new(b))) {
        let mut set = CandidateSet::EMPTY;
        set.insert(a);
        assert!(set.has(a) && !set.has(b) && set.bits() == 1 << a.number());
        set.insert(b);
        set.remove(a);
        assert!(!set.has(a) && set.has(b));
    }
    // A number that has no bit is no other's.
    let mut set = CandidateSet::EMPTY;
    set.insert(CandidateId::new(MAX_CANDIDATES));
    assert_eq!(set, CandidateSet::EMPTY);
}
