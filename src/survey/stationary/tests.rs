//! Stationary surveys at stops and their interruptions.

extern crate std;

use super::*;
use crate::survey::{Grade, Survey, Uncertain};
use std::vec::Vec;

const STEP_US: u64 = 10_000;

struct Rig {
    survey: StationarySurvey,
    switch: ToolfaceSwitch,
    config: SurveyConfig,
    t_us: u64,
}

impl Rig {
    fn new() -> Self {
        Self {
            survey: StationarySurvey::new(),
            switch: ToolfaceSwitch::new(),
            config: SurveyConfig::default(),
            t_us: 1_000_000,
        }
    }

    fn input(&self) -> SurveyInput {
        SurveyInput {
            t_us: self.t_us,
            rate_rad_s: Some([0.001, 0.0, -0.001]),
            // Inclination 30 deg, toolface 180 deg.
            force_m_s2: Some([-4.9, 0.0, -8.487]),
            field_ut: Some([20.0, 0.0, 45.0]),
            raw_accel_m_s2: [-5.0, 0.1, -8.5],
            raw_mag_ut: [21.0, 1.0, 44.0],
            temperature_c: Some(80.0),
            ..SurveyInput::default()
        }
    }

    /// Feeds `seconds` of changed samples. Returns the surveys that latched.
    fn feed(&mut self, seconds: f32, change: impl Fn(&mut SurveyInput)) -> Vec<SurveyReport> {
        let mut latched = Vec::new();
        for _ in 0..(seconds * 1e6 / STEP_US as f32) as u32 {
            self.t_us += STEP_US;
            let mut input = self.input();
            change(&mut input);
            let settings = (&Earth::default(), &self.config);
            latched.extend(self.survey.push(&input, &mut self.switch, settings));
        }
        latched
    }
}

#[test]
fn a_stop_gives_one_survey_with_its_time_and_its_six_axis_means() {
    let mut rig = Rig::new();
    assert!(rig.feed(1.4, |_| {}).is_empty());
    assert_eq!(rig.survey.state(), StationaryState::Moving);
    assert!(rig.feed(1.0, |_| {}).is_empty());
    assert_eq!(rig.survey.state(), StationaryState::Settling);
    let latched = rig.feed(60.0, |_| {});
    assert_eq!((latched.len(), rig.survey.state()), (1, StationaryState::Latched));
    let SurveyReport { survey, quality, averages } = latched[0];
    assert!((survey.inclination_rad.value.to_degrees() - 30.0).abs() < 0.01);
    assert!((survey.gravity_toolface_rad.unwrap().value.to_degrees() - 180.0).abs() < 1e-3);
    let length_s = (survey.t_end_us - survey.t_start_us) as f32 * 1e-6;
    assert!((length_s - 10.0).abs() < 0.02, "{length_s}");
    assert!(survey.t_start_us >= 1_000_000 + 6_490_000, "rest is seen after 1.5 s, settling takes 5");
    assert_eq!(averages.raw_accel_m_s2, [-5.0, 0.1, -8.5]);
    assert_eq!(averages.raw_mag_ut, Some([21.0, 1.0, 44.0]));
    assert_eq!((survey.temperature_c, quality.grade), (Some(80.0), Grade::Good));
    assert!((averages.samples as i32 - 1_001).abs() <= 1);
}

#[test]
fn motion_starts_it_over_and_the_next_stop_gives_the_next_survey() {
    let mut rig = Rig::new();
    assert!(rig.feed(12.0, |_| {}).is_empty());
    assert_eq!(rig.survey.state(), StationaryState::Averaging);
    assert!(rig.feed(0.1, |input| input.rate_rad_s = Some([0.0, 0.0, 1.0])).is_empty());
    assert_eq!(rig.survey.state(), StationaryState::Moving);
    assert!(rig.feed(15.0, |_| {}).is_empty(), "all of settling and averaging again");
    assert_eq!(rig.feed(3.0, |_| {}).len(), 1);
    rig.feed(1.0, |input| input.force_m_s2 = Some([5.0, 0.0, -8.0]));
    assert_eq!(rig.feed(30.0, |_| {}).len(), 1);
}

#[test]
fn a_blow_that_clips_and_a_pause_in_the_samples_start_it_over() {
    let mut rig = Rig::new();
    rig.feed(12.0, |_| {});
    rig.feed(0.01, |input| (input.accel_clipped, input.force_m_s2) = (true, None));
    assert_eq!(rig.survey.state(), StationaryState::Moving);
    rig.feed(12.0, |_| {});
    assert_eq!(rig.survey.state(), StationaryState::Averaging);
    rig.t_us += 200_000;
    rig.feed(0.01, |_| {});
    assert_eq!(rig.survey.state(), StationaryState::Moving);
    // One missing reading is not a pause.
    rig.feed(12.0, |_| {});
    rig.feed(0.01, |input| input.force_m_s2 = None);
    assert_eq!(rig.survey.state(), StationaryState::Averaging);
}

