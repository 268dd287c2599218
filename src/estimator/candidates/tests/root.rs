//! The root of the effects is that of the whole least-squares problem.

extern crate std;

use super::{
    super::{Candidates, column_id::ColumnId, evidence::Evidence},
    E, GLOBAL, GLOBALS, Globals, Known, LAGS, NODE, ROWS, Row, STEP, STEPS_FROM, TWISTS, USED, deviate,
};
use crate::estimator::{
    columns::BIAS,
    node::Node,
    real::{M3, V3, identity, rotation, rotation_vector},
    rows::{CONSTANT, NEW, SCRATCH, WIDTH},
};
use nalgebra::{SMatrix, SVector};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{boxed::Box, vec::Vec};

/// Globals and effects, and a constant.
const BOTH: usize = GLOBALS + E;
/// Nodes of the test of the elimination, and all their unknowns.
const NODES: usize = 3;
const STATES: usize = NODE * (NODES + 1);
const ALL: usize = STATES + BOTH + 1;

type Information = SMatrix<f64, BOTH, BOTH>;

/// The rows that the filter holds of globals and effects.
fn extended(globals: &Globals<f64>, candidates: &Candidates<f64, E>) -> SMatrix<f64, BOTH, { BOTH + 1 }> {
    SMatrix::from_fn(|i, j| match (i.checked_sub(GLOBALS), j.checked_sub(GLOBALS)) {
        (None, None) => globals.root[i][j],
        (None, Some(E)) => globals.root[i][GLOBALS],
        (None, Some(e)) => candidates.root.globals[i][e],
        (Some(_), None) => 0.0,
        (Some(row), Some(E)) => candidates.root.constants[row],
        (Some(row), Some(e)) => candidates.root.own[row][e],
    })
}

fn information(globals: &Globals<f64>, candidates: &Candidates<f64, E>) -> Information {
    let rows = extended(globals, candidates);
    let root = rows.fixed_columns::<BOTH>(0);
    root.transpose() * root
}

/// Where the optimum of globals and effects is.
fn optimum(globals: &Globals<f64>, candidates: &Candidates<f64, E>) -> SVector<f64, BOTH> {
    let rows = extended(globals, candidates);
    let root = rows.fixed_columns::<BOTH>(0);
    let x = SVector::from_fn(|i, _| if i < GLOBALS { globals.x[i] } else { candidates.root.x[i - GLOBALS] });
    let pull = root.transpose() * rows.column(BOTH);
    x - (root.transpose() * root).cholesky().unwrap().solve(&pull)
}

/// After a number of random rows.
fn learnt(seed: u64, rows: usize) -> (Known, Xoshiro128PlusPlus) {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut known = Known::new();
    let rows: Vec<_> = (0..rows).map(|_| Row::random(&mut generator)).collect();
    known.learn(&rows);
    (known, generator)
}

