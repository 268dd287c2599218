#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{COLUMNS, GYRO};
use crate::{
    compensation::{Effect, Moment, Sensor},
    diagnosis::report::MAX_CANDIDATES,
};
use core::ops::Range;
use nalgebra::Vector3;

/// Where the columns of the candidates stand: the gyro's effects first, then the accelerometer's, then the magnetometer's, so that each
/// row has its columns in two runs.
#[derive(Clone, Copy)]
pub(in crate::diagnosis) struct Layout {
    /// First column of each candidate; equal to [`COLUMNS`] where there is no room.
    first: [u8; MAX_CANDIDATES],
    /// Ends of the gyro's, the accelerometer's and the magnetometer's columns.
    pub(super) ends: [usize; 3],
}

impl Layout {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { first: [0; MAX_CANDIDATES], ends: [0; 3] }
    }

    pub fn new(library: &[&dyn Effect]) -> Self {
        let mut layout = Self { first: [COLUMNS as u8; MAX_CANDIDATES], ends: [GYRO; 3] };
        let mut next = GYRO;
        for (end, sensor) in [Sensor::Gyro, Sensor::Accelerometer, Sensor::Magnetometer].into_iter().enumerate().take(3)
        {
            for (first, effect) in layout.first.iter_mut().zip(library) {
                let count = effect.parameters().len();
                if effect.is_bias_step() {
                    // It has none: its windows' part of c's.
                    continue;
                }
                if effect.sensor() == sensor && next + count <= COLUMNS {
                    *first = next as u8;
                    next += count;
                }
            }
            layout.ends[end] = next;
        }
        layout
    }

    /// All columns in use.
    pub const fn width(&self) -> usize {
        self.ends[2]
    }

    /// The columns of a candidate; empty where there is no room for it.
    pub fn columns_of(&self, library: &[&dyn Effect], index: usize) -> Range<usize> {
        let first = self.first.get(index).map_or(COLUMNS, |first| usize::from(*first));
        let count = library.get(index).map_or(0, |effect| effect.parameters().len());
        if first + count > COLUMNS { first..first } else { first..first + count }
    }

    /// Hands out what every parameter of every candidate, of its usual size, adds to its sensor's reading, and the column that it has.
    #[inline(never)]
    pub fn each_term(
        &self,
        library: &[&dyn Effect],
        moment: &Moment,
        take: &mut dyn FnMut(Sensor, usize, &Vector3<f32>),
    ) {
        for (index, effect) in library.iter().enumerate() {
            for ((k, parameter), at) in effect.parameters().iter().enumerate().zip(self.columns_of(library, index)) {
                take(effect.sensor(), at, &(effect.term(k, moment) * parameter.usual));
            }
        }
    }

    /// The columns of gravity's or the field's rows that vectors' effects fill.
    pub(super) fn of_vector(&self, vector: usize) -> Range<usize> {
        let [_, force, field] = self.ends;
        if vector == 0 { self.ends[0]..force } else { force..field }
    }
}
