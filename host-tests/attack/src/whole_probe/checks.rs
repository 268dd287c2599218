//! Checks of what has to hold, made with every message that is heard and after every round of the program.

use super::{
    EVIDENCE_S,
    machine::{HEALTH, Machine},
    plan::Trouble,
    tally::Violation,
};
use meerkat_mwd::{
    application::{Application, Board},
    attitude::AttitudeFlags,
    compensation::{ActiveEffects, GyroModel},
    survey::{SurveyKind, SurveyReport},
    telemetry::{AttitudeFrame, Boot, CompactAngles, Health, MAX_FRAME, Message},
};
use std::f64::consts::TAU;

/// Deviations within which an attitude has to be.
const SIGMAS: f64 = 5.0;
/// Error of the angles' encoding, radians: half a step of angle, and half a step of sigma five times.
const STEP_RAD: f64 = 0.5 * TAU / 65_536.0 + 2.5e-4;
/// Time after the start and the last fault of sensors, clock or computing time from which it has to be, microseconds:
/// no P is learnt from less than 14 s of motion, which with stops, a window of 10 s and its latency take this long.
const SETTLED_US: u64 = 30_000_000;
/// Age of a stationary survey at which it has to be on the line, microseconds.
const SURVEY_US: u64 = 1_000_000;

/// A message of the probe.
pub fn heard(machine: &mut Machine<'_, '_>, message: &Message) {
    match message {
        Message::Acknowledgement(answer) => {
            machine.day.tally.now_us = machine.chip.now_us.get();
            machine.day.host.answered(answer, &mut machine.day.tally);
        }
        Message::Boot(boot) => started(machine, boot),
        Message::Attitude(frame) => attitude(machine, frame),
        Message::Survey(report) => survey(machine, report),
        Message::Health(report) => health(machine, report),
        Message::Identification(it) => machine.day.host.window_end_us = it.report.t_end_us,
        _ => {}
    }
}

/// A start of the program, before the first sample.
pub fn configured(application: &mut Application<'_, Machine<'_, '_>>) {
    let config = *application.statics().probe.config();
    let machine = application.board();
    if machine.chip.is_dead() {
        return;
    }
    let is_set = machine.day.host.has_set(&config);
    note(machine, Violation::SettingsLost, is_set, || format!("seed {}", config.seed));
}

fn note(machine: &mut Machine<'_, '_>, what: Violation, holds: bool, words: impl FnOnce() -> String) {
    let tally = &mut machine.day.tally;
    tally.now_us = machine.chip.now_us.get();
    tally.checked(what);
    if !holds {
        let struck: Vec<_> =
            (machine.day.struck.iter().rev()).filter(|(_, it)| *it != Trouble::Owner).take(4).collect();
        let started_us = machine.chip.started_us.get();
        tally.violated(what, || format!("{}; started at {started_us} us; struck {struck:?}", words()));
    }
}

/// Counts something, and whether it is outside its deviations.
fn count([all, outside]: &mut [u64; 2], holds: bool) {
    *all += 1;
    *outside += u64::from(!holds);
}

/// P and b of the model that was restored flew when it was stored.
fn started(machine: &mut Machine<'_, '_>, boot: &Boot) {
    // A command has started the pipeline afresh; without a new first sample the boot is said again.
    if std::mem::replace(&mut machine.first_sample, boot.first_sample) != boot.first_sample {
        machine.boot_us = machine.chip.now_us.get();
    }
    let (Some(number), Some(model)) = (boot.restored_model, boot.flies) else { return };
    machine.day.tally.restored += 1;
    let completed = machine.day.flown.contains(&model.gyro);
    note(machine, Violation::ModelNotCompleted, completed, || format!("number {number}, {:?}", model.gyro));
}

