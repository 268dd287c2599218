//! A new alignment after a gap.

use super::*;

/// After a long rest the field is known far better than in motion.
#[test]
fn after_a_gap_the_field_is_known_no_better_than_it_may_have_walked() {
    for known in [300.0, 3_000.0, 30_000.0] {
        let mut node = Node::<f64>::zero();
        let force = V3::new(0.0, 0.0, 9.81);
        node.start(&force, &Noise::HAND);
        node.has_field = true;
        node.field = V3::new(0.0, 0.4, -0.9);
        (FIELD..FIELD + 3).for_each(|i| node.root[i][i] = known);
        let gap_s = 100.0;
        let walked = f64::from(Noise::HAND.field_walk_rts) * libm::sqrt(gap_s);
        assert!(node.realign(&force, &V3::new(0.0, 0.4, -0.9), gap_s, &Noise::HAND).is_some());
        let deviation = 1.0 / node.root[FIELD][FIELD].abs();
        assert!(
            deviation >= libm::sqrt(walked * walked + 1.0 / (known * known)) * 0.999,
            "{known}: {deviation} {walked}"
        );
        assert!(deviation < 2.0 * walked + 1.0 / known, "{known}: {deviation} {walked}");
    }
}
