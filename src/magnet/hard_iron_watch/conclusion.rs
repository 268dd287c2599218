use super::{
    super::{chi_square::IN_A_HUNDRED, hard_iron_interval::HardIronInterval, whitening::Whitening},
    HardIronWatch, LEAST_SIZE, State,
    suspicion::Verdict,
};
use nalgebra::{Matrix3, Vector3};

impl HardIronWatch {
    /// Ends a suspicion by its verdict, which may end an interval or begin one.
    pub(super) fn conclude(&mut self, verdict: Verdict) {
        self.state = State::Tracking;
        let edge_us = self.suspicion.first_us / 2 + self.suspicion.last_us / 2;
        let matters_ut = LEAST_SIZE * self.error_ut();
        let (before, after) = (self.tracked.in_body(), self.iron.in_body());
        let matters = (after - before).norm_squared() > matters_ut * matters_ut;
        // An offset that was there from the start and has gone is no magnet that came.
        let less = !self.kept.on && after.norm_squared() < before.norm_squared();
        if verdict != Verdict::Iron || !matters || less {
            self.kept.dismiss();
            match verdict {
                Verdict::Iron => self.tracked = self.iron,
                Verdict::Passed => {}
                Verdict::Earth | Verdict::Untold => self.tracked = self.earth,
            }
            return;
        }
        let covariance = self.iron.in_body_covariance();
        if self.kept.on {
            self.kept.close(edge_us);
            let left = self.iron.in_body() - self.base_ut;
            let spread = covariance + Matrix3::from_diagonal(&self.base_variance_ut2);
            self.tracked = self.iron;
            if left.norm_squared() < matters_ut * matters_ut || is_same(&left, &spread) {
                return;
            }
        } else {
            self.base_ut = self.tracked.in_body();
            self.base_variance_ut2 = self.tracked.in_body_covariance().diagonal();
            self.tracked = self.iron;
        }
        let offset = self.tracked.in_body() - self.base_ut;
        let variance = covariance.diagonal() + self.base_variance_ut2;
        if is_same(&offset, &Matrix3::from_diagonal(&variance)) {
            self.kept.dismiss();
            return;
        }
        let known = self.kept.iter().find(|known| {
            let other = known.offset() - offset;
            let spread = covariance + Matrix3::from_diagonal(&Vector3::from(known.sigma_ut).map(|s| s * s));
            known.corrected && (other.norm_squared() < matters_ut * matters_ut || is_same(&other, &spread))
        });
        let learned = HardIronInterval {
            from_us: edge_us,
            to_us: None,
            offset_ut: offset.into(),
            sigma_ut: variance.map(libm::sqrtf).into(),
            corrected: true,
        };
        let interval = match (self.frozen, known) {
            (false, _) => learned,
            (true, Some(known)) => HardIronInterval { from_us: edge_us, to_us: None, ..*known },
            (true, None) => HardIronInterval { corrected: false, ..learned },
        };
        self.kept.begin(interval);
    }
}

fn is_same(difference: &Vector3<f32>, spread: &Matrix3<f32>) -> bool {
    Whitening::new(spread).is_some_and(|whitening| whitening.apply(difference).norm_squared() < IN_A_HUNDRED)
}
