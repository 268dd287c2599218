use meerkat_mwd::{
    compensation::effects::LIBRARY,
    diagnosis::{DiagnosisReport, Verdict},
    identification::Decision,
    magnet::HardIronInterval,
    survey::{
        DrillingDynamics, Grade, Rotation, SlidingToolface, SurveyReport, ToolfaceKind, VibrationDose, WhirlKind,
        severity::LEVELS,
    },
    telemetry::{AttitudeFrame, CompactAngles, Health, LinkCounters},
};

use super::{
    self_test::self_test_text,
    state::{State, flags_text},
};
use crate::report::{plain_words::use_of_field, refusal_text::refusal_text};

/// Standard gravity, m/s^2.
const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;

/// Summary of what was received, one line a subject; no lines if no frame came.
#[must_use]
pub fn summary_lines(state: &State) -> Vec<String> {
    if state.link.frames == 0 {
        return Vec::new();
    }
    let mut lines = Vec::new();
    if let Some(boot) = &state.boot {
        let [major, minor, patch] = boot.version;
        let model = boot.restored_model.map_or_else(|| "the factory's model".into(), |n| format!("stored model {n}"));
        let watchdog = boot.watchdog_resets;
        lines.push(format!(
            "probe     firmware {major}.{minor}.{patch}, started by {:?} with {model}, {watchdog} resets by the watchdog",
            boot.reset
        ));
    }
    if let Some(attitude) = &state.attitude {
        lines.push(format!("attitude  {}", attitude_text(attitude)));
    }
    lines.extend(state.survey.as_ref().map(|survey| format!("survey    {}", survey_text(survey))));
    lines.extend(state.toolface.as_ref().map(|toolface| format!("sliding   {}", sliding_text(toolface))));
    lines.extend(state.dynamics.as_ref().map(|dynamics| format!("drilling  {}", dynamics_text(dynamics))));
    lines.extend(state.dose.as_ref().map(|dose| format!("dose      {}", dose_text(dose))));
    lines.extend(burst_text(state).map(|text| format!("burst     {text}")));
    lines.push(format!("model     {}", model_text(state)));
    lines.extend(state.diagnosis.as_ref().map(|diagnosis| format!("diagnosis {}", diagnosis_text(diagnosis))));
    lines.extend(state.hard_iron.as_ref().map(|interval| format!("magnet    {}", magnet_text(interval))));
    lines.extend(state.health.as_ref().map(|health| format!("health    {}", health_text(health))));
    if state.samples > 0 {
        lines.push(format!("recording {} raw samples", state.samples));
    }
    let LinkCounters { frames, bad, oversize, lost, restarts } = state.link;
    let unknown = state.not_understood;
    lines.push(format!(
        "link      {frames} frames, {bad} damaged, {oversize} oversize, {lost} missing, {restarts} restarts, {unknown} of another version"
    ));
    lines
}

fn attitude_text(attitude: &AttitudeFrame) -> String {
    let t_s = attitude.t_us as f64 * 1e-6;
    attitude.angles.as_ref().map_or_else(
        || format!("t {t_s:.3} s: not aligned yet"),
        |angles| format!("t {t_s:.3} s: {}", angles_text(angles).join(", ")),
    )
}

/// Inclination, azimuth and toolface with their deviations, and the flags if there are any.
pub(super) fn angles_text(angles: &CompactAngles) -> Vec<String> {
    let [sigma_inclination, sigma_azimuth, sigma_toolface] = angles.sigmas_rad().map(f32::to_degrees);
    let (kind, toolface) = toolface(angles);
    let mut parts = vec![
        format!("inclination {:.2} +- {sigma_inclination:.2} deg", angles.inclination_rad().to_degrees()),
        format!("azimuth {:.2} +- {sigma_azimuth:.2} deg", angles.azimuth_rad().to_degrees()),
        format!("{kind} toolface {:.1} +- {sigma_toolface:.1} deg", toolface.to_degrees()),
    ];
    let flags = flags_text(angles.flags());
    if !flags.is_empty() {
        parts.push(flags);
    }
    parts
}

/// Name and value of the toolface that applies, radians.
pub(super) fn toolface(angles: &CompactAngles) -> (&'static str, f32) {
    if angles.flags().contains(meerkat_mwd::attitude::AttitudeFlags::NEAR_VERTICAL) {
        ("magnetic", angles.magnetic_toolface_rad())
    } else {
        ("gravity", angles.gravity_toolface_rad())
    }
}

pub(super) const fn grade_text(grade: Grade) -> &'static str {
    match grade {
        Grade::Good => "good",
        Grade::Doubtful => "doubtful",
        _ => "bad",
    }
}

pub(super) fn survey_text(report: &SurveyReport) -> String {
    let survey = &report.survey;
    let t_s = survey.t_end_us as f64 * 1e-6;
    let inclination = survey.inclination_rad.value.to_degrees();
    let azimuth =
        survey.magnetic_azimuth_rad.map_or_else(|| "none".into(), |x| format!("{:.2} deg", x.value.to_degrees()));
    let grade = grade_text(report.quality.grade);
    format!("t {t_s:.3} s, {:?}: inclination {inclination:.2} deg, azimuth {azimuth}, {grade}", survey.kind)
}

pub(super) fn model_text(state: &State) -> String {
    let age = state.model_age_s().map_or_else(|| "as at the start".into(), |age| format!("accepted {age:.1} s ago"));
    state.identification.as_ref().map_or_else(
        || format!("{age}; no window yet"),
        |identification| {
            let report = &identification.report;
            let t_s = report.t_end_us as f64 * 1e-6;
            match &report.decision {
                Decision::Accepted => {
                    format!("{age}; the window to {t_s:.1} s was accepted, rank {} of 12", report.rank)
                }
                Decision::Refused(why) => format!("{age}; the window to {t_s:.1} s was refused: {}", refusal_text(why)),
                _ => age.clone(),
            }
        },
    )
}

