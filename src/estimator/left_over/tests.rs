#![allow(clippy::indexing_slicing)]
use super::*;

#[test]
fn constants_are_those_at_the_priors_mean_and_the_oldest_node_goes() {
    const NODES: usize = 7;
    let mut ring = LeftOver::<NODES>::zero();
    let mut x = [0.0_f64; GLOBALS];
    (x[P.from + 2], x[BIAS.from]) = (0.5, -1.0);
    for node in 0..NODES + 3 {
        let mut left = [[0.0_f64; WIDTH]; ROWS];
        left[4][GLOBAL + P.from + 2] = 10.0;
        left[4][GLOBAL + BIAS.from] = 4.0;
        left[4][WIDTH - 1] = node as f64;
        ring.push(&left, &x);
    }
    assert_eq!(ring.count(), NODES);
    let mut at = [0.0; 12];
    (at[2], at[9]) = (0.5, -1.0);
    for (index, node) in [(0, NODES), (2, NODES + 2), (3, 3), (NODES - 1, NODES - 1)] {
        let innovations = ring.innovations(index, &at);
        let square: f32 = innovations.iter().map(|x| x * x).sum();
        assert!((libm::sqrtf(square) - node as f32).abs() < 0.01 * (1.0 + node as f32), "{index}: {square}");
        let rows = ring.node(index);
        let at_mean: f32 = rows.iter().map(|row| row[12] * row[12]).sum();
        assert!((libm::sqrtf(at_mean) - (node as f32 - 1.0).abs()).abs() < 0.01 * (1.0 + node as f32));
    }
}
