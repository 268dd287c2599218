#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    stream::{TestFunction, UNDER_WAY},
    walk::Instant,
};
use crate::{
    compensation::{Effect, Sensor},
    config::IdentificationConfig,
};
use nalgebra::Vector3;

mod layout;

pub(super) use layout::Layout;

/// Unknowns of the gyro: P (row-major, 9) and c (3).
pub(super) const GYRO: usize = 12;

/// Columns that there is room for: the gyro's and those of the candidates.
pub(super) const COLUMNS: usize = 56;

/// Usual sizes of P's and c's errors: the columns are multiplied by them, so that the prior of every unknown has deviation 1.
#[derive(Clone, Copy)]
pub(super) struct GyroScales {
    pub diagonal: f32,
    pub off_diagonal: f32,
    pub c_rad_s: f32,
}

impl GyroScales {
    /// Those of the prior, but not less than a data sheet's: a P that is thought to be known better than it is must not be found as effects.
    pub fn new(identification: &IdentificationConfig) -> Self {
        let sheet = IdentificationConfig::default();
        let at_least = |x: f32, least: f32| if x > least { x } else { least };
        Self {
            diagonal: at_least(identification.prior_sigma_diagonal, sheet.prior_sigma_diagonal),
            off_diagonal: at_least(identification.prior_sigma_off_diagonal, sheet.prior_sigma_off_diagonal),
            c_rad_s: at_least(identification.prior_sigma_bias_rad_s, sheet.prior_sigma_bias_rad_s),
        }
    }

    /// That of an element of P.
    pub const fn of_p(&self, row: usize, column: usize) -> f32 {
        if row == column { self.diagonal } else { self.off_diagonal }
    }
}

/// None.
pub(super) const NO_ROWS: Rows = [[0.0; COLUMNS]; 3];

/// Rows of one vector over one test window.
pub(super) type Rows = [[f32; COLUMNS]; 3];

/// Writes a column of the three rows.
pub(super) fn put(rows: &mut Rows, at: usize, column: &Vector3<f32>) {
    for (row, value) in rows.iter_mut().zip(column.iter()) {
        if let Some(element) = row.get_mut(at) {
            *element = *value;
        }
    }
}

/// What is known of one test window beside its rows.
#[derive(Clone, Copy)]
pub(super) struct TestFacts {
    /// Right-hand sides of gravity's and the field's rows.
    pub rhs: [Vector3<f32>; 2],
    /// Scatter of the norm of specific force, m^2/s^4: what of the accelerometer's reading is no gravity.
    pub force_scatter: f32,
    /// Variance of the white part of the field's noise in an increment, one axis, microtesla^2.
    pub field_noise_ut2: f32,
    /// Mean norms, m/s^2 and microtesla.
    pub norms: [f32; 2],
    /// Whether gravity's and the field's rows count.
    pub counts: [bool; 2],
}

/// Sums of one test window under way, beside its rows.
#[derive(Clone, Copy)]
struct Sums {
    position: usize,
    rhs: [Vector3<f32>; 2],
    norm_sums: [f32; 2],
    square_force: f32,
    square_rate: f32,
    roughness: f32,
    missing: [bool; 3],
}

impl Sums {
    #[inline(always)]
    const fn zero() -> Self {
        Self {
            position: 0,
            rhs: [Vector3::new(0.0, 0.0, 0.0); 2],
            norm_sums: [0.0; 2],
            square_force: 0.0,
            square_rate: 0.0,
            roughness: 0.0,
            missing: [false; 3],
        }
    }

    fn facts(&self, moving_rate_rad_s: f32) -> TestFacts {
        let count = self.position as f32;
        let norms = self.norm_sums.map(|sum| sum / count);
        let scatter = self.square_force / count - norms[0] * norms[0];
        let [no_rate, no_force, no_field] = self.missing;
        let counts = !no_rate && self.square_rate > moving_rate_rad_s * moving_rate_rad_s * count;
        TestFacts {
            rhs: self.rhs,
            norms,
            force_scatter: if scatter > 0.0 { scatter } else { 0.0 },
            // Three components, and 1 + 4 + 1 variances in a second difference.
            field_noise_ut2: self.roughness / (18.0 * count),
            counts: [counts && !no_force, counts && !no_field],
        }
    }
}

/// Streaming weak form of the vectors' kinematics, with a column for every parameter of every candidate.
///
/// u(t) = R0(t) v(t), with the nominal gyro's rotation R0 and a vector v fixed in the earth, obeys u' = -R0 (dw x v) exactly,
/// dw being the true minus the nominal rate: dw = dP w_raw - dc. Multiplied by phi(t) = sin^2 over 2 s (zero at both ends) and
/// integrated by parts, -int phi' u dt = int phi R0 [v]x (dP w_raw - dc) dt: linear in the unknowns for any size of error.
///
/// An effect x f on the gyro's reading changes the true rate by -x f: columns -int phi R0 (v x -f) of both vectors. One on a vector's
/// reading: columns -int phi' R0 f of that vector.
pub(super) struct WeakColumns {
    /// Gravity's and the field's rows of each test window under way. Flat, so that it is cleared where it stands, and not by way of the
    /// stack.
    rows: [f32; UNDER_WAY * 2 * 3 * COLUMNS],
    sums: [Sums; UNDER_WAY],
    previous_fields: [Vector3<f32>; 2],
}

