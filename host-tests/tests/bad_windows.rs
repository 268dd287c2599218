//! One window of simulated drilling with a sensor, the clock or the configuration wrong throughout: refused
//! for that reason, or accepted and better than doing nothing.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    compensation::GyroModel,
    identification::{Refusal, WindowReport},
};
use testbed::{
    flight::fly,
    simulate::{Contamination, contaminate},
};

use rig::run::{Dice, Run, flown, refusal, run, saturated};

/// Least share of the window lost to a frozen sensor: it takes a second to be recognised.
const SHARE_FROZEN: f32 = 0.97;

const SEEDS: core::ops::RangeInclusive<u64> = 1..=5;

/// Runs of 10 s at rest and 50 s of drilling: one window, whose result flies for the last five.
fn runs() -> impl Iterator<Item = Run> {
    SEEDS.map(|seed| run(60.0, seed))
}

/// The report of the only window, after checking what holds of every report.
fn window(run: &Run, config: &Config, samples: &[Sample]) -> WindowReport {
    let flight = flown(config, samples);
    assert_eq!(flight.reports.len(), 1, "{:?}", flight.reports);
    let report = flight.reports[0];
    sound(run, &report);
    report
}

/// Checks that what flies is at most a tenth worse than bias only; the rig has checked that all is finite. Where a bad
/// window is refused its bias is wrong, and by chance it may leave less than the true one, which a rest has shown.
fn sound(run: &Run, report: &WindowReport) {
    let [bias_only, _, flown] = run.rate_errors_deg_s(report);
    let true_bias = GyroModel { b_rad_s: run.truth.gyro.b_rad_s, ..run.config.gyro };
    let bias_only = bias_only.max(run.rate_error_deg_s(&true_bias));
    assert!(bias_only.is_finite() && flown <= 1.1 * bias_only, "{flown} against {bias_only} deg/s: {report:?}");
}

/// Rms error of a model on these very samples against the true rates, deg/s.
fn error_as_read(run: &Run, samples: &[Sample], model: &GyroModel) -> f64 {
    let rates = run.trace.true_rate.as_ref().unwrap();
    let square = |(sample, rate): (&Sample, &[f64; 3])| {
        let read = <[f32; 3]>::from(model.compensate(sample.gyro_rad_s));
        read.iter().zip(rate).map(|(read, truth)| (f64::from(*read) - truth).powi(2)).sum::<f64>()
    };
    let sum: f64 = samples.iter().zip(rates).map(square).sum();
    (sum / (3.0 * rates.len() as f64)).sqrt().to_degrees()
}

/// Checks that the window is refused for this reason with every seed, and that the factory's P flies on.
fn refused(spoil: impl Fn(&Run) -> Vec<Sample>, expected: impl Fn(&Refusal) -> bool) {
    for run in runs() {
        let report = window(&run, &run.config, &spoil(&run));
        assert!(refusal(&report).as_ref().is_some_and(&expected), "{report:?}");
        assert_eq!(report.flown.p, run.config.gyro.p, "{report:?}");
    }
}

/// Checks that whatever is decided is no worse than bias only.
fn harmless(spoil: impl Fn(&Run) -> Vec<Sample>) {
    for run in runs() {
        let report = window(&run, &run.config, &spoil(&run));
        let [bias_only, _, flown] = run.rate_errors_deg_s(&report);
        println!("{bias_only:.3} -> {flown:.3} deg/s {:?}", report.decision);
    }
}

/// Full scale that clips a share of the run's samples.
fn full_scale_that_clips(run: &Run, share: f64) -> f32 {
    let largest = |s: &Sample| s.gyro_rad_s.iter().map(|x| x.abs()).max_by(f32::total_cmp).unwrap();
    let mut sorted: Vec<f32> = run.trace.samples.iter().map(largest).collect();
    sorted.sort_by(f32::total_cmp);
    sorted[((1.0 - share) * sorted.len() as f64) as usize]
}

/// Stick-slip clips every fast phase, so the slow half of the motion remains.
#[test]
fn a_gyro_that_clips_three_tenths_of_the_time_bends_nothing() {
    for mut run in runs() {
        let limit = full_scale_that_clips(&run, 0.3);
        run.config.full_scale.gyro_rad_s = Some(limit);
        let samples = run.with(|_, s| s.gyro_rad_s = saturated(s.gyro_rad_s, limit));
        let report = window(&run, &run.config, &samples);
        println!("{:?} {:?}", run.rate_errors_deg_s(&report), report.decision);
    }
}