/// The first sample after a pause agrees with itself, however long the pause was.
#[test]
fn a_pause_is_no_evidence_of_rest() {
    for pause_us in [150_000, 2_000_000, 900_000_000] {
        let mut rig = Rig::new();
        rig.feed(12.0, |_| {});
        rig.t_us += pause_us;
        for _ in 0..10 {
            rig.feed(0.1, |_| {});
            assert!(!rig.survey.stands_still(rig.t_us), "{pause_us}");
        }
        rig.feed(2.0, |_| {});
        assert!(rig.survey.stands_still(rig.t_us), "{pause_us}");
    }
}

#[test]
fn a_turn_too_slow_for_the_gyro_gives_no_survey() {
    let mut rig = Rig::new();
    let start = rig.t_us;
    // 0.2 deg/s about the tool axis, as a string untwists; the gyro's threshold is 2 deg/s.
    let turning = move |input: &mut SurveyInput| {
        let angle = 0.0035 * (input.t_us - start) as f32 * 1e-6;
        let (s, c) = libm::sincosf(angle);
        input.force_m_s2 = Some([-4.9 * c, 4.9 * s, -8.487]);
        input.field_ut = Some([20.0 * c, -20.0 * s, 45.0]);
        input.rate_rad_s = Some([0.0, 0.0, 0.0035]);
    };
    assert!(rig.feed(120.0, turning).is_empty());
    assert_eq!(rig.feed(30.0, |_| {}).len(), 1);
}

#[test]
fn a_field_that_fails_for_seconds_leaves_inclination_and_toolface() {
    let mut rig = Rig::new();
    rig.feed(9.0, |_| {});
    rig.feed(3.0, |input| input.field_ut = None);
    let SurveyReport { survey, averages, .. } = rig.feed(20.0, |_| {})[0];
    assert!(survey.magnetic_azimuth_rad.is_none() && survey.field_ut.is_none() && averages.field_ut.is_none());
    assert!(survey.gravity_toolface_rad.is_some_and(|Uncertain { sigma, .. }| sigma < 0.01));
}

#[test]
fn a_field_that_turns_is_motion_whatever_a_dead_gyro_axis_reads() {
    let mut rig = Rig::new();
    rig.feed(5.0, |_| {});
    assert!(rig.survey.stands_still(rig.t_us));
    // Turning in a vertical hole: gravity and the dead gyro axis do not show it.
    for rpm in [3.0_f32, 30.0, 180.0] {
        let rate = rpm * core::f32::consts::TAU / 60.0;
        let mut times = 0;
        for k in 0..1_000 {
            let angle = rate * k as f32 * STEP_US as f32 * 1e-6;
            rig.feed(STEP_US as f32 * 1.000_1e-6, |input| {
                input.rate_rad_s = Some([0.001, 0.0, 0.0]);
                input.force_m_s2 = Some([0.0, 0.0, -9.8]);
                input.field_ut = Some([20.0 * libm::cosf(angle), 20.0 * libm::sinf(angle), 45.0]);
            });
            times += u32::from(k > 100 && rig.survey.stands_still(rig.t_us));
        }
        assert_eq!(times, 0, "{rpm} rpm");
        rig.feed(5.0, |_| {});
        assert!(rig.survey.stands_still(rig.t_us), "after {rpm} rpm");
    }
}

/// A field taken out along the axis may be wrong as the drill string's field of the error model may, and a force's
/// correction as a bias may: the same sigmas, from another source.
#[test]
fn the_uncertainty_of_a_correction_counts_as_an_error_of_the_reading_does() {
    let taken = |rig: &mut Rig, change: &dyn Fn(&mut SurveyInput)| {
        let found = rig.feed(30.0, change);
        found.first().expect("a survey").survey
    };
    let alone = taken(&mut Rig::new(), &|_| {});
    let mut stated = Rig::new();
    stated.config.errors.axial_interference_ut = libm::hypotf(stated.config.errors.axial_interference_ut, 0.7);
    stated.config.errors.accel_bias_m_s2 = libm::hypotf(stated.config.errors.accel_bias_m_s2, 0.03);
    let stated = taken(&mut stated, &|_| {});
    // The largest of an average counts: here it is that of its middle.
    let corrected = taken(&mut Rig::new(), &|input| {
        let sigma = if (14_000_000..18_000_000).contains(&input.t_us) { 1.0 } else { 0.2 };
        (input.field_correction_sigma_ut, input.force_correction_sigma_m_s2) =
            ([0.0, 0.0, 0.7 * sigma], [0.03 * sigma; 3]);
    });
    let sigmas = |survey: &Survey| {
        [Some(survey.inclination_rad), survey.magnetic_azimuth_rad, survey.gravity_m_s2, survey.dip_rad]
            .map(|angle| angle.map(|angle: Uncertain| angle.sigma).expect("measured"))
    };
    for ((corrected, stated), alone) in sigmas(&corrected).into_iter().zip(sigmas(&stated)).zip(sigmas(&alone)) {
        assert!((corrected / stated - 1.0).abs() < 1e-3, "{corrected} {stated}");
        assert!(corrected > 1.02 * alone, "{corrected} {alone}");
    }
}