#[test]
fn the_root_holds_the_information_of_all_rows_when_the_states_are_gone() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
    let mut known = Box::new(Known::new());
    let mut normal = Box::new(SMatrix::<f64, ALL, ALL>::zeros());
    let mut add = |row: &[f64; WIDTH], further: &[f64; E], node: usize| {
        let mut wide = SVector::<f64, ALL>::zeros();
        for (c, x) in row.iter().enumerate() {
            let states = if c < GLOBAL { node * NODE + c } else { STATES + c - GLOBAL };
            wide[if c == CONSTANT { ALL - 1 } else { states }] = *x;
        }
        further.iter().enumerate().for_each(|(e, x)| wide[STATES + GLOBALS + e] = *x);
        normal.ger(1.0, &wide, &wide, 1.0);
    };
    // The priors.
    for i in 0..BOTH {
        let (mut row, mut further) = ([0.0; WIDTH], [0.0; E]);
        if i < GLOBALS {
            row[GLOBAL + i] = 1.0
        } else {
            further[i - GLOBALS] = 1.0
        }
        add(&row, &further, 0);
    }
    let mut innovation = 0.0;
    for node in 0..NODES {
        let kept = (known.rows, known.further);
        (known.rows, known.further) = ([[0.0; WIDTH]; SCRATCH], [[0.0; E]; SCRATCH]);
        for i in 0..NODE + ROWS {
            let row = Row::random(&mut generator);
            known.rows[i][GLOBAL..CONSTANT].copy_from_slice(&row.globals);
            known.rows[i][CONSTANT] = row.constant;
            known.further[i] = row.effects;
            let states = if i < NODE { i..NODE } else { 0..GLOBAL };
            states.for_each(|c| known.rows[i][c] = deviate(&mut generator));
        }
        for i in 0..NODE {
            if node > 0 {
                known.rows[i] = [0.0; WIDTH];
                known.rows[i][..NODE].copy_from_slice(&kept.0[NODE + i][NEW..NEW + NODE]);
                known.rows[i][GLOBAL..].copy_from_slice(&kept.0[NODE + i][GLOBAL..]);
                known.further[i] = known.candidates.root.node[i];
            } else {
                add(&known.rows[i], &known.further[i], 0);
            }
        }
        (NODE..NODE + ROWS).for_each(|i| add(&known.rows[i], &known.further[i], node));
        for column in (0..2 * NODE).step_by(2) {
            let Known { candidates, rows, further, .. } = known.as_mut();
            candidates.eliminate(further, rows, column);
        }
        innovation += known.absorb();
        let further = known.further;
        known.candidates.finish(&further);
    }
    // The last node's states are eliminated as well, so the globals have all that is in them.
    let states = normal.fixed_view::<STATES, STATES>(0, 0).into_owned().cholesky().unwrap();
    let cross = normal.fixed_view::<STATES, { BOTH + 1 }>(0, STATES).into_owned();
    let expected =
        normal.fixed_view::<{ BOTH + 1 }, { BOTH + 1 }>(STATES, STATES) - cross.transpose() * states.solve(&cross);
    let rows = extended(&known.globals, &known.candidates);
    let mut found = rows.transpose() * rows;
    found[(BOTH, BOTH)] += innovation;
    assert!((found - expected).amax() < 1e-9 * expected.amax(), "{}", (found - expected).amax());
    for (i, row) in known.candidates.root.own.iter().enumerate() {
        assert!(row.iter().take(i).all(|x| *x == 0.0), "row {i}");
    }
    // A column that is not in use keeps its prior.
    assert!(known.candidates.root.own[USED][USED] == 1.0);
}

