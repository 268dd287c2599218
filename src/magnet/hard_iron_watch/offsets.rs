//! Body-fixed offsets found so far, relative to the one present from the start.

use super::{
    super::{
        field_filter::FieldFilter,
        hard_iron_interval::{FieldUse, HardIronInterval},
    },
    kept_intervals::KeptIntervals,
};
use crate::{algebra::Whitening, statistics::chi_square::IN_A_HUNDRED};
use nalgebra::{Matrix3, Vector3};

/// Intervals with an offset, and the offset outside of these intervals.
pub(super) struct Offsets {
    /// Offset in the body before the present interval, and its variance on each axis.
    base_ut: Vector3<f32>,
    base_variance_ut2: Vector3<f32>,
    /// True if no new offset may be learnt.
    frozen: bool,
    pub kept: KeptIntervals,
}

impl Offsets {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { base_ut: zero, base_variance_ut2: zero, frozen: false, kept: KeptIntervals::zero() }
    }

    /// Ends learning: later offsets are corrected only if they match a known one.
    pub const fn freeze(&mut self) {
        self.frozen = true;
    }

    /// Records a change of the body-fixed offset, from the filter without the change and the filter with it.
    /// Differences below `matters_ut` do not count.
    pub fn change(&mut self, [before, after]: [&FieldFilter; 2], edge_us: u64, matters_ut: f32) {
        let covariance = after.in_body_covariance();
        let matters_ut2 = matters_ut * matters_ut;
        if self.kept.on {
            self.kept.close(edge_us);
            let left = after.in_body() - self.base_ut;
            let of_both = covariance + Matrix3::from_diagonal(&self.base_variance_ut2);
            if left.norm_squared() < matters_ut2 || is_same(&left, &of_both) {
                return;
            }
        } else {
            self.base_ut = before.in_body();
            self.base_variance_ut2 = before.in_body_variances_ut2();
        }
        let offset = after.in_body() - self.base_ut;
        let variance = covariance.diagonal() + self.base_variance_ut2;
        if is_same(&offset, &Matrix3::from_diagonal(&variance)) {
            self.kept.dismiss();
            return;
        }
        let known = self.kept.iter().find(|known| {
            let other = known.offset() - offset;
            let of_both = covariance + Matrix3::from_diagonal(&Vector3::from(known.sigma_ut).map(|s| s * s));
            known.is_corrected() && (other.norm_squared() < matters_ut2 || is_same(&other, &of_both))
        });
        let learned = HardIronInterval {
            from_us: edge_us,
            to_us: None,
            offset_ut: offset.into(),
            sigma_ut: variance.map(libm::sqrtf).into(),
            field_use: FieldUse::Corrected,
        };
        let interval = match (self.frozen, known) {
            (false, _) => learned,
            (true, Some(known)) => HardIronInterval { from_us: edge_us, to_us: None, ..*known },
            (true, None) => HardIronInterval { field_use: FieldUse::Withheld, ..learned },
        };
        self.kept.begin(interval);
    }

    /// Holds a change that could not be told, as an offset in the body: by the way it leaves it may be told yet.
    pub fn hold_untold(&mut self, [before, after]: [&FieldFilter; 2], edge_us: u64) {
        let variance = after.in_body_variances_ut2() + before.in_body_variances_ut2();
        self.kept.hold_untold(HardIronInterval {
            from_us: edge_us,
            to_us: None,
            offset_ut: (after.in_body() - before.in_body()).into(),
            sigma_ut: variance.map(libm::sqrtf).into(),
            field_use: FieldUse::ToldAfterwards,
        });
    }

    /// Returns true if an offset that left is the one that is held: it is an interval now.
    pub fn tell_afterwards(&mut self, [before, after]: [&FieldFilter; 2], edge_us: u64) -> bool {
        let Some(&came) = self.kept.untold() else { return false };
        let left = came.offset() + after.in_body() - before.in_body();
        let variance = Vector3::from(came.sigma_ut).map(|sigma| sigma * sigma)
            + after.in_body_variances_ut2()
            + before.in_body_variances_ut2();
        let is_told = left.component_mul(&left).component_div(&variance).sum() < IN_A_HUNDRED;
        if is_told {
            self.kept.begin(came);
            self.kept.close(edge_us);
        }
        is_told
    }

    /// Refines the offset of the interval that is still open, if any. Ends it when its offset is below `least_ut`: the
    /// magnet went so slowly that no single node showed it.
    pub fn refine(&mut self, tracked: &FieldFilter, t_us: u64, least_ut: f32) {
        if !self.kept.on {
            return;
        }
        let offset = tracked.in_body() - self.base_ut;
        if offset.norm_squared() < least_ut * least_ut {
            self.kept.close(t_us);
        }
        if self.frozen || !self.kept.on {
            return;
        }
        let variance = tracked.in_body_variances_ut2() + self.base_variance_ut2;
        if let Some(last) = self.kept.last_mut() {
            last.offset_ut = offset.into();
            last.sigma_ut = variance.map(libm::sqrtf).into();
        }
    }
}

/// Returns true if a difference is insignificant: exceeded by chance, given its covariance, more than once in a
/// hundred.
#[inline(never)]
fn is_same(difference: &Vector3<f32>, covariance: &Matrix3<f32>) -> bool {
    Whitening::new(covariance).is_some_and(|whitening| whitening.apply(difference).norm_squared() < IN_A_HUNDRED)
}
