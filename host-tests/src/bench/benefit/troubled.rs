//! Recordings with a trouble in the first half: gaps, no rest, no magnetometer for a while, a gyro that is
//! far off.

use meerkat_mwd::SampleFlags;

use super::HOLD_OUT;
use testbed::{flight::configuration::freeze_at_us, trace::Trace};

/// Trouble of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Trouble {
    /// No trouble.
    None,
    /// Gaps of this many microseconds every 10 s.
    Gaps(u64),
    /// The recording begins 5 s after the motion does.
    StartInMotion,
    /// The magnetometer is silent for 20 s, from 25 s before the second half on.
    NoField,
}

/// Time from gap to gap, microseconds.
const EVERY_US: u64 = 10_000_000;

impl Trouble {
    /// A copy of the recording with the trouble in its first half.
    pub(super) fn of(self, trace: &Trace) -> Trace {
        let half_us = freeze_at_us(trace, HOLD_OUT);
        let start_us = trace.first_us();
        match self {
            Self::None => trace.clone(),
            Self::Gaps(long_us) => {
                kept(trace, |t_us| t_us >= half_us || (t_us - start_us) % EVERY_US >= long_us || t_us == start_us)
            }
            Self::StartInMotion => {
                let moves = trace.movement.iter().flatten().position(|moves| *moves).unwrap_or(0);
                let begins_us = trace.samples.get(moves).map_or(start_us, |sample| sample.t_us + 5_000_000);
                kept(trace, |t_us| t_us >= begins_us)
            }
            Self::NoField => {
                let mut trace = trace.clone();
                let silent = half_us.saturating_sub(25_000_000)..half_us.saturating_sub(5_000_000);
                for sample in trace.samples.iter_mut().filter(|sample| silent.contains(&sample.t_us)) {
                    sample.flags.insert(SampleFlags::MAG_MISSING);
                }
                trace
            }
        }
    }
}

/// The samples at the times kept, with all columns.
fn kept(trace: &Trace, is_kept: impl Fn(u64) -> bool) -> Trace {
    let keep: Vec<bool> = trace.samples.iter().map(|sample| is_kept(sample.t_us)).collect();
    fn of<T: Clone>(keep: &[bool], all: &[T]) -> Vec<T> {
        all.iter().zip(keep).filter(|(_, keep)| **keep).map(|(one, _)| one.clone()).collect()
    }
    Trace {
        samples: of(&keep, &trace.samples),
        reference: of(&keep, &trace.reference),
        movement: trace.movement.as_ref().map(|all| of(&keep, all)),
        ..trace.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meerkat_mwd::Sample;

    fn trace() -> Trace {
        let samples = (0..=600_u64).map(|k| Sample { t_us: 100_000 * k + 7, ..Sample::default() }).collect();
        let movement = Some((0..=600).map(|k| k >= 100).collect());
        Trace { samples, movement, ..Trace::default() }
    }

    #[test]
    fn gaps_are_in_the_first_half_alone() {
        let cut = Trouble::Gaps(1_000_000).of(&trace());
        assert_eq!(trace().samples.len() - cut.samples.len(), 3 * 10 - 1);
        assert_eq!(cut.movement.map(|movement| movement.len()), Some(cut.samples.len()));
    }

    #[test]
    fn a_start_in_motion_has_no_rest() {
        let cut = Trouble::StartInMotion.of(&trace());
        assert_eq!(cut.samples.first().map(|sample| sample.t_us), Some(15_000_007));
        assert!(cut.movement.is_some_and(|movement| movement.iter().all(|moves| *moves)));
    }

    #[test]
    fn the_field_is_missing_for_20_s_and_back_before_the_second_half() {
        let cut = Trouble::NoField.of(&trace());
        let missing = cut.samples.iter().filter(|sample| sample.flags.contains(SampleFlags::MAG_MISSING));
        assert_eq!(missing.clone().count(), 200);
        assert!(missing.map(|sample| sample.t_us).max().is_some_and(|t_us| t_us < 25_000_007));
    }
}
