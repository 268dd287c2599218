//! Stationary survey: waits at rest, averages, and then holds its result until the tool has moved.

use super::{
    SixAxisAverages, SurveyInput, SurveyKind, SurveyReport,
    means::{BlockMean, MeanOfBlocks},
    record::ToolfaceSwitch,
    sensor_errors::{self, CorrectionVariances},
    six_axis::SixAxisCovariance,
};
use crate::{
    attitude::RestTracker,
    config::{Earth, SurveyConfig},
    rotation::sine_and_cosine,
};
use nalgebra::Vector3;

/// Number of blocks in an average. Their scatter gives the mean's noise with 7 degrees of freedom.
const BLOCKS: u16 = 8;
/// Pause between readings that restarts the survey, microseconds: the tool could have moved and come back.
const LONGEST_PAUSE_US: u64 = 100_000;

/// Age from which readings say nothing of the present, microseconds: a pass of the main loop that erases a page of
/// flash takes less, and slow magnetometers are read 8 times as often.
pub(super) const OLDEST_EVIDENCE_US: u64 = 1_000_000;

/// Turn of the field within a second from which the tool moves, rad: five deviations of a reading of 1 uT noise in a
/// field of 50. A tool that turns at 3 rpm across the earth's field turns it by three times as much.
const FIELD_TURN_RAD: f32 = 0.1;

/// Stage of the stationary survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StationaryState {
    /// The tool moves, or has not been quiet for long enough to tell.
    #[default]
    Moving,
    /// At rest; the average has not begun.
    Settling,
    /// Readings are being averaged.
    Averaging,
    /// The survey is taken; motion must come before the next.
    Latched,
}

/// Set of sums, one for each averaged vector.
#[derive(Clone, Copy)]
struct Sums<T> {
    force: T,
    field: T,
    raw_accel: T,
    raw_mag: T,
    rate: T,
}

/// Computes stationary surveys, sample by sample.
pub(crate) struct StationarySurvey {
    state: StationaryState,
    rest: RestTracker,
    last_us: Option<u64>,
    since_us: u64,
    samples: u32,
    warmth: BlockMean,
    block: Sums<BlockMean>,
    means: Sums<MeanOfBlocks>,
    field_whole: bool,
    corrections: CorrectionVariances,
    /// Field that later readings are compared with, and its time, microseconds; a second old at most.
    field_before: Option<(u64, Vector3<f32>)>,
    /// Time at which the field turned last, microseconds.
    field_turned_us: Option<u64>,
}

impl StationarySurvey {
    pub(crate) const fn new() -> Self {
        let (block, mean) = (BlockMean::new(), MeanOfBlocks::new());
        Self {
            state: StationaryState::Moving,
            rest: RestTracker::new(),
            last_us: None,
            since_us: 0,
            samples: 0,
            warmth: block,
            block: Sums { force: block, field: block, raw_accel: block, raw_mag: block, rate: block },
            means: Sums { force: mean, field: mean, raw_accel: mean, raw_mag: mean, rate: mean },
            field_whole: true,
            corrections: CorrectionVariances::NONE,
            field_before: None,
            field_turned_us: None,
        }
    }

    pub(crate) const fn state(&self) -> StationaryState {
        self.state
    }

    /// Returns true if fresh readings of gyro and accelerometer show rest, and the field does not turn. The field is
    /// needed because a gyro with a dead axis reads rest, and in a vertical hole gravity does not contradict it.
    pub(crate) fn stands_still(&self, now_us: u64) -> bool {
        let is_lately = |us: Option<u64>| us.is_some_and(|us| now_us.abs_diff(us) < OLDEST_EVIDENCE_US);
        let is_quiet = self.rest.detected() && self.state != StationaryState::Moving;
        is_quiet && is_lately(self.last_us) && !is_lately(self.field_turned_us)
    }

    /// Returns true if the field has turned within the last second.
    fn has_field_turned(&mut self, t_us: u64, field: &Vector3<f32>) -> bool {
        let Some((then_us, before)) = self.field_before else {
            self.field_before = Some((t_us, *field));
            return false;
        };
        let both = before.norm_squared() * field.norm_squared();
        let across = before.cross(field).norm_squared();
        let has_turned = across > FIELD_TURN_RAD * FIELD_TURN_RAD * both || before.dot(field) < 0.0;
        if has_turned || t_us.saturating_sub(then_us) >= OLDEST_EVIDENCE_US {
            self.field_before = Some((t_us, *field));
        }
        has_turned
    }

