//! Standstill of the tool, as the gate of commands asks for it: only fresh readings of sound sensors show it.

use std::f64::consts::TAU;

use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    config::SurveyConfig,
    survey::{StationaryState, Surveyor},
};

use crate::tool::{Draw, into_tool};

const STEP_US: u64 = 5_000;
const TEN_MINUTES_US: u64 = 600_000_000;
const RESTS_S: f64 = 30.0;
/// Longest that a sensor's failure may go unnoticed: a frozen gyro is told from a quiet one within a second.
const NOTICED_S: f64 = 1.2;

/// A tool that rests until `RESTS_S` and is then drilled with at 60 rpm; `fail` spoils what it reads from
/// then on.
struct Tool {
    probe: Box<Probe>,
    surveyor: Surveyor,
    draw: Draw,
    last: Sample,
}

impl Tool {
    fn new() -> Self {
        let config = Config { sample_period_us: STEP_US as u32, ..Config::default() };
        let (mut probe, mut surveyor) = (Box::new(Probe::new()), Surveyor::new());
        probe.configure(&config).unwrap();
        surveyor.configure(&config.earth, &SurveyConfig::default()).unwrap();
        Self { probe, surveyor, draw: Draw::new(11), last: Sample::default() }
    }

    /// Reads once. Drilling turns the tool and shakes it by a g.
    fn read(&mut self, t_us: u64, drills: bool, fail: impl Fn(&mut Sample, &Sample)) {
        let t_s = t_us as f64 * 1e-6;
        let angle = if drills { TAU * t_s } else { 0.0 };
        let shaken = if drills { 10.0 } else { 0.01 };
        let force = into_tool([0.0, 0.0, -9.806_65], [0.7, 2.0, angle]);
        let field = into_tool([20.0, 0.0, 45.0], [0.7, 2.0, angle]);
        let noise = [self.draw.three(0.001), self.draw.three(shaken), self.draw.three(0.1)];
        let read = |v: [f64; 3], noise: [f64; 3]| std::array::from_fn(|k| (v[k] + noise[k]) as f32);
        let mut sample = Sample {
            t_us,
            gyro_rad_s: read([0.0, 0.0, if drills { TAU } else { 0.0 }], noise[0]),
            accel_m_s2: read(force, noise[1]),
            mag_ut: read(field, noise[2]),
            temperature_c: 60.0,
            ..Sample::default()
        };
        fail(&mut sample, &self.last);
        self.last = sample;
        if let Some(output) = self.probe.push(&sample) {
            self.surveyor.push(&self.probe.survey_input(&sample, &output));
        }
        self.probe.poll(self.probe.poll_budget());
    }

    /// Rests until a survey has been latched.
    fn rested() -> Self {
        let mut tool = Self::new();
        let steps = (RESTS_S * 1e6) as u64 / STEP_US;
        (1..=steps).for_each(|k| tool.read(k * STEP_US, false, |_, _| ()));
        assert_eq!(tool.surveyor.state(), StationaryState::Latched);
        assert!(tool.surveyor.stands_still(steps * STEP_US));
        tool
    }
}

/// Samples of ten minutes, once the failure must have been noticed, at which the gate would have let an erasure
/// through.
fn let_through(drills: bool, fail: impl Fn(&mut Sample, &Sample) + Copy) -> usize {
    let mut tool = Tool::rested();
    let begin = (RESTS_S * 1e6) as u64;
    let mut times = 0;
    for k in 1..=TEN_MINUTES_US / STEP_US {
        let t_us = begin + k * STEP_US;
        tool.read(t_us, drills, fail);
        let late = (t_us - begin) as f64 * 1e-6 > NOTICED_S;
        times += usize::from(late && tool.surveyor.stands_still(t_us));
    }
    times
}

#[test]
fn a_sensor_that_fails_at_rest_is_no_evidence_of_rest() {
    type Fail = fn(&mut Sample, &Sample);
    let failures: [(&str, Fail); 9] = [
        ("no accelerometer", |s, _| s.flags.insert(SampleFlags::ACCEL_MISSING)),
        ("no gyro", |s, _| s.flags.insert(SampleFlags::GYRO_MISSING)),
        ("accelerometer not a number", |s, _| s.accel_m_s2[1] = f32::NAN),
        ("gyro not a number", |s, _| s.gyro_rad_s[2] = f32::NAN),
        ("frozen accelerometer", |s, before| s.accel_m_s2 = before.accel_m_s2),
        ("frozen gyro", |s, before| s.gyro_rad_s = before.gyro_rad_s),
        ("fault", |s, _| s.flags.insert(SampleFlags::FAULT)),
        ("all frozen", |s, before| *s = Sample { t_us: s.t_us, ..*before }),
        ("time stands still", |s, before| s.t_us = before.t_us),
    ];
    for (name, fail) in failures {
        for drills in [true, false] {
            assert_eq!(let_through(drills, fail), 0, "{name}, drilling {drills}");
        }
    }
}

#[test]
fn a_tool_of_which_no_sample_comes_is_taken_for_drilling() {
    let tool = Tool::rested();
    let end_us = (RESTS_S * 1e6) as u64;
    assert!(tool.surveyor.stands_still(end_us + 50_000), "a round of the loop later");
    for silent_us in [1_000_000, 10_000_000, 600_000_000, u64::MAX - end_us] {
        assert!(!tool.surveyor.stands_still(end_us + silent_us), "{silent_us}");
    }
    // Nor does a sample that comes from the future tell of now.
    assert!(!tool.surveyor.stands_still(end_us - 5_000_000));
}

#[test]
fn a_sound_tool_at_rest_is_let_alone_to_be_commanded() {
    let mut tool = Tool::rested();
    let begin = (RESTS_S * 1e6) as u64;
    let mut still = 0;
    for k in 1..=2_000 {
        let t_us = begin + k * STEP_US;
        // One reading in twenty is missing, as supervision doubts some.
        tool.read(t_us, false, |s, _| s.flags.set(SampleFlags::ACCEL_MISSING, k % 20 == 0));
        still += u32::from(tool.surveyor.stands_still(t_us));
    }
    assert_eq!(still, 2_000);
    // The first turn ends it.
    (1..=20).for_each(|k| tool.read(begin + 10_000_000 + k * STEP_US, true, |_, _| ()));
    assert!(!tool.surveyor.stands_still(begin + 10_000_000 + 20 * STEP_US));
}

/// The clock goes back while the tool stands still, then drilling begins: the evidence is not fresh again when
/// the clock shows that time once more.
#[test]
fn evidence_of_rest_is_not_fresh_again_on_a_clock_that_goes_back() {
    let mut tool = Tool::rested();
    let begin = (RESTS_S * 1e6) as u64;
    tool.surveyor.restart();
    assert!((0..2 * begin).step_by(100_000).all(|now_us| !tool.surveyor.stands_still(now_us)));
    // A surveyor alone notices by its samples.
    let mut tool = Tool::rested();
    let late = meerkat_mwd::survey::SurveyInput { t_us: begin - 10_000_001, ..Default::default() };
    tool.surveyor.push(&late);
    assert!(!tool.surveyor.stands_still(begin));
}