/// The mean toolface by which one steers a motor, and how old it was when the probe gave it.
pub(super) fn sliding_text(toolface: &SlidingToolface) -> String {
    let degrees = |rad: f32| rad.to_degrees();
    let kind = if toolface.kind == ToolfaceKind::Magnetic { "magnetic" } else { "gravity" };
    format!(
        "to t {:.1} s: {kind} toolface {:.1} +- {:.1} deg, swung {:.1} deg, {:.1} s old when given",
        toolface.t_end_us as f64 * 1e-6,
        degrees(toolface.toolface_rad.value),
        degrees(toolface.toolface_rad.sigma),
        degrees(toolface.swing_rad),
        toolface.latency_s
    )
}

/// Vibration with its levels, shocks, stick-slip and whirl of one window.
pub(super) fn dynamics_text(dynamics: &DrillingDynamics) -> String {
    let with_level = |rms: Option<f32>, level: Option<u8>| match (rms, level) {
        (Some(rms), Some(level)) => format!("{:.2} g (level {level})", rms / STANDARD_GRAVITY_M_S2),
        _ => "unknown".to_owned(),
    };
    let mut text = format!(
        "to t {:.1} s: axial {}, lateral {}, {} shocks",
        dynamics.t_end_us as f64 * 1e-6,
        with_level(dynamics.axial_rms_m_s2, dynamics.axial_severity()),
        with_level(dynamics.lateral_rms_m_s2, dynamics.lateral_severity()),
        dynamics.shocks
    );
    if let Some(rotation) = &dynamics.rotation {
        text += &format!(", {:.0} rpm", rotation.mean_rpm);
    }
    if let Some(level) = dynamics.rotation.as_ref().and_then(Rotation::stick_slip_severity) {
        text += &format!(", stick-slip level {level}");
    }
    match dynamics.whirl_kind() {
        Some(WhirlKind::Forward) => text += ", forward whirl",
        Some(WhirlKind::Backward) => text += ", backward whirl",
        None => {}
    }
    text
}

/// Time from each level on, and shocks.
pub(super) fn dose_text(dose: &VibrationDose) -> String {
    let from_level = |times: &[f32; LEVELS], level: usize| {
        let seconds: f32 = times.iter().skip(level).sum();
        f64::from(seconds) / 60.0
    };
    let VibrationDose { axial_s, lateral_s, stick_slip_s, shocks, shocks_over: [over, far_over, farthest_over] } = dose;
    format!(
        "level 3 and above: axial {:.1} min, lateral {:.1} min, stick-slip {:.1} min; of {:.1} min in all; {shocks} shocks, \
         {over} over 2.5, {far_over} over 5 and {farthest_over} over 10 times the level of a shock",
        from_level(axial_s, 3),
        from_level(lateral_s, 3),
        from_level(stick_slip_s, 3),
        from_level(lateral_s, 0)
    )
}

/// Text on the worst second, as far as it has come; `None` if nothing has.
pub(super) fn burst_text(state: &State) -> Option<String> {
    let (of, rms_m_s2) = state.burst_of?;
    let begin_s = state.burst.first()?.t_us as f64 * 1e-6;
    Some(format!(
        "worst second from t {begin_s:.3} s: {:.2} g rms about its mean, {} of {of} raw samples",
        rms_m_s2 / STANDARD_GRAVITY_M_S2,
        state.burst.len()
    ))
}

pub(super) fn diagnosis_text(report: &DiagnosisReport) -> String {
    let verdict = match report.verdict {
        Verdict::NotEnoughExcitation => "not enough excitation",
        Verdict::ModelSufficient => "model sufficient",
        Verdict::EffectsFound => "effects found",
        _ => "unexplained residual",
    };
    let names: Vec<&str> = report
        .found()
        .map(|effect| LIBRARY.get(usize::from(effect.found.index)).map_or("another version's", |found| found.name()))
        .collect();
    let found = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
    format!("t {:.1} s, {verdict}{found}", report.t_end_us as f64 * 1e-6)
}

/// Size of a magnet's field, when it came and left, and what is done about it.
pub(super) fn magnet_text(interval: &HardIronInterval) -> String {
    let until = interval.to_us.map_or_else(|| "on".to_owned(), |to_us| format!("to {:.1} s", to_us as f64 * 1e-6));
    let from_s = interval.from_us as f64 * 1e-6;
    format!("{:.1} uT from {from_s:.1} s {until}, {}", interval.offset().norm(), use_of_field(interval))
}

pub(super) fn health_text(health: &Health) -> String {
    let Health { counters, sent, .. } = health;
    format!(
        "t {:.1} s, {} samples, {} gaps, {} clipped, {} sample overruns, {} windows late; worst delay {} us; stack {} of {} bytes; \
         {} attitudes and {} samples given up, {} results refused{}",
        health.t_us as f64 * 1e-6,
        counters.samples,
        counters.gaps,
        counters.clipped,
        health.sample_overruns,
        counters.overruns,
        health.worst_delay_us,
        health.stack_used_bytes,
        health.stack_size_bytes,
        sent.attitude_dropped,
        sent.samples_dropped,
        sent.results_refused,
        health.self_test.map_or_else(String::new, |test| format!("; self-test {}", self_test_text(&test)))
    )
}
