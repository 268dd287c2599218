//! The effects' part of a node's rows is the derivative of the rows.

extern crate std;

use super::{EFFECTS, LIBRARY, deviate, shake};
use crate::{
    config::Config,
    estimator::{
        Settings,
        candidates::Candidates,
        columns::{ATTITUDE, FIELD, NODE, POSITION, VELOCITY},
        globals::Globals,
        increment::Increment,
        node::{Kind, Node},
        parameters::Parameters,
        preintegration::Preintegration,
        reading::Taken,
        real::{M3, V3, rotation, rotation_vector, zero3},
        rows::{CONSTANT, NEW, OLD, ROWS, SCRATCH},
        update::Update,
    },
};
use core::ops::Range;
use nalgebra::{SMatrix, SVector};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{boxed::Box, vec::Vec};

const FIELD_UT: f64 = 50.0;
/// By how much an effect is moved, in units of its usual size.
const STEP: f64 = 1e-4;
/// First rows of the field that was read, and of a rest.
const SEEN: usize = NODE + 3;
const STILL: usize = NODE + 21;

/// A node in which everything changes, at rates about so large, and the filter before it.
struct Setting {
    candidates: Box<Candidates<f64, EFFECTS>>,
    increments: Vec<(Increment<f64>, V3<f64>)>,
    node: Node<f64>,
    settings: Settings,
    kind: Kind,
}

/// A node's rows, the effects' part of them, and where its end was predicted.
struct Rows {
    rows: Box<Update<f64>>,
    further: Box<[[f64; EFFECTS]; SCRATCH]>,
    attitude: M3<f64>,
    velocity: V3<f64>,
    position: V3<f64>,
}

impl Setting {
    fn new(seed: u64, kind: Kind, rates: f64) -> Self {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut vector = || V3::<f64>::from_fn(|_, _| deviate(&mut generator));
        let mut candidates = Box::new(Candidates::zero());
        candidates.configure(&LIBRARY);
        // Three shocks before it, so that there can be as many steps.
        let mut now_us = 0;
        for _ in 0..3 {
            shake(&mut candidates.shocks, &mut now_us, 10, || 12.0);
            shake(&mut candidates.shocks, &mut now_us, 1, || 300.0);
            candidates.begin_step(now_us, 200.0);
        }
        let mut node = Node::zero();
        node.attitude = rotation(&vector());
        (node.velocity, node.position) = (vector() * 0.1, vector() * 0.1);
        node.root.iter_mut().enumerate().for_each(|(i, row)| row[i] = 3.0);
        let (mut rate, force) = (vector() * rates, node.attitude.transpose() * V3::new(0.0, 0.0, 9.81));
        let field = vector();
        let field = field / field.norm();
        let increments = (1..13).map(|k| {
            let rate_change = vector() * 3.0 * rates;
            rate += rate_change * 0.04;
            // Vectors as they would be read, but for some errors.
            let turned = rotation(&(rate * (-0.04 * k as f64)));
            let (force, field) = (turned * force + vector() * 0.2, turned * field + vector() * 0.01);
            let increment = Increment {
                end_us: now_us + 40_000 * k,
                seconds: 0.04,
                rate,
                force: Some(force),
                field: Some(field),
                vibration: 0.1,
                mean_rate: rate,
                rate_variance: zero3(),
                square_force: force.norm_squared() + 3.0,
                peak: 12.0,
                warming_k: Some(30.0),
                unread_turn: 0.0,
                unread_velocity: 0.0,
            };
            (increment, rate_change)
        });
        let increments = increments.collect();
        let config = Config { sample_period_us: 10_000, ..Config::default() };
        Self { candidates, increments, node, settings: Settings::new(&config), kind }
    }

    /// Rows of the node with this taken out.
    fn rows(&mut self, x: &[f64; EFFECTS]) -> Rows {
        let p = M3::new(1.1, 0.02, -0.03, 0.01, 0.94, 0.04, -0.02, 0.03, 1.05);
        let parameters = Parameters::new(&[0.0; 37], &zero3(), p);
        self.candidates.root.x = *x;
        self.candidates.start_node();
        let mut pre = Preintegration::zero();
        pre.start();
        for (increment, rate_change) in &self.increments {
            let (out, _) = self.candidates.look_at(increment, rate_change, FIELD_UT, &parameters);
            let turned = pre.add(increment, &zero3(), None, &parameters, &out);
            self.candidates.add(&turned);
        }
        if !self.node.has_field {
            self.node.field = self.node.attitude * pre.field / f64::from(pre.fields);
            self.node.has_field = true;
        }
        let (mut globals, mut update) = (Globals::zero(), Box::new(Update::zero()));
        globals.start();
        let taken = Taken {
            pre: &pre,
            parameters: &parameters,
            globals: &globals,
            settings: &self.settings,
            field_unit: 1.0,
            sigma: &self.settings.sigma.map(f64::from),
            unknown: 1e-6,
            kind: self.kind,
        };
        let mut node = self.node;
        update.assemble(&mut node, &taken);
        let mut further = Box::new([[0.0; EFFECTS]; SCRATCH]);
        let at_rest = (self.kind == Kind::Rest).then(|| parameters.inverse());
        self.candidates.fill(&mut further, &update.rows, &node.attitude, &pre, at_rest.as_ref());
        let at_node = self.node.attitude;
        let (velocity, position) = (at_node * pre.velocity.value, at_node * pre.position.value);
        Rows { rows: update, further, attitude: at_node * pre.rotation, velocity, position }
    }
}

