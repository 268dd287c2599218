use super::*;

const RATE: Rate = Rate { interval_us: 1_000, at_once: 3 };

#[test]
fn some_can_be_had_at_once_and_then_one_with_each_interval() {
    let mut allowance = Allowance::new();
    let had = |allowance: &mut Allowance, now_us| (0..10).filter(|_| allowance.take(&RATE, now_us)).count();
    assert_eq!([0, 0, 999, 1_000, 3_500, 9_000].map(|now_us| had(&mut allowance, now_us)), [3, 0, 0, 1, 2, 3]);
    // The whole allowance is there again on a clock that has gone back.
    let mut allowance = Allowance::new();
    assert_eq!([9_000, 20].map(|now_us| had(&mut allowance, now_us)), [3, 3]);
    // Over a long time no more answers than the rate allows, however often one is asked for.
    let mut allowance = Allowance::new();
    let all = (0..100_000).filter(|now_us| allowance.take(&RATE, *now_us)).count();
    assert_eq!(all, 3 + 99);
}
