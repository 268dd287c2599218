//! Whatever comes in, a surveyor neither stops nor hands out what is not a number.

use meerkat_mwd::{
    attitude::{Attitude, AttitudeFlags},
    config::{Earth, SurveyConfig},
    survey::{Survey, SurveyInput, Surveyor, Uncertain},
};
use proptest::prelude::*;

fn component() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -12.0_f32..12.0,
        1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(0.0), Just(1e-30_f32), Just(9_999.0), Just(-1e30)],
    ]
}

fn vector() -> impl Strategy<Value = Option<[f32; 3]>> {
    proptest::option::weighted(0.9, [component(), component(), component()])
}

prop_compose! {
    fn input()(
        step_us in prop_oneof![8 => 1_000_u64..20_000, 1 => 0_u64..3_000_000],
        rate in vector(),
        force in vector(),
        field in vector(),
        clipped in proptest::bool::weighted(0.05),
        temperature in proptest::option::of(component()),
        angles in proptest::option::of([0.0_f32..3.2, 0.0..6.3, 0.0..6.3, 1e-4..3.2]),
        flags in any::<u16>(),
    ) -> (u64, SurveyInput) {
        let attitude = angles.map(|[inclination, azimuth, toolface, sigma]| Attitude {
            q: [0.5, 0.5, -0.5, 0.5],
            inclination_rad: inclination,
            azimuth_rad: azimuth,
            gravity_toolface_rad: toolface,
            magnetic_toolface_rad: toolface,
            sigma_inclination_rad: sigma,
            sigma_azimuth_rad: sigma,
            sigma_toolface_rad: sigma,
            flags: AttitudeFlags::from_bits_truncate(flags),
        });
        let input = SurveyInput {
            rate_rad_s: rate,
            force_m_s2: force,
            field_ut: field,
            accel_clipped: clipped,
            temperature_c: temperature,
            attitude,
            ..SurveyInput::default()
        };
        (step_us, input)
    }
}

fn finite(survey: &Survey) -> bool {
    let sound = |x: Uncertain| x.value.is_finite() && x.sigma >= 0.0 && x.sigma.is_finite();
    let optional = [
        survey.magnetic_azimuth_rad,
        survey.true_azimuth_rad,
        survey.grid_azimuth_rad,
        survey.gravity_toolface_rad,
        survey.magnetic_toolface_rad,
        survey.gravity_m_s2,
        survey.field_ut,
        survey.dip_rad,
    ];
    sound(survey.inclination_rad) && optional.into_iter().flatten().all(sound)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_stops_it_and_nothing_that_is_handed_out_is_not_a_number(
        inputs in proptest::collection::vec(input(), 1..400),
        // a steady reading for some seconds, so that surveys come about at all
        steady in input(),
        still in any::<bool>(),
    ) {
        let mut surveyor = Surveyor::new();
        prop_assert!(surveyor.push(&steady.1).is_empty(), "not configured");
        let mut config = SurveyConfig { settle_s: 0.05, average_s: 0.5, rotating_turns: 3, ..SurveyConfig::default() };
        config.grid_convergence_rad = Some(0.01);
        config.dynamics.window_s = 1.0;
        let earth = Earth { declination_rad: Some(0.1), magnetic_field_ut: Some(50.0), dip_rad: Some(1.2), ..Earth::default() };
        surveyor.configure(&earth, &config).unwrap();
        let mut t_us = 0;
        let mut steady = steady;
        if still {
            (steady.1.rate_rad_s, steady.1.accel_clipped) = (Some([0.0; 3]), false);
        }
        let repeated = std::iter::repeat_n(&steady, 400);
        for (step_us, input) in inputs.iter().chain(repeated).chain(inputs.iter()) {
            t_us += step_us;
            surveyor.push(&SurveyInput { t_us, ..*input });
            let reports = [surveyor.stationary(), surveyor.rotating()];
            for report in reports.into_iter().flatten() {
                prop_assert!(finite(&report.survey), "{report:?}");
            }
            if let Some(survey) = surveyor.continuous() {
                prop_assert!(finite(&survey), "{survey:?}");
            }
            if let Some(d) = surveyor.dynamics() {
                let numbers = [d.axial_rms_m_s2, d.lateral_rms_m_s2, d.peak_m_s2];
                prop_assert!(numbers.into_iter().flatten().all(f32::is_finite), "{d:?}");
                let index = d.rotation.and_then(|rotation| rotation.stick_slip_index);
                prop_assert!(index.is_none_or(f32::is_finite), "{d:?}");
            }
        }
    }
}