#[test]
fn taking_out_moves_globals_and_node_and_leaves_the_optimum_where_it_was() {
    let (mut known, mut generator) = learnt(2, 80);
    let mut node = Node::<f64>::zero();
    node.attitude = identity();
    for (i, row) in node.root.iter_mut().enumerate() {
        row.iter_mut().skip(i).for_each(|x| *x = 0.1 * deviate(&mut generator));
        row[i] = 30.0;
    }
    for x in known.candidates.root.node.as_flattened_mut() {
        *x = deviate(&mut generator);
    }
    // Where the node's states are best, with globals and effects at their optimum.
    let best = |known: &Known, node: &Node<f64>| {
        let by = optimum(&known.globals, &known.candidates);
        let right = SVector::<f64, NODE>::from_fn(|i, _| {
            let of_globals = (0..GLOBALS).map(|c| node.root[i][NODE + c] * (by[c] - known.globals.x[c])).sum::<f64>();
            let change = |e: usize| by[GLOBALS + e] - known.candidates.root.x[e];
            -of_globals - (0..E).map(|e| known.candidates.root.node[i][e] * change(e)).sum::<f64>()
        });
        let root = SMatrix::<f64, NODE, NODE>::from_fn(|i, j| node.root[i][j]);
        let turned = rotation_vector(&node.attitude);
        let states = [turned, node.velocity, node.position, node.field];
        root.solve_upper_triangular(&right).unwrap() + SVector::from_fn(|i, _| states[i / 3][i % 3])
    };
    let (before, of_node, informed) = (
        optimum(&known.globals, &known.candidates),
        best(&known, &node),
        information(&known.globals, &known.candidates),
    );
    let mut x = [0.0; E];
    [(0, 0.7), (LAGS, -0.4), (TWISTS, 0.3)].into_iter().for_each(|(e, value)| x[e] = value);
    known.candidates.take_out(&x, &mut known.globals, &mut node);
    assert_eq!(known.candidates.root.x, x);
    assert!((optimum(&known.globals, &known.candidates) - before).amax() < 1e-10);
    // The earth frame has turned in the place of the heading, which a tilt moves by its square.
    let after = best(&known, &node);
    let turn = rotation(&V3::new(0.0, 0.0, of_node[2] - after[2]));
    for (k, state) in [node.velocity, node.position, node.field].iter().enumerate() {
        let off =
            after.fixed_rows::<3>(3 + 3 * k) + (turn - identity::<f64>()) * state - of_node.fixed_rows::<3>(3 + 3 * k);
        assert!(off.amax() < 1e-6, "{k}: {off}");
    }
    // A turn by 20 mrad is no sum.
    assert!((after - of_node).rows(0, 2).amax() < 1e-3);
    assert!((information(&known.globals, &known.candidates) - informed).amax() == 0.0);

    // At the joint optimum nothing pulls any more.
    let x = core::array::from_fn(|e| before[GLOBALS + e]);
    known.candidates.take_out(&x, &mut known.globals, &mut node);
    assert!(known.candidates.root.constants.iter().all(|x| x.abs() < 1e-10), "{:?}", known.candidates.root.constants);
    for (found, best) in known.globals.x.iter().zip(before.iter()) {
        assert!((found - best).abs() < 1e-10);
    }
}

/// With some columns at their optimum and the others at zero, only the others are pulled.
#[test]
fn what_is_taken_out_at_its_optimum_is_not_pulled() {
    let (mut known, _) = learnt(3, 80);
    let taken = [0, 1, LAGS, TWISTS];
    let of = |c: usize| if c < GLOBALS { c } else { GLOBALS + taken[c - GLOBALS] };
    let rows = extended(&known.globals, &known.candidates);
    let some = SMatrix::<f64, BOTH, { GLOBALS + 4 }>::from_fn(|i, c| rows[(i, of(c))]);
    let best = -(some.transpose() * some).cholesky().unwrap().solve(&(some.transpose() * rows.column(BOTH)));
    let mut x = [0.0; E];
    taken.iter().enumerate().for_each(|(k, e)| x[*e] = best[GLOBALS + k]);
    known.candidates.take_out(&x, &mut known.globals, &mut Node::zero());
    let rows = extended(&known.globals, &known.candidates);
    let pull = rows.fixed_columns::<BOTH>(0).transpose() * rows.column(BOTH);
    assert!((0..GLOBALS + 4).all(|c| pull[of(c)].abs() < 1e-9), "{pull}");
    assert!(pull.amax() > 1.0);
}

#[test]
fn a_step_that_is_dropped_leaves_all_else_and_has_its_prior() {
    for step in 0..3 {
        let (mut known, _) = learnt(4 + u64::from(step), 80);
        let columns = STEPS_FROM + 3 * usize::from(step)..STEPS_FROM + 3 * usize::from(step) + 3;
        let mut x = [0.0; E];
        x[LAGS] = 0.5;
        columns.clone().for_each(|e| x[e] = 0.2);
        known.candidates.take_out(&x, &mut known.globals, &mut Node::zero());
        // The means stay where they are: what the step was is the bias's from now on.
        let mut before = extended(&known.globals, &known.candidates);
        columns.clone().for_each(|e| before.column_mut(GLOBALS + e).fill(0.0));
        let mut expected = before.transpose() * before;
        columns.clone().for_each(|e| expected[(GLOBALS + e, GLOBALS + e)] = 1.0);
        known.candidates.drop_step(step);
        let rows = extended(&known.globals, &known.candidates);
        let mut found = rows.transpose() * rows;
        // Except for the constant that no column can explain any more.
        found[(BOTH, BOTH)] = expected[(BOTH, BOTH)];
        assert!((found - expected).amax() < 1e-10, "{}", (found - expected).amax());
        for (e, x) in x.iter().enumerate() {
            assert_eq!(known.candidates.root.x[e], if columns.contains(&e) { 0.0 } else { *x });
        }
        assert!(known.candidates.root.node.iter().all(|row| columns.clone().all(|e| row[e] == 0.0)));
        for (i, row) in known.candidates.root.own.iter().enumerate() {
            assert!(row.iter().take(i).all(|x| x.abs() < 1e-12), "row {i}");
        }
    }
}