impl WeakColumns {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            rows: [0.0; UNDER_WAY * 2 * 3 * COLUMNS],
            sums: [Sums::zero(); UNDER_WAY],
            previous_fields: [Vector3::new(0.0, 0.0, 0.0); 2],
        }
    }

    pub fn start(&mut self, hop: usize) {
        self.rows.fill(0.0);
        self.sums = [Sums::zero(); UNDER_WAY];
        self.previous_fields = [Vector3::zeros(); 2];
        for (number, sums) in self.sums.iter_mut().enumerate().skip(1) {
            // Each begins later than the one before: it waits at a position before its first.
            sums.position = usize::MAX - number * hop + 1;
        }
    }

    /// Takes one instant; what is known of the test window that it completes, and which it is: its rows are to be looked at and then
    /// cleared.
    #[inline(never)]
    pub fn push(
        &mut self,
        instant: &Instant,
        function: &TestFunction,
        (library, layout): (&[&dyn Effect], &Layout),
        scales: &GyroScales,
        moving_rate_rad_s: f32,
    ) -> Option<(TestFacts, usize)> {
        let Instant { rotation, raw_rad_s, moment, read } = instant;
        let vectors = [moment.force_m_s2, moment.field_ut];
        let turned = vectors.map(|v| rotation * v);
        let gains = vectors.map(|v| rotation * v.cross_matrix());
        // Column by column: what it adds to gravity's and to the field's rows, times the weight (gyro) or the slope (vectors).
        let mut columns = [NO_ROWS; 2];
        for (column, gain) in columns.iter_mut().zip(&gains) {
            for i in 0..3 {
                for j in 0..3 {
                    put(column, 3 * i + j, &(gain.column(i) * (raw_rad_s[j] * scales.of_p(i, j))));
                }
                put(column, 9 + i, &(gain.column(i) * -scales.c_rad_s));
            }
        }
        layout.each_term(library, moment, &mut |sensor, at, term| {
            let [of_force, of_field] = &mut columns;
            match sensor {
                Sensor::Gyro => {
                    put(of_force, at, &(gains[0] * -term));
                    put(of_field, at, &(gains[1] * -term));
                }
                Sensor::Accelerometer => put(of_force, at, &(rotation * term)),
                Sensor::Magnetometer => put(of_field, at, &(rotation * term)),
            }
        });
        let roughness = {
            let [older, last] = self.previous_fields;
            self.previous_fields = [last, turned[1]];
            (turned[1] - last * 2.0 + older).norm_squared()
        };
        let force_norm = libm::sqrtf(moment.force_m_s2.norm_squared());
        let field_norm = libm::sqrtf(moment.field_ut.norm_squared());
        let mut completed = None;
        let (rows, _) = self.rows.as_chunks_mut::<COLUMNS>();
        let (rows, _) = rows.as_chunks_mut::<3>();
        let (rows, _) = rows.as_chunks_mut::<2>();
        for (number, (sums, rows)) in self.sums.iter_mut().zip(rows).enumerate() {
            let Some((weight, slope)) = function.at(sums.position) else {
                sums.position = sums.position.wrapping_add(1);
                continue;
            };
            for v in 0..2 {
                sums.rhs[v] += turned[v] * slope;
                let (gyro, vector) = (0..layout.ends[0], layout.of_vector(v));
                for (row, column) in rows[v].iter_mut().zip(&columns[v]) {
                    for (runs, factor) in [(&gyro, weight), (&vector, slope)] {
                        let sums = row.get_mut(runs.clone()).unwrap_or_default();
                        let added = column.get(runs.clone()).unwrap_or_default();
                        sums.iter_mut().zip(added).for_each(|(sum, column)| *sum += column * factor);
                    }
                }
            }
            sums.missing.iter_mut().zip(read).for_each(|(missing, read)| *missing |= !read);
            sums.square_rate += moment.rate_rad_s.norm_squared();
            sums.norm_sums[0] += force_norm;
            sums.norm_sums[1] += field_norm;
            sums.square_force += force_norm * force_norm;
            sums.roughness += roughness;
            sums.position += 1;
            if function.at(sums.position).is_none() {
                completed = Some((sums.facts(moving_rate_rad_s), number));
                *sums = Sums::zero();
            }
        }
        completed
    }

    /// Gravity's (0) or the field's (1) rows of a test window.
    pub fn rows(&self, number: usize, vector: usize) -> &Rows {
        let (rows, _) = self.rows.as_chunks::<COLUMNS>();
        let (rows, _) = rows.as_chunks::<3>();
        rows.get(2 * number + vector).unwrap_or(&NO_ROWS)
    }

    /// Clears them for the next.
    pub fn clear(&mut self, number: usize) {
        let length = 2 * 3 * COLUMNS;
        self.rows.iter_mut().skip(number * length).take(length).for_each(|x| *x = 0.0);
    }
}
