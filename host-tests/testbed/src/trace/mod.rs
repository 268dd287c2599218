//! A recorded or simulated trace: samples, header, and the reference that scores are measured against.

mod columns;
mod decimal_time;
mod dropped;
mod error;
mod keys;
mod lines;
pub mod motion;
mod read;
pub mod recordings;
mod row_order;
mod rows;
mod seconds;
pub mod spool;
mod write;

use std::path::{Path, PathBuf};

pub use dropped::Dropped;
pub use error::{Fault, TraceError};
pub use keys::{BodyFrame, EarthFrame, Keys};
use meerkat_mwd::{
    Sample, SampleFlags,
    config::FullScale,
    survey::{Grade, SurveyReport},
};
pub use row_order::{RowOrder, RowPlace};
pub use rows::{Facts, Row, Spooled};

pub use seconds::seconds;

/// A trace. Reference columns are for scoring only: the pipeline sees nothing but the samples.
///
/// [`Trace::read`] holds it in memory, in the columns below. Of a long trace by [`Trace::spooled`] the columns are
/// empty: its rows are in a temporary file, and come by [`Trace::rows`], as those in memory do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The file it was read from.
    pub path: PathBuf,
    /// Header keys.
    pub keys: Keys,
    /// One per row, times strictly increasing.
    pub samples: Vec<Sample>,
    /// Reference attitude, body to the trace's earth frame, scalar first; `None` for an empty cell; empty
    /// without the columns.
    pub reference: Vec<Option<[f64; 4]>>,
    /// True if a sample is scored (column `movement`).
    pub movement: Option<Vec<bool>>,
    /// True if the probe rests (column `rest`).
    pub rest: Option<Vec<bool>>,
    /// True angular rate, rad/s, body frame (columns `wx_true`, `wy_true`, `wz_true` of simulated traces).
    pub true_rate: Option<Vec<[f64; 3]>>,
    /// Flags that the driver itself set (column `sample_flags` of recorded traces, the bits of
    /// [`SampleFlags`]).
    pub driver_flags: Option<Vec<SampleFlags>>,
    /// Rows of the file that are no samples, for their times.
    pub dropped: Dropped,
    /// Remarks for the user, such as ignored columns.
    pub notes: Vec<String>,
    /// Units, signs and axes that cannot be, each with its likely fix; such a trace flies only when the user
    /// insists.
    pub wrong: Vec<String>,
    /// Rows that are in a temporary file.
    pub spooled: Option<Spooled>,
}

/// Returns true if any sensor's full scale is known; without one, clipping cannot be told.
#[must_use]
pub fn clipping_is_known(full_scale: &FullScale) -> bool {
    full_scale.gyro_rad_s.or(full_scale.accel_m_s2).or(full_scale.mag_ut).is_some()
}

impl Trace {
    /// Reads a trace, plain or gzip. Rows whose time repeats or goes back are dropped, counted and noted; over
    /// one in twenty, they are an error.
    ///
    /// # Errors
    /// Description of what is wrong, with the file, the line and the column.
    pub fn read(path: &Path) -> Result<Self, TraceError> {
        read::read(path)
    }

    /// Keys of a file's header, whatever is wrong with its rows; `None` if the header cannot be read.
    #[must_use]
    pub fn header(path: &Path) -> Option<Keys> {
        read::header(path)
    }

