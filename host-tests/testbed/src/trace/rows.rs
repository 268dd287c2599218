//! Rows of a trace, in memory or in a temporary file.

use std::collections::HashMap;

use meerkat_mwd::{
    Sample, SampleFlags,
    config::FullScale,
    probe::{CLIPPED_SHARE, GAP_PERIODS},
};

use super::{
    Trace,
    spool::{Bytes, Fixed, Spool, put_numbers},
};

/// One row of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The sample.
    pub sample: Sample,
    /// Reference attitude as in [`Trace::reference`].
    pub reference: Option<[f64; 4]>,
    /// True if the sample is scored: all are where no column says so.
    pub moves: bool,
    /// True if the probe rests; never where no column says so.
    pub rests: bool,
    /// Flags of the driver.
    said: SampleFlags,
}

impl Fixed for Row {
    const SIZE: usize = 52 + 33 + 2;

    fn put(&self, bytes: &mut Vec<u8>) {
        let Sample { t_us, gyro_rad_s, accel_m_s2, mag_ut, temperature_c, flags } = self.sample;
        bytes.extend(t_us.to_le_bytes());
        for vector in [gyro_rad_s, accel_m_s2, mag_ut] {
            put_numbers(bytes, &vector);
        }
        put_numbers(bytes, &[temperature_c]);
        bytes.extend(flags.bits().to_le_bytes());
        bytes.extend(self.said.bits().to_le_bytes());
        bytes.push(u8::from(self.reference.is_some()));
        self.reference.unwrap_or_default().iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([u8::from(self.moves), u8::from(self.rests)]);
    }

    fn take(bytes: &mut Bytes) -> Self {
        let t_us = u64::from_le_bytes(bytes.take_bytes());
        let (gyro_rad_s, accel_m_s2, mag_ut) = (bytes.numbers(), bytes.numbers(), bytes.numbers());
        let temperature_c = bytes.number();
        let mut flags = || SampleFlags::from_bits_retain(u16::from_le_bytes(bytes.take_bytes()));
        let (flags, said) = (flags(), flags());
        let [is_there] = bytes.take_bytes();
        let reference = std::array::from_fn(|_| f64::from_le_bytes(bytes.take_bytes()));
        let [moves, rests] = bytes.take_bytes();
        Self {
            sample: Sample { t_us, gyro_rad_s, accel_m_s2, mag_ut, temperature_c, flags },
            reference: (is_there != 0).then_some(reference),
            moves: moves != 0,
            rests: rests != 0,
            said,
        }
    }
}

/// Sets a sample's clipped flags from these full scales (see [`CLIPPED_SHARE`]); the driver's own flags stay, all
/// others are cleared.
pub(super) fn mark_clipped(sample: &mut Sample, full_scale: &FullScale, said: SampleFlags) {
    let flags = sample.flags;
    let mut mark = |v: &[f32; 3], limit: Option<f32>, clipped, absent| {
        let is_beyond = limit.is_some_and(|limit| v.iter().any(|x| x.abs() >= CLIPPED_SHARE * limit));
        sample.flags.set(clipped, !flags.contains(absent) && is_beyond);
    };
    mark(&sample.gyro_rad_s, full_scale.gyro_rad_s, SampleFlags::GYRO_CLIPPED, SampleFlags::GYRO_MISSING);
    mark(&sample.accel_m_s2, full_scale.accel_m_s2, SampleFlags::ACCEL_CLIPPED, SampleFlags::ACCEL_MISSING);
    mark(&sample.mag_ut, full_scale.mag_ut, SampleFlags::MAG_CLIPPED, SampleFlags::MAG_MISSING);
    sample.flags |= said;
}

/// Steps of time, counted by their length.
#[derive(Clone, Debug, Default)]
struct Steps {
    count: HashMap<u64, usize>,
    last_us: Option<u64>,
    /// Steps of the same length, not counted yet.
    equal: (u64, usize),
}

impl Steps {
    fn push(&mut self, t_us: u64) {
        let step = self.last_us.map(|last_us| t_us.saturating_sub(last_us));
        self.last_us = Some(t_us);
        match step {
            Some(step) if step == self.equal.0 => self.equal.1 += 1,
            Some(step) => self.count((step, 1)),
            None => {}
        }
    }

    /// Counts the equal steps, and begins with others.
    fn count(&mut self, others: (u64, usize)) {
        let (step, count) = std::mem::replace(&mut self.equal, others);
        if count > 0 {
            *self.count.entry(step).or_default() += count;
        }
    }

    /// The median step, 0 for fewer than two samples, and the number of steps over three of it.
    fn median_us_and_gaps(mut self) -> (u32, usize) {
        self.count((0, 0));
        let mut steps: Vec<(u64, usize)> = self.count.iter().map(|(step, count)| (*step, *count)).collect();
        steps.sort_unstable();
        let mut below = 0;
        let middle = steps.iter().map(|(_, count)| count).sum::<usize>() / 2;
        let median = steps.iter().find(|(_, count)| {
            below += count;
            below > middle
        });
        let Some((median, _)) = median else { return (0, 0) };
        let is_gap = |(step, _): &&(u64, usize)| *step > median.saturating_mul(GAP_PERIODS.into());
        let gaps = steps.iter().filter(is_gap).map(|(_, count)| count).sum();
        (u32::try_from(*median).unwrap_or(u32::MAX), gaps)
    }
}