/// The constants of the new rows with the weights of other ones: the noise of a field that fits worse is larger.
fn constants(rows: &Rows, as_weighted: &Rows) -> SVector<f64, ROWS> {
    SVector::from_fn(|i, _| {
        let (row, then) = (&rows.rows.rows[NODE + i], &as_weighted.rows.rows[NODE + i]);
        let is_seen = (SEEN..SEEN + 3).contains(&(NODE + i));
        let column = OLD + FIELD + i % 3;
        row[CONSTANT] * if is_seen { then[column] / row[column] } else { 1.0 }
    })
}

/// Largest error of a column of the effects in some of the new rows, of its length there, by differences of the rows
/// themselves.
fn largest_error(setting: &mut Setting, of: Range<usize>) -> (f64, &'static str) {
    let now = setting.rows(&[0.0; EFFECTS]);
    let mut most = (0.0, "");
    let count = setting.candidates.places().len();
    for e in 0..count {
        let mut x = [0.0; EFFECTS];
        x[e] = STEP;
        let more = setting.rows(&x);
        x[e] = -STEP;
        let less = setting.rows(&x);
        let per = 0.5 / STEP;
        // The rows' unknowns are changes from the prediction, and that has moved.
        let turned = rotation_vector(&(more.attitude * less.attitude.transpose())) * per;
        let states = [
            (ATTITUDE, turned),
            (VELOCITY, (more.velocity - less.velocity) * per),
            (POSITION, (more.position - less.position) * per),
        ];
        let mut moved = SVector::<f64, NODE>::zeros();
        states.iter().for_each(|(from, by)| moved.fixed_rows_mut::<3>(*from).copy_from(by));
        let by_states = SMatrix::<f64, ROWS, NODE>::from_fn(|i, c| now.rows.rows[NODE + i][NEW + c]);
        let expected = (constants(&more, &now) - constants(&less, &now)) * per - by_states * moved;
        let found = SVector::<f64, ROWS>::from_fn(|i, _| now.further[NODE + i][e]);
        let norm = |column: &SVector<f64, ROWS>| column.rows(of.start, of.len()).norm();
        let length = norm(&found).max(norm(&expected));
        let error = if length > 1e-9 { norm(&(found - expected)) / length } else { 0.0 };
        if error > most.0 {
            most = (error, LIBRARY[usize::from(setting.candidates.places()[e].effect)].name());
        }
    }
    most
}

#[test]
fn the_columns_are_the_derivatives_of_the_rows() {
    for (seed, kind) in [(0, Kind::Moving), (1, Kind::Moving), (2, Kind::Rest)] {
        let mut setting = Setting::new(seed, kind, 0.6);
        let (error, name) = largest_error(&mut setting, 0..STILL - NODE);
        assert!(error < 1e-3, "{seed}: {error} of {name}");
        let rows = setting.rows(&[0.0; EFFECTS]);
        // Every column has a coefficient.
        for column in 0..setting.candidates.places().len() {
            assert!(rows.further[NODE..STILL].iter().any(|row| row[column].abs() > 1e-6), "{seed}: {column}");
        }
    }
}

/// The part of the rate that is taken out while the tool moves is no part of its bias at rest either.
#[test]
fn at_rest_the_rate_is_read_without_what_is_taken_out() {
    let (error, name) = largest_error(&mut Setting::new(3, Kind::Rest, 1e-3), STILL - NODE..ROWS);
    assert!(error < 1e-3, "{error} of {name}");
}

/// Each step is read from its shock on, and no more once it has been dropped.
#[test]
fn a_step_is_read_from_its_shock_until_it_is_dropped() {
    let mut setting = Setting::new(5, Kind::Moving, 0.6);
    let read = |setting: &mut Setting| -> [bool; 3] {
        let rows = setting.rows(&[0.0; EFFECTS]);
        let is_read = |column: usize| rows.further[NODE..NODE + 3].iter().any(|row| row[column] != 0.0);
        let step = LIBRARY.iter().position(|effect| effect.is_bias_step()).unwrap();
        core::array::from_fn(|k| setting.candidates.places.first_column(step, k as u8).is_some_and(is_read))
    };
    assert_eq!(read(&mut setting), [true; 3]);
    setting.candidates.drop_step(1);
    assert_eq!(read(&mut setting), [true, false, true]);
}

/// A row that was left out says nothing of the effects either.
#[test]
fn without_a_field_its_rows_say_nothing() {
    let mut setting = Setting::new(4, Kind::Moving, 0.6);
    setting.increments.iter_mut().for_each(|(increment, _)| increment.field = None);
    let rows = setting.rows(&[0.0; EFFECTS]);
    assert!(rows.further[SEEN..SEEN + 3].as_flattened().iter().all(|x| *x == 0.0));
    assert!(rows.further[NODE..SEEN].as_flattened().iter().any(|x| *x != 0.0));
}