#[test]
fn process_noise_of_a_global_is_added_to_its_variance_and_to_no_other() {
    let (mut known, _) = learnt(8, 80);
    let inverse = |known: &Known| information(&known.globals, &known.candidates).try_inverse().unwrap();
    let mut expected = inverse(&known);
    for (global, variance) in [(3, 0.7), (25, 0.01), (36, 4.0)] {
        known.candidates.add_process_noise(&mut known.globals, global, variance);
        expected[(global, global)] += variance;
    }
    (0..GLOBALS).for_each(|column| known.candidates.triangular(&mut known.globals, column));
    assert!((inverse(&known) - expected).amax() < 1e-11);
    assert!(known.globals.root.iter().enumerate().all(|(i, row)| row.iter().take(i).all(|x| *x == 0.0)));
}

/// The covariance of the globals is that of a model in which what is taken out is unknown as well. The bias that flies
/// has its step in it.
#[test]
fn what_is_not_known_of_what_is_taken_out_spreads_to_the_globals() {
    let (known, mut generator) = learnt(9, 60);
    let taken = [1, LAGS, TWISTS, STEPS_FROM, STEPS_FROM + 1, STEPS_FROM + 2];
    let of = |c: usize| if c < GLOBALS { c } else { GLOBALS + taken[c - GLOBALS] };
    let rows = extended(&known.globals, &known.candidates);
    let some = SMatrix::<f64, BOTH, { GLOBALS + 6 }>::from_fn(|i, c| rows[(i, of(c))]);
    let covariance = (some.transpose() * some).try_inverse().unwrap();
    let mut evidence = Evidence::<f64>::zero();
    for (i, e) in taken.iter().enumerate() {
        evidence.account.taken.push(ColumnId::of_effect(*e)).unwrap();
        (0..=i).for_each(|j| evidence.account.covariance[i * (i + 1) / 2 + j] = covariance[(GLOBALS + i, GLOBALS + j)]);
    }
    let inverse = M3::from_fn(|_, _| deviate(&mut generator));
    let sigma: [f64; GLOBALS] = core::array::from_fn(|c| 0.1 + 0.01 * c as f64);
    let root = SMatrix::<f64, GLOBALS, GLOBALS>::from_fn(|i, j| known.globals.root[i][j]);
    let mut found = (root.transpose() * root).try_inverse().unwrap();
    for of in 0..taken.len() {
        let taken = (evidence.account.taken.as_slice(), evidence.account.covariance.as_slice());
        let by = SVector::from(known.candidates.inflation(of, taken, &known.globals, (&inverse, &sigma)));
        found += by * by.transpose();
    }
    // The globals fly, and in the bias the step that P turns back.
    let mut flown = SMatrix::<f64, GLOBALS, { GLOBALS + 6 }>::identity();
    let usual = f64::from(STEP.parameters[0].usual);
    for (k, b) in BIAS.columns().enumerate() {
        (0..3).for_each(|axis| flown[(b, GLOBALS + 3 + axis)] = inverse[(k, axis)] * usual / sigma[b]);
    }
    let expected = flown * covariance * flown.transpose();
    assert!((found - expected).amax() < 1e-11 * expected.amax(), "{}", (found - expected).amax());
}
