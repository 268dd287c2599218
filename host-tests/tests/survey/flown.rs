//! Surveys of a whole probe: rotation, then rest, through `Probe` and `Surveyor` together.

use std::f64::consts::TAU;

use meerkat_mwd::{
    Config, Probe, Sample,
    config::{DynamicsConfig, SurveyConfig},
    survey::{Grade, SurveyNews, Surveyor},
};

use crate::tool::{Draw, into_tool};

const STEP_US: u64 = 10_000;
const ROTATES_S: f64 = 40.0;
/// 60 rpm.
const SPEED_RAD_S: f64 = TAU;

fn apart_deg(a: f32, b: f64) -> f64 {
    libm::remainder(f64::from(a) - b, TAU).to_degrees().abs()
}

#[test]
fn a_probe_that_rotates_and_then_rests_gives_surveys_of_every_kind_that_agree() {
    let (inclination, azimuth, last_toolface) = (0.7, 2.0, 0.3);
    let (mut probe, mut surveyor) = (Box::new(Probe::new()), Surveyor::new());
    let mut config = Config { sample_period_us: STEP_US as u32, ..Config::default() };
    let dip = 66.0_f64.to_radians();
    config.earth.magnetic_field_ut = Some(50.0);
    config.earth.dip_rad = Some(dip as f32);
    config.earth.declination_rad = Some(0.05);
    probe.configure(&config).unwrap();
    // Ten windows, after which the dose is told, in the time of this run.
    let dynamics = DynamicsConfig { window_s: 6.0, ..DynamicsConfig::default() };
    surveyor.configure(&config.earth, &SurveyConfig { dynamics, ..SurveyConfig::default() }).unwrap();

    let mut draw = Draw::new(5);
    let mut seen = SurveyNews::empty();
    let mut rotating = None;
    for k in 1..=7_500 {
        let t_s = k as f64 * STEP_US as f64 * 1e-6;
        // the last second of rotation slows down evenly
        let (rate, angle) = if t_s < ROTATES_S {
            (SPEED_RAD_S, SPEED_RAD_S * t_s)
        } else if t_s < ROTATES_S + 1.0 {
            let s = t_s - ROTATES_S;
            (SPEED_RAD_S * (1.0 - s), SPEED_RAD_S * (ROTATES_S + s - 0.5 * s * s))
        } else {
            (0.0, SPEED_RAD_S * (ROTATES_S + 0.5))
        };
        let toolface = last_toolface + angle - SPEED_RAD_S * (ROTATES_S + 0.5);
        let attitude = [inclination, azimuth, toolface];
        let force = into_tool([0.0, 0.0, -9.806_65], attitude);
        let field = into_tool([50.0 * dip.cos(), 0.0, 50.0 * dip.sin()], attitude);
        let noise = [draw.three(0.001), draw.three(0.01), draw.three(0.1)];
        let read = |v: [f64; 3], noise: [f64; 3]| std::array::from_fn(|k| (v[k] + noise[k]) as f32);
        let sample = Sample {
            t_us: k * STEP_US,
            gyro_rad_s: read([0.0, 0.0, rate], noise[0]),
            accel_m_s2: read(force, noise[1]),
            mag_ut: read(field, noise[2]),
            temperature_c: 60.0,
            ..Sample::default()
        };
        let output = probe.push(&sample).unwrap();
        let input = probe.survey_input(&sample, &output);
        probe.poll(probe.poll_budget());
        let news = surveyor.push(&input);
        if news.contains(SurveyNews::ROTATING) {
            rotating = surveyor.rotating().copied();
        }
        seen |= news;
    }
    assert_eq!(seen, SurveyNews::all());

    let stationary = surveyor.stationary().unwrap();
    let continuous = surveyor.continuous().unwrap();
    let rotating = rotating.unwrap();
    for (name, survey, bound_deg) in
        [("stationary", stationary.survey, 0.05), ("rotating", rotating.survey, 0.1), ("continuous", continuous, 1.0)]
    {
        let magnetic = survey.magnetic_azimuth_rad.unwrap();
        println!(
            "{name}: inclination off by {:.3} deg, azimuth by {:.3} deg (stated {:.3}, {:.3})",
            apart_deg(survey.inclination_rad.value, inclination),
            apart_deg(magnetic.value, azimuth),
            survey.inclination_rad.sigma.to_degrees(),
            magnetic.sigma.to_degrees(),
        );
        assert!(apart_deg(survey.inclination_rad.value, inclination) < bound_deg, "{name}");
        assert!(apart_deg(magnetic.value, azimuth) < bound_deg, "{name}");
        assert!(apart_deg(survey.true_azimuth_rad.unwrap().value, azimuth + 0.05) < bound_deg, "{name}");
    }
    assert_eq!((stationary.quality.grade, rotating.quality.grade), (Grade::Good, Grade::Good));
    assert!(apart_deg(stationary.survey.toolface_rad().unwrap().value, last_toolface) < 0.05);
    assert!(stationary.survey.t_start_us > 46_000_000 && rotating.survey.t_end_us < 42_000_000);
    assert!((f64::from(stationary.averages.raw_accel_m_s2[2]) + 9.806_65 * inclination.cos()).abs() < 0.01);
}
