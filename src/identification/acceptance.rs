use super::{Refusal, contest::Outcome};

/// Most probable chance win that is accepted: false accepts from chance alone under 1 % of windows.
const MAX_P_VALUE: f32 = 0.01;

/// Least share of the misfit on unseen blocks that P has to explain: three quarters, so that the residual's rms is at least
/// halved. Lags, soft iron and lever arms that are not modelled also make P win beyond chance; but then they, not P, hold most
/// of the misfit. With percent-level errors of P it is the other way round.
const LEAST_EXPLAINED: f32 = 0.75;

/// Least change of the rotation over a one-second segment that is worth a swap, rad: 0.3 deg.
const LEAST_CHANGE_RAD: f32 = 5.2e-3;

/// By how many of its own (jackknife) deviations that change has to stand out.
const LEAST_CHANGE_SIGMAS: f32 = 3.0;

/// Largest error of the norm of specific force at rest, m/s^2: 20 mg, the zero-g offset of data sheets (LSM6DSO, ICM-42688-P:
/// +-20 mg typical). Beyond, the accelerometer is uncalibrated: directions are off by a degree and more.
const MAX_NORM_ERROR_M_S2: f32 = 0.2;

/// What the gate looks at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    pub outcome: Outcome,
    /// Root mean square over the moving segments of the change of rotation, rad.
    pub change_rad: f32,
    /// The same of its uncertainty.
    pub change_sigma_rad: f32,
}

/// Whether the vector sensors may judge P at all: a magnetometer, and an accelerometer whose norm at rest is gravity's. Gravity
/// alone may judge only with a calibration of the accelerometer on record: norms at a few rests do not vouch for directions.
pub(crate) fn sensors_fit_to_judge(
    field_rows: u32,
    gravity_rows: u32,
    rest_norm_error_m_s2: Option<f32>,
    accelerometer_on_record: bool,
) -> Result<(), Refusal> {
    if gravity_rows == 0 && field_rows == 0 && rest_norm_error_m_s2.is_none() {
        return Err(Refusal::NotEnoughExcitation { rank: 0 });
    }
    let uncalibrated = rest_norm_error_m_s2.is_some_and(|error| error > MAX_NORM_ERROR_M_S2);
    if 2 * field_rows < gravity_rows && (uncalibrated || !accelerometer_on_record) {
        let accel_norm_error_m_s2 = rest_norm_error_m_s2.filter(|_| uncalibrated);
        return Err(Refusal::NoMagnetometer { accel_norm_error_m_s2 });
    }
    if 2 * gravity_rows < field_rows {
        return Err(Refusal::NoAccelerometer);
    }
    match rest_norm_error_m_s2 {
        Some(norm_error_m_s2) if uncalibrated => Err(Refusal::AccelerometerUncalibrated { norm_error_m_s2 }),
        _ => Ok(()),
    }
}

/// Whether a fit of P may fly.
pub(crate) fn judge(evidence: &Evidence) -> Result<(), Refusal> {
    let Evidence { outcome, change_rad, change_sigma_rad } = *evidence;
    clear_win(&outcome)?;
    let worth_it = change_rad > LEAST_CHANGE_RAD && change_rad > LEAST_CHANGE_SIGMAS * change_sigma_rad;
    if worth_it { Ok(()) } else { Err(Refusal::ChangeTooSmall { change_rad, sigma_rad: change_sigma_rad }) }
}

/// The part of the gate that a fitted bias has to pass as well.
pub(crate) fn clear_win(outcome: &Outcome) -> Result<(), Refusal> {
    let Outcome { p_value, explained } = *outcome;
    // Both are asked for what passes, so that a NaN refuses.
    let (clear, main) = (p_value <= MAX_P_VALUE, explained >= LEAST_EXPLAINED);
    match (clear, main) {
        (true, true) => Ok(()),
        (true, false) => Err(Refusal::MisfitNotExplained { explained }),
        (false, _) => Err(Refusal::NoClearWin { p_value }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Evidence =
        Evidence { outcome: Outcome { p_value: 0.001, explained: 0.9 }, change_rad: 0.1, change_sigma_rad: 0.01 };

    #[test]
    fn each_rule_refuses_by_itself_and_nan_never_passes() {
        assert_eq!(judge(&GOOD), Ok(()));
        let with = |outcome: Outcome| judge(&Evidence { outcome, ..GOOD });
        assert!(matches!(with(Outcome { p_value: 0.02, ..GOOD.outcome }), Err(Refusal::NoClearWin { .. })));
        assert!(matches!(with(Outcome { explained: 0.7, ..GOOD.outcome }), Err(Refusal::MisfitNotExplained { .. })));
        assert!(matches!(
            with(Outcome { explained: f32::NAN, ..GOOD.outcome }),
            Err(Refusal::MisfitNotExplained { .. })
        ));
        assert!(matches!(judge(&Evidence { change_rad: 0.02, ..GOOD }), Err(Refusal::ChangeTooSmall { .. })));
        assert!(matches!(
            judge(&Evidence { change_rad: 0.004, change_sigma_rad: 0.0, ..GOOD }),
            Err(Refusal::ChangeTooSmall { .. })
        ));
        assert!(judge(&Evidence { change_sigma_rad: f32::NAN, ..GOOD }).is_err());
    }

    #[test]
    fn sensors_that_cannot_judge_are_named() {
        let sensors_fit_to_judge = |field, gravity, error| super::sensors_fit_to_judge(field, gravity, error, false);
        let on_record = |error| super::sensors_fit_to_judge(0, 300, error, true);
        assert_eq!(sensors_fit_to_judge(300, 300, Some(0.05)), Ok(()));
        assert_eq!(sensors_fit_to_judge(300, 300, None), Ok(()));
        assert_eq!(on_record(Some(0.05)), Ok(()), "a calibrated accelerometer may judge alone");
        assert!(matches!(on_record(Some(0.9)), Err(Refusal::NoMagnetometer { accel_norm_error_m_s2: Some(_) })));
        assert!(matches!(sensors_fit_to_judge(0, 300, Some(0.05)), Err(Refusal::NoMagnetometer { .. })));
        assert!(matches!(
            sensors_fit_to_judge(0, 300, None),
            Err(Refusal::NoMagnetometer { accel_norm_error_m_s2: None })
        ));
        assert!(matches!(sensors_fit_to_judge(300, 300, Some(0.9)), Err(Refusal::AccelerometerUncalibrated { .. })));
        assert_eq!(sensors_fit_to_judge(300, 0, None), Err(Refusal::NoAccelerometer));
    }
}