    /// Takes a sample. Returns the report of a survey that has just latched.
    pub(crate) fn push(
        &mut self,
        input: &SurveyInput,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<SurveyReport> {
        if input.accel_clipped {
            self.start_over();
        }
        let mut step_us = self.last_us.map_or(0, |last| input.t_us.saturating_sub(last));
        if step_us > LONGEST_PAUSE_US {
            self.start_over();
            // Nobody saw rest in the pause.
            step_us = 0;
        }
        if let Some(field) = input.field_ut
            && self.has_field_turned(input.t_us, &field.into())
        {
            self.field_turned_us = Some(input.t_us);
        }
        let (Some(force), Some(rate)) = (input.force_m_s2, input.rate_rad_s) else { return None };
        let (force, rate) = (Vector3::from(force), Vector3::from(rate));
        self.last_us = Some(input.t_us);
        self.rest.update(&rate, Some(&force), step_us as f32 * 1e-6);
        if !self.rest.detected() {
            self.state = StationaryState::Moving;
            return None;
        }
        let elapsed_s = input.t_us.saturating_sub(self.since_us) as f32 * 1e-6;
        match self.state {
            StationaryState::Moving => {
                self.state = StationaryState::Settling;
                self.since_us = input.t_us;
                None
            }
            StationaryState::Settling => {
                if elapsed_s >= config.settle_s {
                    self.begin_average(input.t_us);
                    self.add(input, &force, &rate);
                }
                None
            }
            StationaryState::Averaging => {
                self.add(input, &force, &rate);
                let blocks = f32::from(self.means.force.count() + 1);
                if elapsed_s >= blocks * config.average_s / f32::from(BLOCKS) {
                    self.close_block(config);
                }
                if self.means.force.count() < BLOCKS {
                    return None;
                }
                self.state = StationaryState::Latched;
                self.report(input.t_us, toolface, (earth, config))
            }
            StationaryState::Latched => None,
        }
    }

    fn start_over(&mut self) {
        self.state = StationaryState::Moving;
        self.rest = RestTracker::new();
    }

    fn begin_average(&mut self, t_us: u64) {
        let Self { rest, last_us, field_before, field_turned_us, .. } = core::mem::replace(self, Self::new());
        (self.rest, self.last_us) = (rest, last_us);
        (self.field_before, self.field_turned_us) = (field_before, field_turned_us);
        (self.state, self.since_us) = (StationaryState::Averaging, t_us);
    }

    fn add(&mut self, input: &SurveyInput, force: &Vector3<f32>, rate: &Vector3<f32>) {
        self.corrections.include(input);
        let block = &mut self.block;
        block.force.add(force);
        block.rate.add(rate);
        block.raw_accel.add(&input.raw_accel_m_s2.into());
        if let Some(field) = input.field_ut {
            block.field.add(&field.into());
            block.raw_mag.add(&input.raw_mag_ut.into());
        }
        if let Some(temperature) = input.temperature_c {
            self.warmth.add(&Vector3::new(temperature, 0.0, 0.0));
        }
        self.samples = self.samples.saturating_add(1);
    }

    /// Closes a block and adds its means; restarts if force or field has turned since the first block.
    fn close_block(&mut self, config: &SurveyConfig) {
        let block = self.block;
        let empty = BlockMean::new();
        self.block = Sums { force: empty, field: empty, raw_accel: empty, raw_mag: empty, rate: empty };
        let means = &mut self.means;
        for (means, block) in [
            (&mut means.force, &block.force),
            (&mut means.raw_accel, &block.raw_accel),
            (&mut means.rate, &block.rate),
            (&mut means.field, &block.field),
            (&mut means.raw_mag, &block.raw_mag),
        ] {
            if let Some(mean) = block.mean() {
                means.add(&mean);
            }
        }
        let field = block.field.mean();
        self.field_whole &= field.is_some();
        let turned = |first: &Vector3<f32>, mean: Option<Vector3<f32>>| {
            let (sine, _) = sine_and_cosine(config.max_turn_rad);
            mean.is_some_and(|mean| {
                first.cross(&mean).norm_squared() > sine * sine * first.norm_squared() * mean.norm_squared()
            })
        };
        if turned(self.means.force.first(), block.force.mean()) || turned(self.means.field.first(), field) {
            self.start_over();
            self.means.force = MeanOfBlocks::new();
        }
    }

    fn report(
        &self,
        t_us: u64,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<SurveyReport> {
        let means = &self.means;
        let (force, field) = (means.force.mean(), means.field.mean());
        let mut covariance = SixAxisCovariance {
            gravity: sensor_errors::gravity_covariance(&force, &config.errors) + means.force.covariance(),
            field: sensor_errors::field_covariance(&field, &config.errors) + means.field.covariance(),
        };
        self.corrections.inflate(&mut covariance);
        let averages = SixAxisAverages {
            samples: self.samples,
            raw_accel_m_s2: means.raw_accel.mean().into(),
            raw_mag_ut: self.field_whole.then(|| means.raw_mag.mean().into()),
            force_m_s2: force.into(),
            field_ut: self.field_whole.then(|| field.into()),
            rate_rad_s: means.rate.mean().into(),
        };
        let span_us = [self.since_us, t_us];
        SurveyReport::of(
            SurveyKind::Stationary,
            span_us,
            averages,
            &covariance,
            &self.warmth,
            toolface,
            (earth, config),
        )
    }
}

#[cfg(test)]
mod tests;
