//! Toolface while sliding: a mean of five seconds, by which one steers a motor.

use super::{Survey, SurveyInput, ToolfaceKind, Uncertain, record::ToolfaceSwitch};
use crate::{
    attitude::{Attitude, AttitudeFlags, positive_angle},
    config::SurveyConfig,
};
use core::f32::consts::{PI, TAU};

/// Length of a mean, microseconds.
pub const SLIDING_TOOLFACE_US: u64 = 5_000_000;
/// Pause between samples that begins a mean anew, microseconds.
const LONGEST_PAUSE_US: u64 = 500_000;

/// Mean toolface of five seconds in which the tool did not rotate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlidingToolface {
    /// First sample of the mean, microseconds.
    pub t_start_us: u64,
    /// Last sample of the mean, microseconds.
    pub t_end_us: u64,
    /// Kind of the toolface.
    pub kind: ToolfaceKind,
    /// Toolface, radians, with the toolface offset; its sigma is the attitude's at the last sample.
    pub toolface_rad: Uncertain,
    /// Standard deviation of the single samples' toolfaces, radians: the swing of the tool.
    pub swing_rad: f32,
    /// Time from the samples' mean time to the last sample, seconds: the age of the mean when it is reported. The
    /// attitude itself follows a turn at once, through the gyro; the line's delay comes on top.
    pub latency_s: f32,
}

/// Sums of the mean in progress; means do not overlap.
pub(super) struct SlidingMean {
    start_us: u64,
    last_us: u64,
    kind: ToolfaceKind,
    first_rad: f32,
    count: u32,
    /// Sums of differences to the first toolface, of their squares, and of times since the start.
    off_rad: f32,
    off_square: f32,
    since_s: f32,
}

impl SlidingMean {
    pub(super) const fn new() -> Self {
        Self {
            start_us: 0,
            last_us: 0,
            kind: ToolfaceKind::Gravity,
            first_rad: 0.0,
            count: 0,
            off_rad: 0.0,
            off_square: 0.0,
            since_s: 0.0,
        }
    }

    /// Takes a sample. Returns true if it completes a mean.
    pub(super) fn push(&mut self, input: &SurveyInput, rotating: bool, switch: ToolfaceSwitch) -> bool {
        let kind = switch.kind();
        // Without a heading a magnetic toolface counts from any direction.
        let is_known =
            |attitude: &&Attitude| kind == ToolfaceKind::Gravity || !attitude.flags.contains(AttitudeFlags::NO_HEADING);
        let Some(attitude) = input.attitude.as_ref().filter(|_| !rotating).filter(is_known) else {
            self.count = 0;
            return false;
        };
        let toolface = match kind {
            ToolfaceKind::Gravity => attitude.gravity_toolface_rad,
            ToolfaceKind::Magnetic => attitude.magnetic_toolface_rad,
        };
        let paused = input.t_us.saturating_sub(self.last_us) > LONGEST_PAUSE_US;
        if self.count == 0 || kind != self.kind || paused {
            *self = Self { start_us: input.t_us, kind, first_rad: toolface, ..Self::new() };
        }
        self.last_us = input.t_us;
        let off = match toolface - self.first_rad {
            off if off > PI => off - TAU,
            off if off < -PI => off + TAU,
            off => off,
        };
        let since_us = input.t_us.saturating_sub(self.start_us);
        self.count = self.count.saturating_add(1);
        self.off_rad += off;
        self.off_square += off * off;
        self.since_s += since_us as f32 * 1e-6;
        since_us >= SLIDING_TOOLFACE_US
    }

    /// Returns the mean, and begins another. `survey` is the continuous survey at the last sample.
    pub(super) fn take(
        &mut self,
        survey: &Survey,
        (declination_rad, config): (f32, &SurveyConfig),
    ) -> Option<SlidingToolface> {
        let share = 1.0 / core::mem::take(&mut self.count) as f32;
        let off = self.off_rad * share;
        let variance = self.off_square * share - off * off;
        // The attitude counts from true north if the declination is known; a survey's toolface from magnetic north.
        let (from_north, now) = match self.kind {
            ToolfaceKind::Gravity => (0.0, survey.gravity_toolface_rad),
            ToolfaceKind::Magnetic => (declination_rad, survey.magnetic_toolface_rad),
        };
        let mean = self.first_rad + off + config.toolface_offset_rad - from_north;
        let toolface = SlidingToolface {
            t_start_us: self.start_us,
            t_end_us: self.last_us,
            kind: self.kind,
            toolface_rad: Uncertain { value: positive_angle(libm::remainderf(mean, TAU)), sigma: now?.sigma },
            swing_rad: libm::sqrtf(if variance > 0.0 { variance } else { 0.0 }),
            latency_s: self.last_us.saturating_sub(self.start_us) as f32 * 1e-6 - self.since_s * share,
        };
        Some(toolface)
    }
}

#[cfg(test)]
mod tests;
