use super::*;

#[test]
fn groups_follow_one_another_and_fill_the_table() {
    let end = TABLE.iter().fold(0, |next, group| {
        assert_eq!(group.from, next, "{}", group.name);
        next + group.count
    });
    assert_eq!((end, BIAS.from), (GLOBALS, NUISANCES));
}