/// Counters of health do not fall from report to report of one start, and count no sample that was not read: what is
/// lost can be counted by them.
fn health(machine: &mut Machine<'_, '_>, report: &Health) {
    let counters: [u32; HEALTH] = [
        report.samples_acquired,
        report.sample_overruns,
        report.missed_ticks,
        report.sensor_faults,
        report.worst_delay_us,
        report.late_attitudes,
        report.results_lost,
        report.sent.frames,
        report.received.frames,
        report.commands_accepted,
        report.commands_refused,
        report.models_stored,
    ];
    let before = std::mem::replace(&mut machine.health, counters);
    let holds = before.iter().zip(&counters).all(|(before, now)| before <= now)
        && report.samples_acquired <= machine.acquisition().acquired();
    note(machine, Violation::SampleLost, holds, || format!("{counters:?} after {before:?}"));
}

fn attitude(machine: &mut Machine<'_, '_>, frame: &AttitudeFrame) {
    let Some(angles) = frame.angles else { return };
    let now_us = machine.chip.now_us.get();
    let flags = angles.flags() - AttitudeFlags::NEAR_VERTICAL;
    let [any, unflagged] = &mut machine.day.back_us;
    any.get_or_insert(now_us);
    if !flags.is_empty() {
        return;
    }
    unflagged.get_or_insert(now_us);
    let at = machine.truths.iter().min_by_key(|(t_us, _)| t_us.abs_diff(frame.t_us));
    let Some((_, truth)) = at.filter(|(t_us, _)| t_us.abs_diff(frame.t_us) < 1_000) else { return };
    let truth = truth.radians;
    let errors = errors_in_sigmas(&angles, &truth);
    let holds = errors.iter().all(|error| error.abs() <= SIGMAS);
    let sound_since_us = machine.sound_since_us();
    if now_us < sound_since_us + SETTLED_US {
        count(&mut machine.day.tally.soon, holds);
        return;
    }
    note(machine, Violation::Attitude, holds, || {
        format!("{errors:.1?} sigma of {:?} rad, truth {truth:?}", angles.sigmas_rad())
    });
}

/// Errors of inclination, azimuth and toolface over their deviations, the encoding's error taken off.
fn errors_in_sigmas(angles: &CompactAngles, truth: &[f64; 3]) -> [f64; 3] {
    let said = [angles.inclination_rad(), angles.azimuth_rad(), angles.gravity_toolface_rad()].map(f64::from);
    let sigmas = angles.sigmas_rad().map(f64::from);
    std::array::from_fn(|k| {
        let error = libm::remainder(said[k] - truth[k], TAU).abs();
        (error - STEP_RAD).max(0.0) / sigmas[k].max(1e-6)
    })
}

fn survey(machine: &mut Machine<'_, '_>, report: &SurveyReport) {
    let survey = &report.survey;
    if survey.kind != SurveyKind::Stationary {
        return;
    }
    let start_us = machine.chip.started_us.get();
    let is_of = |(of_us, heard): &&(u64, SurveyReport)| *of_us == start_us && heard.survey.t_end_us == survey.t_end_us;
    if let Some((_, heard)) = machine.day.surveys.iter().find(is_of) {
        let holds = heard == report;
        note(machine, Violation::SurveyAgain, holds, || format!("another of {} us", survey.t_end_us));
        return;
    }
    machine.day.surveys.push((start_us, *report));
    let age_us = machine.now_us().saturating_sub(survey.t_end_us);
    // A survey that the line spoilt is heard when it is asked for again: also one that follows a frame whose end was
    // spoilt.
    let frame_us = MAX_FRAME as u64 * 1_000_000 / u64::from(machine.day.bytes_per_s);
    let was_spoilt = machine.spoilt_us.is_some_and(|at_us| at_us + frame_us + age_us >= machine.chip.now_us.get());
    if !was_spoilt && !machine.line_stood_still() && !machine.overloaded() && !machine.clock_stepped() {
        note(machine, Violation::LateSurvey, age_us < SURVEY_US, || format!("{age_us} us old"));
    }
    let at = machine.truths.iter().find(|(t_us, _)| *t_us == survey.t_end_us);
    let Some((_, truth)) = at else { return };
    let truth = truth.radians;
    let said = [Some(survey.inclination_rad), survey.magnetic_azimuth_rad, survey.gravity_toolface_rad];
    for ((name, said), truth) in ["inclination", "azimuth", "toolface"].into_iter().zip(said).zip(truth) {
        let Some(said) = said else { continue };
        let error = libm::remainder(f64::from(said.value) - truth, TAU).abs() / f64::from(said.sigma);
        // Readings of a failing sensor may look like an effect until the next update.
        if machine.takes_an_effect_out && machine.chip.now_us.get() < machine.sound_since_us() + SETTLED_US {
            count(&mut machine.day.tally.misled, error <= SIGMAS);
            continue;
        }
        note(machine, Violation::Survey, error <= SIGMAS, || format!("{name} {error:.1} sigma off"));
    }
}

