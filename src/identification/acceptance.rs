use super::{
    Refusal,
    contest::{MAX_GROUPS, Outcome},
};

/// Most probable chance win that is accepted: false accepts from chance alone under 1 % of windows.
const MAX_P_VALUE: f32 = 0.01;

/// Least share of the misfit on unseen blocks that P has to explain: three quarters, so that the residual's rms is at least
/// halved. Lags, soft iron and lever arms that are not modelled also make P win beyond chance; but then they, not P, hold most
/// of the misfit. With percent-level errors of P it is the other way round.
pub(crate) const LEAST_EXPLAINED: f32 = 0.75;

/// Most of the field's misfit that a fit may leave, over what the magnetometer's own noise makes of it, for nothing but P to be missing: what
/// is no noise is no more than the noise. Then a small P, of which vibration hides the most part from gravity, is seen as well.
const MOST_OVER_NOISE: f32 = 2.0;

/// Most by which a fit may raise gravity's misfit. One that is right changes it by -d^2 + 2 d z, d being how far it goes in gravity's
/// deviations and z a standard normal: by more than 4 only where z > (4 + d^2) / 2d, at least 2, in 2.3 % of windows at most.
const MOST_OBJECTION: f32 = 4.0;

/// Least change of the rotation over a second that is worth a swap, rad: 0.3 deg. It is also what the loop lets be of axes that are turned, so
/// that the field's may be off by as much, which looks like a P that is.
const LEAST_CHANGE_RAD: f32 = 5.2e-3;

/// The same where nothing but P is missing: what a MEMS gyro's noise makes of it, 0.01 deg/s/rtHz on three axes.
const LEAST_SEEN_RAD: f32 = 3e-4;

/// By how many of its own (jackknife) deviations the change has to stand out, and by how many of all that P's part of it may have from
/// elsewhere it is P's beyond doubt.
const LEAST_CHANGE_SIGMAS: f32 = 3.0;

/// Largest error of the norm of specific force at rest, m/s^2: 20 mg, the zero-g offset of data sheets (LSM6DSO, ICM-42688-P:
/// +-20 mg typical). Beyond, the accelerometer is uncalibrated: directions are off by a degree and more.
const MAX_NORM_ERROR_M_S2: f32 = 0.2;

/// By how many of the new model's own (posterior) deviations the flown one has to be off before it is refined. The error of a model
/// that is off by d and one that is not are as (d^2 + s^2) to s^2.
const REFINEMENT_SIGMAS: f32 = 1.0;

/// Most probable chance win that counts: of what flies over a refinement, or of the factory's P over what flies. The usual 5 %.
const WORSE_P_VALUE: f32 = 0.05;

/// What the gate looks at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    pub outcome: Outcome,
    pub promise: Promise,
    /// Whether axes of the magnetometer were found to be turned and are turned back, by as much as P may be, which looks the same; or a magnet
    /// came or left, and what is taken out of the field for it has an error.
    pub field_is_doubtful: bool,
}

/// Root mean squares over the moving seconds, rad.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Promise {
    /// Of the change of rotation that a swap makes.
    pub change_rad: f32,
    /// Of P's part of it.
    pub by_p_rad: f32,
    /// Of all the rotation.
    pub whole_rad: f32,
    /// Of its uncertainty, by the jackknife.
    pub jackknife_rad: f32,
    /// Of the new model's uncertainty, by the posterior.
    pub posterior_rad: f32,
}