#[test]
fn a_gyro_that_reads_one_rate_is_unusable() {
    for kept in [0, 3_000] {
        refused(
            |run| run.with(|_, s| s.gyro_rad_s = run.trace.samples[kept].gyro_rad_s),
            |why| matches!(why, Refusal::GyroUnusable { share } if *share > SHARE_FROZEN),
        );
    }
}

/// A dead gyro with noise is not frozen: it reads a tool at rest while field and gravity turn, so no P is
/// right.
#[test]
fn a_gyro_of_noise_alone_gives_no_p() {
    refused(
        |run| {
            let mut dice = Dice::new(1);
            run.with(|_, s| s.gyro_rad_s = [0.0; 3].map(|_: f32| 0.01 * dice.roll() as f32))
        },
        |_| true,
    );
}

/// The axis along the tool turns at 180 deg/s on average: without it no P explains gravity and field.
#[test]
fn without_the_axis_along_the_tool_no_p_is_taken() {
    for frozen_at in [None, Some(0), Some(3_000)] {
        refused(
            |run| {
                let kept = frozen_at.map_or(0.0, |at: usize| run.trace.samples[at].gyro_rad_s[2]);
                run.with(|_, s| s.gyro_rad_s[2] = kept)
            },
            |_| true,
        );
    }
}

/// A lateral axis turns little: an accepted P is right for what the gyro reads now.
#[test]
fn a_frozen_lateral_axis_leaves_a_model_that_suits_what_is_read() {
    for run in runs() {
        for axis in [0, 1] {
            for kept in [0.0, run.trace.samples[0].gyro_rad_s[axis], run.trace.samples[3_000].gyro_rad_s[axis]] {
                let samples = run.with(|_, s| s.gyro_rad_s[axis] = kept);
                let report = window(&run, &run.config, &samples);
                let [bias_only, flown] =
                    [report.bias_only, report.flown].map(|model| error_as_read(&run, &samples, &model));
                println!("axis {axis} at {kept:.3}: {bias_only:.2} -> {flown:.2} deg/s {:?}", report.decision);
                assert!(flown <= 1.1 * bias_only);
            }
        }
    }
}

/// Zeros, a constant as from a hung bus, and no readings: only gravity determines P.
#[test]
fn a_magnetometer_without_a_field_harms_nothing() {
    harmless(|run| run.with(|_, s| s.mag_ut = [0.0; 3]));
    harmless(|run| run.with(|_, s| s.mag_ut = [20.0, -3.0, 45.0]));
    harmless(|run| run.with(|_, s| s.mag_ut = run.trace.samples[3_000].mag_ut));
    harmless(|run| run.with(|_, s| s.flags |= SampleFlags::MAG_MISSING));
    harmless(|run| run.with(|_, s| s.mag_ut = [f32::NAN; 3]));
}

/// Clamped by a magnet the magnetometer reads hard iron and noise: P comes from gravity or not at all.
#[test]
fn a_magnetometer_of_one_reading_and_noise_harms_nothing() {
    harmless(|run| {
        let mut dice = Dice::new(2);
        run.with(|_, s| s.mag_ut = [20.0, 10.0, 40.0].map(|x: f32| x + dice.roll() as f32))
    });
}

#[test]
fn a_field_that_is_disturbed_for_three_tenths_of_the_time_is_left_out_of_it() {
    let kinds = [Contamination::CasingJoints, Contamination::MagneticBursts, Contamination::AttitudeDependent];
    let (mut as_good, mut all) = (0, 0);
    for run in (1..=8).map(|seed| run(60.0, seed)) {
        let error = |samples: &[Sample]| run.rate_errors_deg_s(&window(&run, &run.config, samples))[2];
        let clean = error(&run.trace.samples);
        let drilling = run.trace.samples.len() / 6..run.trace.samples.len();
        for kind in kinds {
            let (hit, _) = contaminate(&run.trace, kind, 0.3, &drilling, 7);
            let with_hits = error(&hit.samples);
            println!("{kind:?}: {with_hits:.3} deg/s, clean {clean:.3}");
            as_good += usize::from(with_hits < 2.0 * clean);
            all += 1;
        }
    }
    // A sensor that is taken for the field leaves one window in six.
    assert!(4 * as_good >= 3 * all, "{as_good} of {all}");
}

