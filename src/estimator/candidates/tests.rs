//! The candidates against dense matrices in double precision.

extern crate std;

mod evidence;
mod filled;
mod problem;
mod root;
mod shocks;
mod unturned;

use super::{Candidates, EFFECTS, PARAMETERS, STEPS, shocks::Shocks};
use crate::{
    compensation::{Effect, Parameter, Sensor, Snapshot, VectorError, effects::LIBRARY},
    estimator::{
        columns::{GLOBALS, NODE},
        globals::Globals,
        rows::{CONSTANT, GLOBAL, ROWS, SCRATCH, WIDTH},
    },
};
use nalgebra::Vector3;
use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;
use std::boxed::Box;

/// Columns of these tests: two shears, a bend, a lag, three steps of three axes, two more.
const E: usize = 16;

/// An effect of these tests. What it adds is the rate, turned and stretched in a way of its own.
struct Made {
    name: &'static str,
    sensor: Sensor,
    parameters: &'static [Parameter],
    is_step: bool,
    vector_error: Option<VectorError>,
}

const fn parameter(usual: f32, signed: bool) -> Parameter {
    Parameter { name: "", in_unit: 1.0, usual, largest: 40.0, signed, only_in_estimator: false }
}

const fn made(name: &'static str, sensor: Sensor, parameters: &'static [Parameter]) -> Made {
    Made { name, sensor, parameters, is_step: false, vector_error: None }
}

impl Effect for Made {
    fn name(&self) -> &'static str {
        self.name
    }
    fn sensor(&self) -> Sensor {
        self.sensor
    }
    fn parameters(&self) -> &'static [Parameter] {
        self.parameters
    }
    fn term(&self, k: usize, moment: &Snapshot) -> Vector3<f32> {
        let [x, y, z] = moment.rate_rad_s.into();
        [Vector3::new(x, 0.5 * y, -z), Vector3::new(z, x, y * y), Vector3::new(0.1, z, x)][k]
    }
    fn is_bias_step(&self) -> bool {
        self.is_step
    }
    fn vector_error(&self) -> Option<VectorError> {
        self.vector_error
    }
    fn aliases(&self) -> &'static [&'static str] {
        &[]
    }
}

static SHEAR: Made = made("shear", Sensor::Accelerometer, &[parameter(0.5, true), parameter(2.0, true)]);
static LAG: Made = made("lag", Sensor::Gyro, &[parameter(0.1, false)]);
static STEP: Made = Made {
    is_step: true,
    ..made("step", Sensor::Gyro, &[parameter(0.2, true), parameter(0.2, true), parameter(0.2, true)])
};
static IRON: Made = Made {
    vector_error: Some(VectorError::HardIron),
    ..made("iron", Sensor::Magnetometer, &[parameter(1.0, true), parameter(1.0, true), parameter(1.0, true)])
};
static BEND: Made = made("bend", Sensor::Magnetometer, &[parameter(3.0, true), parameter(3.0, true)]);
static TWIST: Made = made("twist", Sensor::Magnetometer, &[parameter(1.0, true)]);

/// Effects of these tests, in the order of the candidates; after them come the second and the third step.
static MADE: [&dyn Effect; 6] = [&SHEAR, &LAG, &STEP, &IRON, &BEND, &TWIST];
const OF_SHEAR: usize = 0;
const OF_LAG: usize = 1;
const OF_STEP: usize = 2;
const OF_IRON: usize = 3;
const OF_BEND: usize = 4;
const OF_TWIST: usize = 5;
/// Effect and step of each group of columns, in the order of the columns.
const COLUMNS: [(usize, u8); 7] =
    [(OF_SHEAR, 0), (OF_LAG, 0), (OF_STEP, 0), (OF_STEP, 1), (OF_STEP, 2), (OF_BEND, 0), (OF_TWIST, 0)];
const SHEARS: usize = 0;
const LAGS: usize = 2;
const STEPS_FROM: usize = 3;
const BENDS: usize = 12;
const TWISTS: usize = 14;
const USED: usize = 15;

/// Sum of twelve uniform deviates: near enough to a normal one; deviation 1.
fn deviate(generator: &mut Xoshiro128PlusPlus) -> f64 {
    (0..12).map(|_| f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5).sum()
}