    /// Reads what a file would hold. The rest is as by [`Trace::read`]; the path is empty.
    ///
    /// # Errors
    /// Description of what is wrong, with the line and the column.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, TraceError> {
        read::of_bytes(bytes)
    }

    /// Reads a long trace into a temporary file: memory does not grow with its length. The rest is as by
    /// [`Trace::read`].
    ///
    /// # Errors
    /// Description of what is wrong, with the file, the line and the column.
    pub fn spooled(path: &Path) -> Result<Self, TraceError> {
        read::spooled(path)
    }

    /// Returns true if the rows are in a temporary file.
    #[must_use]
    pub const fn is_spooled(&self) -> bool {
        self.spooled.is_some()
    }

    /// The first error of the temporary file, behind which rows may lack.
    ///
    /// # Errors
    /// The temporary file could not be written or read.
    pub fn all_read(&self) -> std::io::Result<()> {
        self.spooled.as_ref().map_or(Ok(()), Spooled::checked)
    }

    /// The first dropped row as an error, for who allows none.
    ///
    /// # Errors
    /// A row was dropped for its time.
    pub fn none_dropped(&self) -> Result<(), TraceError> {
        self.dropped.first(&self.path).map_or(Ok(()), Err)
    }

    /// Writes the trace so that [`Trace::read`] gives it back, gzip when the name ends in `.gz`.
    ///
    /// Notes are not written: the format has no place for them. Sensor groups that no sample has are left
    /// out.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), TraceError> {
        write::write(self, path)
    }

    /// Facts about all rows. Goes through the rows of a trace in memory: ask once.
    #[must_use]
    pub fn facts(&self) -> Facts {
        self.spooled.as_ref().map_or_else(|| Facts::of(self.rows()), |spooled| *spooled.facts())
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spooled.as_ref().map_or(self.samples.len(), Spooled::len)
    }

    /// Returns true if there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Median step between samples, microseconds; 0 for fewer than two samples.
    #[must_use]
    pub fn nominal_period_us(&self) -> u32 {
        self.spooled.as_ref().map_or_else(|| self.period_in_memory_us(), |spooled| spooled.facts().period_us)
    }

    fn period_in_memory_us(&self) -> u32 {
        let mut steps: Vec<u64> =
            self.samples.windows(2).map(|pair| pair[1].t_us.saturating_sub(pair[0].t_us)).collect();
        let middle = steps.len() / 2;
        if steps.is_empty() {
            return 0;
        }
        let (_, median, _) = steps.select_nth_unstable(middle);
        u32::try_from(*median).unwrap_or(u32::MAX)
    }

    /// Time of the first sample, microseconds.
    #[must_use]
    pub fn first_us(&self) -> u64 {
        let of_memory = || self.samples.first().map_or(0, |sample| sample.t_us);
        self.spooled.as_ref().map_or_else(of_memory, |spooled| spooled.facts().first_us)
    }

    /// Time of the last sample, microseconds.
    #[must_use]
    pub fn last_us(&self) -> u64 {
        let of_memory = || self.samples.last().map_or(0, |sample| sample.t_us);
        self.spooled.as_ref().map_or_else(of_memory, |spooled| spooled.facts().last_us)
    }

    /// From the first sample to the last, microseconds.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        self.last_us().saturating_sub(self.first_us())
    }

    /// From the first sample to the last, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_us() as f64 * 1e-6
    }

    /// Grades a survey of readings that cannot be as bad, whatever it agrees with.
    pub fn grade(&self, report: &mut SurveyReport) {
        if !self.wrong.is_empty() {
            report.quality.grade = Grade::Bad;
        }
    }

    /// Sets each sample's clipped flags from these full scales (see [`meerkat_mwd::probe::CLIPPED_SHARE`]); the
    /// driver's own flags stay, all others are cleared.
    pub fn mark_clipped(&mut self, full_scale: &FullScale) {
        if let Some(spooled) = &mut self.spooled {
            spooled.mark_clipped(full_scale);
        }
        let mut said = self.driver_flags.iter().flatten();
        for sample in &mut self.samples {
            rows::mark_clipped(sample, full_scale, said.next().copied().unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(t_us: u64) -> Sample {
        Sample { t_us, ..Sample::default() }
    }

    #[test]
    fn the_nominal_period_survives_a_gap_and_the_duration_does_not_start_at_zero() {
        let samples = [1_000, 6_000, 11_000, 3_011_000, 3_016_000].map(at).to_vec();
        let trace = Trace { samples, ..Trace::default() };
        assert_eq!(trace.nominal_period_us(), 5_000);
        assert_eq!(trace.duration_us(), 3_015_000);
        assert_eq!(Trace::default().nominal_period_us(), 0);
    }

    #[test]
    fn a_saturated_16_bit_word_of_a_2000_deg_s_gyro_is_clipped_and_one_percent_below_is_not() {
        let full_scale = FullScale { gyro_rad_s: Some(2000.0_f32.to_radians()), ..FullScale::default() };
        let reading = |deg_s: f32| Sample { gyro_rad_s: [0.0, 0.0, deg_s.to_radians()], ..Sample::default() };
        let samples = vec![reading(-32_767.0 / 16.4), reading(1_980.0), reading(2_000.0)];
        let mut trace = Trace { samples, ..Trace::default() };
        trace.mark_clipped(&full_scale);
        let clipped = trace.samples.iter().map(|s| s.flags.contains(SampleFlags::GYRO_CLIPPED));
        assert_eq!(clipped.collect::<Vec<_>>(), [true, false, true]);
        trace.mark_clipped(&FullScale::default());
        assert_eq!(trace.facts().count(SampleFlags::GYRO_CLIPPED), 0);
    }
}
