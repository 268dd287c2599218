//! Rotation over consecutive 2 s windows, against the reference.

use nalgebra::UnitQuaternion;

use super::{PerModel, Tracks, attitude::unit_quaternion, integrated::Integrated, rates, root_mean_square};
use crate::trace::Trace;

/// Length of a window, seconds.
const WINDOW_S: f64 = 2.0;

/// Share of the windows that count, the best ones: optical references glitch now and then.
const KEPT: f64 = 0.98;

/// A window, and the reference's rotation over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    /// Rotation from the body at the window's end to the body at its start.
    rotation: UnitQuaternion<f64>,
}

impl Window {
    /// Angle between a track's rotation over the window and the reference's, degrees, if the track's readings
    /// lag the reference by `delay_s`; `None` if the track does not cover the window.
    pub(super) fn error_deg(&self, track: &Integrated, delay_s: f64) -> Option<f64> {
        let rotation = track.rotation(self.from_s + delay_s, self.to_s + delay_s)?;
        Some(self.rotation.angle_to(&rotation).to_degrees())
    }

    /// Part of that error about one axis of the body at the window's end, with its sign, degrees.
    pub(super) fn error_about_deg(&self, track: &Integrated, delay_s: f64, axis: usize) -> Option<f64> {
        let rotation = track.rotation(self.from_s + delay_s, self.to_s + delay_s)?;
        (self.rotation.inverse() * rotation).scaled_axis().get(axis).map(|error| error.to_degrees())
    }
}

/// The windows that count, end to end from the first sample at or after `from_us`.
///
/// A window ends at the sample nearest to 2 s after its start; rotations are compared between exactly these
/// two times. It counts if every sample in it has a reference (and `movement`, if the trace has it).
pub(super) fn windows(trace: &Trace, from_us: u64) -> Vec<Window> {
    let start_us = trace.first_us();
    let half_period_us = trace.nominal_period_us() / 2;
    let length_us = (WINDOW_S * 1e6) as u64 - u64::from(half_period_us);
    let mut windows = Vec::new();
    // Time and reference at the window's start; no reference if a sample of it has none.
    let mut open: Option<(u64, Option<UnitQuaternion<f64>>)> = None;
    for row in trace.rows().filter(|row| row.sample.t_us >= from_us) {
        let t_us = row.sample.t_us;
        let reference = row.reference.filter(|_| row.moves).and_then(unit_quaternion);
        let Some((first_us, first)) = &mut open else {
            open = Some((t_us, reference));
            continue;
        };
        if reference.is_none() {
            *first = None;
        }
        if t_us < first_us.saturating_add(length_us) {
            continue;
        }
        if let (Some(q_from), Some(q_to)) = (*first, reference) {
            let [from_s, to_s] = [*first_us, t_us].map(|t_us| rates::seconds_since(start_us, t_us));
            windows.push(Window { from_s, to_s, rotation: q_from.inverse() * q_to });
        }
        open = Some((t_us, reference));
    }
    windows
}

/// Times at which these windows ask for rotations, if readings lag by up to `range_s` either way.
pub(super) fn asked(windows: &[Window], range_s: f64) -> impl Iterator<Item = [f64; 2]> {
    windows.iter().flat_map(|window| [window.from_s, window.to_s]).map(move |t_s| [t_s - range_s, t_s + range_s])
}

/// Errors of the tracks over each window, degrees, if readings lag the reference by `delay_s`; `None` for a window that
/// not all tracks cover without a gap.
pub(super) fn errors_deg(windows: &[Window], tracks: &Tracks<Integrated>, delay_s: f64) -> Vec<Option<PerModel>> {
    let covered = |w: &Window| tracks.cover(w.from_s + delay_s, w.to_s + delay_s);
    let errors = |w: &Window| covered(w).then(|| tracks.per_model(|track| w.error_deg(track, delay_s)));
    windows.iter().map(errors).collect()
}

/// Score of each track, degrees, over those windows that are counted; `None` without one, or of an empty track.
pub(super) fn rms_deg(errors: &[Option<PerModel>], is_counted: impl Fn(usize) -> bool) -> PerModel {
    let counted = |of: fn(&PerModel) -> Option<f64>| {
        let errors = errors.iter().enumerate().filter(|(index, _)| is_counted(*index)).filter_map(|(_, e)| e.as_ref());
        trimmed_rms(errors.map(of).collect::<Option<Vec<f64>>>()?)
    };
    PerModel {
        uncompensated: counted(|errors| errors.uncompensated),
        bias_only: counted(|errors| errors.bias_only),
        twelve_parameters: counted(|errors| errors.twelve_parameters),
        with_effects: counted(|errors| errors.with_effects),
    }
}

/// Score of one track, degrees; `None` without a window, or if the track does not cover all of them.
pub(super) fn track_rms_deg(windows: &[Window], track: &Integrated, delay_s: f64) -> Option<f64> {
    let errors = windows.iter().map(|window| window.error_deg(track, delay_s));
    trimmed_rms(errors.collect::<Option<Vec<f64>>>()?)
}

/// Root mean square of the smallest 98 % (rounded down, at least one).
pub fn trimmed_rms(mut errors: Vec<f64>) -> Option<f64> {
    errors.sort_by(f64::total_cmp);
    let kept = ((errors.len() as f64 * KEPT) as usize).max(1);
    root_mean_square(errors.into_iter().take(kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_of_a_hundred_outliers_do_not_count_and_a_third_does() {
        let with_outliers = |count: usize| (0..100).map(|i| if i < count { 90.0 } else { 2.0 }).collect::<Vec<f64>>();
        assert_eq!(trimmed_rms(with_outliers(0)), Some(2.0));
        assert_eq!(trimmed_rms(with_outliers(2)), Some(2.0));
        let expected = ((97.0 * 4.0 + 90.0 * 90.0) / 98.0_f64).sqrt();
        assert_eq!(trimmed_rms(with_outliers(3)), Some(expected));
        assert_eq!(trimmed_rms(vec![5.0]), Some(5.0));
        assert_eq!(trimmed_rms(vec![]), None);
    }
}