#[test]
fn an_accelerometer_without_gravity_is_none() {
    let none = |why: &Refusal| *why == Refusal::NoAccelerometer;
    refused(|run| run.with(|_, s| s.accel_m_s2 = [0.0; 3]), none);
    for kept in [0, 3_000] {
        refused(|run| run.with(|_, s| s.accel_m_s2 = run.trace.samples[kept].accel_m_s2), none);
    }
    refused(|run| run.with(|_, s| s.flags |= SampleFlags::ACCEL_MISSING), none);
}

#[test]
fn when_every_channel_is_constant_the_gyro_is_to_blame() {
    for kept in [0, 3_000] {
        refused(
            |run| run.with(|_, s| *s = Sample { t_us: s.t_us, ..run.trace.samples[kept] }),
            |why| matches!(why, Refusal::GyroUnusable { share } if *share > SHARE_FROZEN),
        );
    }
}

/// Gaps of 70 ms, from four in ten seconds to one in the minute.
#[test]
fn gaps_bend_no_window() {
    for run in runs() {
        for every_s in [2.5, 10.0, 25.0, 30.0] {
            let is_lost = |s: &Sample| s.t_us > 1_000_000 && (s.t_us as f64 * 1e-6) % every_s < 0.059;
            let kept: Vec<Sample> = run.trace.samples.iter().filter(|s| !is_lost(s)).copied().collect();
            let flight = flown(&run.config, &kept);
            assert_eq!(f64::from(flight.counters.gaps), (59.9 / every_s).floor());
            assert_eq!(flight.reports.len(), 1);
            sound(&run, &flight.reports[0]);
        }
    }
}

/// A prior that trusts the factory's P keeps it; a vague one leaves P to the window; sigmas beyond any part's
/// are refused by name.
#[test]
fn prior_sigmas_of_any_size_are_believed_or_refused() {
    for run in runs() {
        for sigma in [1e-30, 1e-10, 9e-7, 1e-6, 1e-5, 1e-3, 1e-2, 0.1, 1.0, 1.1, 1e3, 1e30_f32] {
            let mut config = run.config;
            config.identification.prior_sigma_diagonal = sigma;
            config.identification.prior_sigma_off_diagonal = sigma;
            config.identification.prior_sigma_bias_rad_s = sigma;
            if !(1e-6..=1.0).contains(&sigma) {
                let error = fly(&config, &[], |_| {}).unwrap_err();
                assert_eq!(error.field, "identification.prior_sigma_*", "{sigma}");
                continue;
            }
            let report = window(&run, &config, &run.trace.samples);
            assert!(sigma != 1.0 || run.identified(&report), "{sigma}: {report:?}");
        }
    }
}

/// A tight prior on the bias alone, or on the couplings alone, keeps those where they are.
#[test]
fn one_prior_sigma_that_is_far_too_small_is_no_harm() {
    for run in runs() {
        for sigma in [1e-6, 1e-5, 1e-3] {
            let mut bias = run.config;
            bias.identification.prior_sigma_bias_rad_s = sigma;
            window(&run, &bias, &run.trace.samples);
            let mut coupling = run.config;
            coupling.identification.prior_sigma_off_diagonal = sigma;
            let report = window(&run, &coupling, &run.trace.samples);
            let couplings = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)].map(|(i, j)| report.flown.p[i][j].abs());
            assert!(couplings.iter().all(|p| *p <= 5.0 * sigma), "{sigma}: {report:?}");
        }
    }
}

/// The gyro's noise and how it walks, from nothing to far beyond any gyro's.
#[test]
fn any_noise_of_the_gyro_that_is_configured_leaves_a_sound_report() {
    for run in runs() {
        for value in [1e-30, 1e-12, 1e-10, 1e-6, 1e-3, 1.0_f32] {
            let mut noise = run.config;
            noise.attitude.gyro_noise_rad_s_rthz = value;
            let mut walk = run.config;
            walk.attitude.gyro_bias_walk_rad_s_rts = value;
            let mut forgetting = run.config;
            forgetting.identification.forgetting_s = value;
            for config in [noise, walk, forgetting] {
                let report = window(&run, &config, &run.trace.samples);
                // A gyro with a noise of a radian a second says nothing.
                let is_blind = config.attitude.gyro_noise_rad_s_rthz > 0.01;
                assert!(is_blind || run.identified(&report), "{value}: {report:?}");
            }
        }
    }
}