/// Whether the vector sensors may judge P at all: a magnetometer, and an accelerometer whose norm at rest is gravity's. Gravity
/// alone may judge only with a calibration of the accelerometer on record: norms at a few rests do not vouch for directions.
pub(crate) fn sensors_fit_to_judge(
    field_rows: u32,
    gravity_rows: u32,
    rest_norm_error_m_s2: Option<f32>,
    accelerometer_on_record: bool,
) -> Result<(), Refusal> {
    if gravity_rows + field_rows == 0 && rest_norm_error_m_s2.is_none() {
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

/// Largest squared distance between what a window says by itself and what was carried into it, of 12 parameters that have not
/// changed: the quantile of chi-square with 12 degrees of freedom that one window in 100,000 exceeds, one in a month of drilling.
const CONTRADICTION: f32 = 45.1;

/// Whether a window agrees with the ones before it.
pub(crate) fn consistent(contradiction: f32) -> Result<(), Refusal> {
    // Asked for what passes, so that a NaN refuses.
    if contradiction <= CONTRADICTION { Ok(()) } else { Err(Refusal::Contradiction { square: contradiction }) }
}

/// Most deviations by which a fit may disagree with the accelerometer more often than what flies: once in a thousand by chance.
const MAX_DISAGREEMENT: f32 = 3.09;

/// Whether the accelerometer agrees as often with the fit as with what flies on how far the body turned (eq 6). Only a comparison
/// of the two says anything: accelerations turn specific force too, and about gravity nothing does.
pub(crate) fn agreed(disagreement: f32) -> Result<(), Refusal> {
    // Asked for what passes, so that a NaN refuses.
    if disagreement <= MAX_DISAGREEMENT { Ok(()) } else { Err(Refusal::RotationDisagrees { sigmas: disagreement }) }
}

/// Whether a fit of P may fly.
pub(crate) fn judge(evidence: &Evidence) -> Result<(), Refusal> {
    let Evidence { outcome, promise, field_is_doubtful } = *evidence;
    let Promise { change_rad, jackknife_rad, .. } = promise;
    match clear_win(&outcome) {
        // Gravity's misfit is of the body's own accelerations, too.
        Err(Refusal::RotationDisagrees { .. }) if promise.is_beyond_doubt() => {}
        Ok(()) if field_is_doubtful && !promise.is_beyond_doubt() => return Err(Refusal::FieldDoubtful),
        verdict => verdict?,
    }
    let least_rad = if outcome.is_noise() { LEAST_SEEN_RAD } else { LEAST_CHANGE_RAD };
    let worth_it = change_rad > least_rad && change_rad > LEAST_CHANGE_SIGMAS * jackknife_rad;
    if worth_it { Ok(()) } else { Err(Refusal::ChangeTooSmall { change_rad, sigma_rad: jackknife_rad }) }
}

impl Outcome {
    /// Whether the winner leaves little but the sensor's own noise.
    fn is_noise(&self) -> bool {
        self.over_noise <= MOST_OVER_NOISE
    }
}

impl Promise {
    /// Whether P's part is larger than the fit's uncertainty and turned axes can make it.
    fn is_beyond_doubt(&self) -> bool {
        let Self { by_p_rad, jackknife_rad, posterior_rad, whole_rad, .. } = *self;
        let turned_rad = LEAST_CHANGE_RAD * whole_rad;
        let variance = jackknife_rad * jackknife_rad + posterior_rad * posterior_rad + turned_rad * turned_rad;
        // Asked for what passes, so that a NaN refuses.
        by_p_rad * by_p_rad > LEAST_CHANGE_SIGMAS * LEAST_CHANGE_SIGMAS * variance
    }
}

/// Whether a fit may take the place of a P that was accepted before, without being news: this window too would have it rather
/// than the factory's P (`justified`), on unseen test windows what flies does not win, with its bias as it is or fitted
/// (`flown_wins`), and what flies is off by more than the new model can be.
pub(crate) fn judge_refinement(
    justified: &Outcome,
    flown_wins: [Outcome; 2],
    promise: &Promise,
) -> Result<(), Refusal> {
    clear_win(justified)?;
    for outcome in flown_wins {
        // Asked for what passes, so that a NaN refuses.
        let as_good = outcome.p_value > WORSE_P_VALUE && outcome.explained.is_finite();
        if !as_good {
            return Err(Refusal::NoClearWin { p_value: 1.0 - outcome.p_value });
        }
    }
    let Promise { change_rad, posterior_rad, .. } = *promise;
    let worth_it = change_rad > REFINEMENT_SIGMAS * posterior_rad;
    if worth_it { Ok(()) } else { Err(Refusal::ChangeTooSmall { change_rad, sigma_rad: posterior_rad }) }
}

/// Whether a win counts: what it was won against is worse.
pub(crate) fn is_worse(win: &Outcome) -> bool {
    win.p_value <= WORSE_P_VALUE
}

/// Whether a P that a window contradicts wins again on those of its groups that did not teach it. Where they are too few for the limit it has
/// to win on every one; where there is none nothing speaks against it.
pub(crate) fn wins_again(outcome: &Outcome, groups: usize) -> bool {
    let least = 1.0 / (1_u32 << groups.min(MAX_GROUPS)) as f32;
    let rare = outcome.p_value <= MAX_P_VALUE || outcome.p_value <= least;
    groups == 0 || rare && outcome.explained >= LEAST_EXPLAINED
}

/// The part of the gate that a fitted bias has to pass as well: it wins beyond chance, what was missing is mainly what it has, and gravity does
/// not object.
#[inline(never)]
pub(crate) fn clear_win(outcome: &Outcome) -> Result<(), Refusal> {
    let Outcome { p_value, explained, objection, .. } = *outcome;
    // All are asked for what passes, so that a NaN refuses.
    let main = explained >= LEAST_EXPLAINED || outcome.is_noise();
    match (p_value <= MAX_P_VALUE, main, objection <= MOST_OBJECTION) {
        (true, true, true) => Ok(()),
        (true, true, false) => Err(Refusal::RotationDisagrees { sigmas: libm::sqrtf(objection) }),
        (true, false, _) => Err(Refusal::MisfitNotExplained { explained }),
        (false, ..) => Err(Refusal::NoClearWin { p_value }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WON: Outcome = Outcome { p_value: 0.001, explained: 0.9, over_noise: 30.0, objection: 0.0 };
    const GOOD: Evidence = Evidence { outcome: WON, promise: PROMISE, field_is_doubtful: false };
    const PROMISE: Promise =
        Promise { change_rad: 0.1, by_p_rad: 0.08, whole_rad: 3.0, jackknife_rad: 0.01, posterior_rad: 0.01 };

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
        let with = |promise: Promise| judge(&Evidence { promise, ..GOOD });
        assert!(matches!(with(Promise { change_rad: 0.02, ..PROMISE }), Err(Refusal::ChangeTooSmall { .. })));
        let small = Promise { change_rad: 0.004, jackknife_rad: 0.0, ..PROMISE };
        assert!(matches!(with(small), Err(Refusal::ChangeTooSmall { .. })));
        assert!(with(Promise { jackknife_rad: f32::NAN, ..PROMISE }).is_err());
    }

    #[test]
    fn where_nothing_but_noise_is_left_little_has_to_be_explained_and_little_to_change() {
        let of = |over_noise, change_rad| {
            let promise = Promise { change_rad, jackknife_rad: 1e-5, ..PROMISE };
            judge(&Evidence { outcome: Outcome { explained: 0.3, over_noise, ..WON }, promise, ..GOOD })
        };
        assert_eq!(of(1.9, 4e-4), Ok(()));
        assert!(matches!(of(1.9, 2e-4), Err(Refusal::ChangeTooSmall { .. })));
        for over_noise in [2.1, f32::NAN, f32::INFINITY] {
            assert!(matches!(of(over_noise, 0.1), Err(Refusal::MisfitNotExplained { .. })));
        }
    }

    #[test]
    fn where_the_field_is_doubtful_p_has_to_be_more_than_turned_axes_can_make() {
        let of = |outcome: Outcome, by_p_rad: f32, field_is_doubtful: bool| {
            judge(&Evidence { outcome, promise: Promise { by_p_rad, ..PROMISE }, field_is_doubtful })
        };
        // Three deviations of 0.01, 0.01 and 0.0052 of 3 rad are 0.0632.
        assert_eq!(of(WON, 0.063, true), Err(Refusal::FieldDoubtful));
        assert_eq!(of(WON, 0.0635, true), Ok(()));
        assert_eq!(of(WON, 0.063, false), Ok(()));
        assert_eq!(of(WON, f32::NAN, true), Err(Refusal::FieldDoubtful));
        for objection in [4.1, f32::NAN] {
            let objected = Outcome { objection, ..WON };
            assert!(matches!(of(objected, 0.063, false), Err(Refusal::RotationDisagrees { .. })));
            assert_eq!(of(objected, 0.0635, false), Ok(()), "the body's own accelerations");
        }
    }

    #[test]
    fn a_refinement_has_to_be_justified_no_worse_and_beyond_its_own_uncertainty() {
        let justified = GOOD.outcome;
        let even = Outcome { p_value: 0.5, explained: 0.0, ..WON };
        assert_eq!(judge_refinement(&justified, [even; 2], &PROMISE), Ok(()));
        assert!(judge_refinement(&even, [even; 2], &PROMISE).is_err());
        for worse in [Outcome { p_value: 0.01, ..even }, Outcome { explained: f32::NAN, ..even }] {
            assert!(judge_refinement(&justified, [even, worse], &PROMISE).is_err());
            assert!(judge_refinement(&justified, [worse, even], &PROMISE).is_err());
        }
        let unsure = Promise { posterior_rad: 0.11, ..PROMISE };
        assert!(matches!(judge_refinement(&justified, [even; 2], &unsure), Err(Refusal::ChangeTooSmall { .. })));
    }

    #[test]
    fn a_p_that_is_contradicted_wins_again_on_every_one_of_few_new_groups_or_clearly_on_many() {
        let outcome = |p_value, explained| Outcome { p_value, explained, ..WON };
        assert!(wins_again(&outcome(1.0 / 16.0, 0.99), 4), "four of four");
        assert!(!wins_again(&outcome(2.0 / 16.0, 0.99), 4), "one of four was lost");
        assert!(!wins_again(&outcome(1.0 / 16.0, 0.7), 4), "too little of the misfit");
        assert!(wins_again(&outcome(0.01, 0.8), 10));
        assert!(!wins_again(&outcome(0.05, 0.8), 10));
        assert!(!wins_again(&outcome(f32::NAN, 0.8), 10) && !wins_again(&outcome(0.001, f32::NAN), 10));
        assert!(wins_again(&outcome(f32::NAN, 0.0), 0), "nothing new");
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