/// Facts about all rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts {
    /// Number of samples.
    pub samples: usize,
    /// Time of the first sample, microseconds.
    pub first_us: u64,
    /// Time of the last sample, microseconds.
    pub last_us: u64,
    /// Median step between samples, microseconds; 0 for fewer than two samples.
    pub period_us: u32,
    /// Steps of time over three such periods.
    pub gaps: usize,
    /// Number of samples with each flag, from the lowest bit on.
    flagged: [usize; 16],
    /// Number of samples with a clipped sensor.
    pub clipped: usize,
    /// Number of samples with a reference attitude.
    pub referred: usize,
    /// Number of samples of which a column says that the probe rests.
    pub rests: usize,
}

impl Facts {
    /// Goes through all rows.
    pub fn of(rows: impl Iterator<Item = Row>) -> Self {
        let (mut facts, mut steps) = (Self::default(), Steps::default());
        let any_clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        for Row { sample, reference, rests, .. } in rows {
            if facts.samples == 0 {
                facts.first_us = sample.t_us;
            }
            facts.samples += 1;
            facts.last_us = sample.t_us;
            steps.push(sample.t_us);
            for (bit, count) in facts.flagged.iter_mut().enumerate() {
                *count += usize::from(sample.flags.bits() >> bit & 1);
            }
            facts.clipped += usize::from(sample.flags.intersects(any_clipped));
            facts.referred += usize::from(reference.is_some());
            facts.rests += usize::from(rests);
        }
        let (period_us, gaps) = steps.median_us_and_gaps();
        Self { period_us, gaps, ..facts }
    }

    /// Number of samples without a reference attitude; all if there are no such columns.
    #[must_use]
    pub const fn without_reference(&self) -> usize {
        self.samples - self.referred
    }

    /// Number of samples with a flag of one bit.
    #[must_use]
    pub fn count(&self, flag: SampleFlags) -> usize {
        self.flagged.get(flag.bits().trailing_zeros() as usize).copied().unwrap_or_default()
    }
}

/// Rows in a temporary file, with what is known of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spooled {
    rows: Spool<Row>,
    full_scale: FullScale,
    facts: Facts,
}

impl Spooled {
    /// Takes the rows of a trace out of memory.
    pub(super) fn take(&mut self, trace: &mut Trace) {
        let rows = InMemory { trace, index: 0 };
        rows.for_each(|row| self.rows.push(&row));
        trace.samples.clear();
        trace.reference.clear();
        let columns = [&mut trace.movement, &mut trace.rest];
        columns.into_iter().flatten().for_each(Vec::clear);
        trace.driver_flags.iter_mut().for_each(Vec::clear);
        trace.true_rate.iter_mut().for_each(Vec::clear);
    }

    /// Number of rows.
    pub(super) const fn len(&self) -> usize {
        self.rows.len()
    }

    /// Marks what is clipped by these full scales, and takes the facts anew.
    pub(super) fn mark_clipped(&mut self, full_scale: &FullScale) {
        self.rows.flush();
        if self.facts.samples == self.len() && self.full_scale == *full_scale {
            return;
        }
        self.full_scale = *full_scale;
        self.facts = Facts::of(self.iter());
    }

    pub(super) const fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The first error of the temporary file.
    pub(super) fn checked(&self) -> std::io::Result<()> {
        self.rows.checked()
    }

    fn iter(&self) -> impl Iterator<Item = Row> {
        self.rows.iter().map(|mut row| {
            mark_clipped(&mut row.sample, &self.full_scale, row.said);
            row
        })
    }
}

/// Rows of a trace whose columns are in memory.
struct InMemory<'a> {
    trace: &'a Trace,
    index: usize,
}

impl Iterator for InMemory<'_> {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        let (trace, index) = (self.trace, self.index);
        self.index += 1;
        let of = |column: &Option<Vec<bool>>, without| {
            column.as_ref().map_or(without, |column| column.get(index).copied().unwrap_or(false))
        };
        Some(Row {
            sample: *trace.samples.get(index)?,
            reference: trace.reference.get(index).copied().flatten(),
            moves: of(&trace.movement, true),
            rests: of(&trace.rest, false),
            said: trace.driver_flags.as_ref().and_then(|said| said.get(index).copied()).unwrap_or_default(),
        })
    }
}

impl Trace {
    /// The rows, from the first on.
    #[must_use]
    pub fn rows(&self) -> Box<dyn Iterator<Item = Row> + '_> {
        match &self.spooled {
            Some(spooled) => Box::new(spooled.iter()),
            None => Box::new(InMemory { trace: self, index: 0 }),
        }
    }

    /// The samples, from the first on, of a trace in memory or in a temporary file.
    pub fn samples(&self) -> impl Iterator<Item = Sample> + '_ {
        self.rows().map(|row| row.sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_step_is_that_of_the_sorted_steps() {
        for times in [vec![], vec![7], vec![7, 9], vec![0, 10, 13, 20, 31], vec![0, 5, 10, 15, 1_000, 1_005]] {
            let mut steps = Steps::default();
            times.iter().for_each(|t_us| steps.push(*t_us));
            let mut sorted: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
            sorted.sort_unstable();
            let (median_us, gaps) = steps.median_us_and_gaps();
            assert_eq!(gaps, sorted.iter().filter(|step| **step > 3 * u64::from(median_us)).count());
            assert_eq!(u64::from(median_us), sorted.get(sorted.len() / 2).copied().unwrap_or(0));
        }
    }
}