/// A row: globals, effects, constant.
#[derive(Clone, Copy)]
struct Row {
    globals: [f64; GLOBALS],
    effects: [f64; E],
    constant: f64,
}

impl Row {
    /// Random row; the columns that are not in use are zero.
    fn random(generator: &mut Xoshiro128PlusPlus) -> Self {
        Self {
            globals: core::array::from_fn(|_| deviate(generator)),
            effects: core::array::from_fn(|e| if e < USED { deviate(generator) } else { 0.0 }),
            constant: deviate(generator),
        }
    }

    /// Returns the coefficient of a global, or of an effect, which stand behind the globals.
    fn coefficient(&self, column: usize) -> f64 {
        if column < GLOBALS { self.globals[column] } else { self.effects[column - GLOBALS] }
    }
}

/// Filter's knowledge of globals and effects.
struct Known {
    globals: Globals<f64>,
    candidates: Candidates<f64, E>,
    rows: [[f64; WIDTH]; SCRATCH],
    further: [[f64; E]; SCRATCH],
}

impl Known {
    fn new() -> Self {
        let mut known = Self {
            globals: Globals::zero(),
            candidates: Candidates::zero(),
            rows: [[0.0; WIDTH]; SCRATCH],
            further: [[0.0; E]; SCRATCH],
        };
        known.globals.start();
        known.candidates.configure(&MADE);
        for (index, step) in COLUMNS {
            known.candidates.places.give_columns(index, MADE[index], step).unwrap();
        }
        known
    }

    /// Takes what is left of the rows of a node into globals and effects.
    fn absorb(&mut self) -> f64 {
        let left = &mut self.rows[2 * NODE..NODE + ROWS];
        let mut column = 0;
        while column < GLOBALS {
            column = self.candidates.absorb(&mut self.further, &mut self.globals, left, column);
        }
        let mut column = 0;
        while self.candidates.absorb_own(&mut self.further, left, column) {
            column += 2;
        }
        left.iter().map(|row| row[CONSTANT] * row[CONSTANT]).sum()
    }

    /// Takes rows whose constants are those at the prior's mean, as the filter does node by node.
    fn learn(&mut self, rows: &[Row]) {
        for rows in rows.chunks(ROWS - NODE) {
            self.rows = [[0.0; WIDTH]; SCRATCH];
            self.further = [[0.0; E]; SCRATCH];
            for (k, row) in rows.iter().enumerate() {
                let at = 2 * NODE + k;
                self.rows[at][GLOBAL..CONSTANT].copy_from_slice(&row.globals);
                self.further[at] = row.effects;
                let of_globals = row.globals.iter().zip(&self.globals.x).map(|(a, x)| a * x).sum::<f64>();
                let of_effects = row.effects.iter().zip(&self.candidates.root.x).map(|(a, x)| a * x).sum::<f64>();
                self.rows[at][CONSTANT] = row.constant + of_globals + of_effects;
            }
            self.absorb();
            self.globals.solve();
        }
    }
}

/// Shakes for so many seconds; the largest specific force of an increment of 40 ms is what `peak` says.
fn shake(shocks: &mut Shocks, now_us: &mut u64, seconds: u64, mut peak: impl FnMut() -> f32) {
    for _ in 0..seconds * 25 {
        *now_us += 40_000;
        shocks.look_at(*now_us, peak());
    }
}

#[test]
fn the_library_finds_room() {
    let mut candidates = Box::new(Candidates::<f32, EFFECTS>::zero());
    candidates.configure(&LIBRARY);
    let parameters: usize = LIBRARY.iter().map(|effect| effect.parameters().len()).sum();
    assert!(parameters <= PARAMETERS, "{parameters}");
    for (index, effect) in LIBRARY.iter().enumerate().filter(|(_, effect)| effect.vector_error().is_none()) {
        for step in 0..if effect.is_bias_step() { STEPS as u8 } else { 1 } {
            let from = candidates.places.give_columns(index, *effect, step);
            assert!(from.is_some() && candidates.places.first_column(index, step) == from, "{}", effect.name());
        }
    }
    // No columns are left.
    let before = candidates.places().len();
    let full = (0..EFFECTS).find(|_| candidates.places.give_columns(0, &STEP, 0).is_none());
    assert!(full.is_some() && candidates.places().len() + 3 > EFFECTS && before <= EFFECTS);
}