/// The model that flies after the first samples of a start is the factory's model or one that was stored to its end.
fn restored(
    machine: &mut Machine<'_, '_>,
    before: &mut Round,
    processed: u32,
    (factory, gyro, effects): (&GyroModel, &GyroModel, &ActiveEffects),
) {
    if processed == 0 || std::mem::replace(&mut before.flies, true) || (gyro == factory && effects.is_empty()) {
        return;
    }
    let completed = machine.day.completed.has(gyro, effects);
    note(machine, Violation::ModelNotCompleted, completed, || {
        format!("never stored to its end: {gyro:?}, effects: {}", !effects.is_empty())
    });
}

/// After every round of the program.
pub fn after_round<'c, 'd>(application: &mut Application<'_, Machine<'c, 'd>>, before: &mut Round) {
    let (processed, breaks) = (application.counts().processed, application.counts().sequence_breaks);
    let probe = &*application.statics().probe;
    let (config, flown, effects) = (*probe.config(), *probe.gyro_model(), *probe.effects());
    let takes_an_effect_out = !effects.is_empty();
    let stored = application.statics().memory.as_ref().map_or(0, |memory| memory.stored_and_failed()[0]);
    let machine = application.board();
    if stored > before.stored {
        machine.day.completed.note(&machine.chip.flash.borrow(), &config, stored - before.stored);
    }
    if let Some(whole) = machine.chip.whole.take() {
        machine.day.completed.note(&whole, &config, 1);
    }
    if machine.chip.is_dead() {
        return;
    }
    restored(machine, before, processed, (&config.gyro, &flown, &effects));
    machine.takes_an_effect_out = takes_an_effect_out;
    let counts = machine.acquisition();
    let (acquired, full, waiting) = (counts.acquired(), counts.queue_full(), machine.waiting() as u32);
    let misplaced = machine.misplaced.take();
    // As many as were handed out, and as many breaks between their numbers: none is flown twice and none left out.
    let are_those = misplaced.is_none()
        && [acquired, full, processed] == machine.samples()
        && breaks == machine.breaks
        && acquired == processed + full + waiting;
    let samples = machine.samples();
    note(machine, Violation::SampleLost, are_those, || {
        format!(
            "{acquired} acquired, {full} lost, {processed} flown with {breaks} breaks, {waiting} waiting; of the board \
             {samples:?}; {misplaced:?}"
        )
    });
    machine.day.tally.models += u64::from(stored.saturating_sub(before.stored));
    before.stored = stored;
    if before.flown != Some(flown) {
        before.flown = Some(flown);
        if !machine.day.flown.contains(&flown) {
            machine.day.flown.push(flown);
        }
    }
    let erased: Vec<u64> = machine.chip.erased_us.borrow().iter().skip(before.erased).copied().collect();
    before.erased += erased.len();
    if !erased.is_empty() {
        let drilling_for_s = machine.day.truth.drilling_for_s();
        note(machine, Violation::ErasedWhileDrilling, drilling_for_s <= EVIDENCE_S, || {
            format!("after {drilling_for_s:.2} s of drilling")
        });
    }
}

/// State before a round.
#[derive(Default)]
pub struct Round {
    /// P and b that flew.
    pub flown: Option<GyroModel>,
    pub stored: u32,
    /// True once a sample has been flown.
    pub flies: bool,
    /// Erasures since the start, those before the first sample among them.
    pub erased: usize,
}
