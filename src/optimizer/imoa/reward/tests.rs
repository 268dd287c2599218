use super::*;
use rand_core::SeedableRng;

#[test]
fn three_costs_give_the_bottom_of_a_parabola_and_else_the_lowest_of_them() {
    let parabola = |x: f32| 5.0 + 3.0 * (x - 0.7) * (x - 0.7);
    for (a, b) in [(1.0, -1.0), (0.5, 1.0), (-0.25, -0.5)] {
        let (found, slope) = lowest(parabola(0.0), (a, parabola(a)), (b, parabola(b)));
        assert!((found - 0.7).abs() < 1e-5, "{a} {b}: {found}");
        assert!((slope + 4.2).abs() < 1e-4, "{a} {b}: {slope}");
    }
    let lowest = |cost, a, b| super::lowest(cost, a, b).0;
    // Beyond the reach, straight, or opening downwards.
    assert_eq!(lowest(parabola(0.0), (0.05, parabola(0.05)), (-0.05, parabola(-0.05))), 8.0 * 0.05);
    assert_eq!(lowest(2.0, (1.0, 1.0), (-1.0, 3.0)), 1.0);
    assert_eq!(lowest(2.0, (1.0, 1.5), (-1.0, 1.0)), -1.0);
    assert_eq!(lowest(2.0, (1.0, 3.0), (-1.0, f32::INFINITY)), 0.0);
    assert_eq!(lowest(2.0, (1.0, f32::INFINITY), (-1.0, 1.0)), -1.0);
    assert_eq!(lowest(f32::INFINITY, (1.0, f32::INFINITY), (-1.0, f32::INFINITY)), 0.0);
    // No room between the trials.
    assert_eq!(lowest(2.0, (0.0, 2.0), (0.0, 2.0)), 0.0);
}

/// A member moves only in variables that its partner wins, and never past the partner.
#[test]
fn points_move_a_member_towards_its_partner_where_the_partner_is_better() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
    let (member, partner) = ([0.0, 0.1, -0.4, 0.2], [1.0, 0.5, 0.6, -0.8]);
    let out = freely_exchanged(&member, &partner, &[0.9, 0.0, 0.6, -0.1], &mut generator);
    for (k, won) in [true, false, true, false].into_iter().enumerate() {
        // Two of four have won, so at most half the way is gone.
        let way = (out[k] - member[k]) / (partner[k] - member[k]);
        assert!(if won { way > 0.0 && way < 0.5 } else { way == 0.0 }, "{k}: {way}");
    }
}
