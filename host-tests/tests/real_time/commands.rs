//! Every command, from a host over the emulator's serial line into the probe, and its effect.

use super::live::{Host, KEY, LiveProbe, drilled};
use meerkat_mwd::{
    Config, Sample, SampleFlags,
    application::BURST_SAMPLES,
    config::SurveyConfig,
    identification::Decision,
    storage::StoredModel,
    telemetry::{
        Boot, BurstPart, Command, CommandRefusal, EarlierModel, Erasure, Message, Outcome, ResetReason, StreamConfig,
    },
};
use mwd::target::real_time::RealTime;
use nalgebra::Vector3;
use std::fs;
use testbed::flight;

const OTHER_KEY: [u8; 32] = *b"a key that no probe has 32 Bytes";

/// Length of the rest, seconds: longer than any test here runs.
const REST_S: f64 = 7_200.0;

fn run(config: Config, key: Option<[u8; 32]>) -> RealTime {
    let stream = StreamConfig { attitude_every: 200, ..RealTime::default().stream };
    RealTime { config, stream, key, ..RealTime::default() }
}

fn boot(host: &mut Host) -> Boot {
    host.until("a boot", |message| if let Message::Boot(boot) = message { Some(*boot) } else { None })
}

/// Waits until the probe knows that the tool stands still.
fn at_rest(host: &mut Host) {
    host.until("a survey", |message| matches!(message, Message::Survey(_)).then_some(()));
}

fn calibrating() -> [Command; 6] {
    [
        Command::Configure(Config::default()),
        Command::ConfigureSurvey(SurveyConfig::default()),
        Command::AcceptModel { window_end_us: 0 },
        Command::RollBackModel { to: EarlierModel::Previous },
        Command::RollBackModel { to: EarlierModel::Factory },
        Command::Erase { what: Erasure::Models },
    ]
}

/// The owner of the probe, with the key's file and the counter beside it.
struct Owner<'a>(&'a LiveProbe);

impl<'a> Owner<'a> {
    fn new(probe: &'a LiveProbe) -> Self {
        fs::write(probe.at("probe.key"), KEY.map(|byte| format!("{byte:02x}")).concat()).unwrap();
        Self(probe)
    }

    fn latest(&self) -> u64 {
        fs::read_to_string(self.0.at("probe.key.counter")).map_or(0, |text| text.trim().parse().unwrap())
    }

    fn sends(&self, host: &mut Host, command: &Command) -> Outcome {
        let counter = self.latest() + 1;
        fs::write(self.0.at("probe.key.counter"), counter.to_string()).unwrap();
        host.signed(&KEY, counter, command)
    }

    /// Sends a command with `cargo mwd command` and checks its output.
    fn types(&self, arguments: &[&str], expected: &str) {
        let key = self.0.at("probe.key");
        let (status, said) = self.0.mwd(&[&["command", "--deadline", "300", "--key", &key], arguments].concat());
        println!("{arguments:?}: {}", said.trim());
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert_eq!(status, if expected == "accepted" { 0 } else { 2 }, "{said}");
    }
}

/// Bias beyond which a probe that does not know it takes rest for motion, rad/s: 2 deg/s plus a tenth.
const BIAS_THAT_TURNS_RAD_S: f32 = 0.038;

/// A run whose latest window was accepted, after others that were; the host's flight of it, bit for bit the
/// probe's, tells. What flies moves on from it with every update. Its gyro has a bias without which rest is
/// motion.
fn with_accepted_windows() -> (Config, Vec<Sample>) {
    let all_are_accepted = |(config, samples): &(Config, Vec<Sample>)| {
        let flown = run(*config, None).through_sensors(&samples[..140 * 200]);
        let reports = flight::fly(config, &flown, |_| ()).unwrap().reports;
        let bias_rad_s = reports.last().map_or(0.0, |report| Vector3::from(report.flown.b_rad_s).norm());
        let all_accepted = reports.iter().all(|report| report.decision == Decision::Accepted);
        reports.len() > 1 && all_accepted && bias_rad_s > BIAS_THAT_TURNS_RAD_S
    };
    let with_short_windows = |seed| {
        let (mut config, samples) = drilled(95.0, REST_S, seed);
        config.identification.window_s = 25.0;
        // The next window after the drilling closes long after the commands.
        config.identification.step_s = 50.0;
        (config, samples)
    };
    (1..40).map(with_short_windows).find(all_are_accepted).unwrap()
}

fn flies(host: &Host) -> StoredModel {
    host.boot.unwrap().flies.unwrap()
}

#[test]
fn models_are_accepted_and_rolled_back_and_both_survive_as_the_counter_does() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = with_accepted_windows();
    let rest = &samples[96 * 200..];
    let run = run(config, Some(KEY));

    // Accept the latest window's model, which the flown model has moved on from.
    probe.power_up(&run, &samples);
    let mut host = probe.host();
    let begun = boot(&mut host);
    assert_eq!((begun.reset, begun.restored_model, begun.flies), (ResetReason::PowerOn, None, None));
    let looked = host.drill(95_000_000);
    assert_eq!(looked.decision, Decision::Accepted);
    let owner = Owner::new(&probe);
    let accept = Command::AcceptModel { window_end_us: looked.t_end_us };
    let not_there = Outcome::Refused(CommandRefusal::NothingThere);
    assert_eq!(owner.sends(&mut host, &Command::AcceptModel { window_end_us: looked.t_start_us }), not_there);
    assert_eq!(owner.sends(&mut host, &accept), Outcome::Accepted);
    assert_eq!(flies(&host).gyro.p, looked.fitted.p);
    let first = host.boot.unwrap().restored_model;
    assert!(first.is_some() && host.boot.unwrap().first_sample > 95 * 200);
    assert_eq!(owner.sends(&mut host, &accept), not_there, "it started afresh");
    // Back to what flew before; and not back and forth.
    let back = Command::RollBackModel { to: EarlierModel::Previous };
    assert_eq!(owner.sends(&mut host, &back), Outcome::Accepted);
    let accepted = flies(&host);
    assert!(accepted.gyro.p != looked.flown.p && host.boot.unwrap().restored_model > first);
    assert_eq!(owner.sends(&mut host, &back), not_there);
    let (replayed, number) = (owner.latest(), host.boot.unwrap().restored_model);
    drop(host);

    // The model flies after a loss of power, and a command that was overheard and sent again is refused.
    probe.power_up(&run, &samples);
    let mut host = probe.host();
    let begun = boot(&mut host);
    assert_eq!((begun.restored_model, begun.flies.map(|model| model.gyro)), (number, Some(accepted.gyro)));
    let old = host.signed(&KEY, replayed, &back);
    assert_eq!(old, Outcome::Refused(CommandRefusal::Replayed { latest: replayed }));
    let looked = host.drill(95_000_000);
    // Send at once: the next window that closes, even at rest, takes its place.
    let accept = Command::AcceptModel { window_end_us: looked.t_end_us };
    assert_eq!(Owner::new(&probe).sends(&mut host, &accept), Outcome::Accepted);
    drop(host);
    let owner = Owner::new(&probe);
    owner.types(&["accept-model", "3600000000000"], "window_end_us is out of its bounds");

    // Roll-back to the model that was stored before the restored one.
    probe.power_up(&run, rest);
    let mut host = probe.host();
    let begun = boot(&mut host);
    assert!(begun.restored_model > number && begun.flies.unwrap().gyro.p != accepted.gyro.p);
    at_rest(&mut host);
    drop(host);
    let owner = Owner::new(&probe);
    owner.types(&["roll-back", "previous"], "accepted");
    owner.types(&["roll-back", "previous"], "not there");
    probe.power_up(&run, rest);
    let mut host = probe.host();
    assert_eq!(boot(&mut host).flies.map(|model| model.gyro), Some(accepted.gyro));
    at_rest(&mut host);
    let owner = Owner::new(&probe);
    assert_eq!(owner.sends(&mut host, &Command::RollBackModel { to: EarlierModel::Factory }), Outcome::Accepted);
    let factory = host.boot.unwrap();
    assert_eq!((factory.restored_model, factory.flies), (None, None));
    // Without the bias that was learnt it takes rest for motion, until it has learnt it again.
    at_rest(&mut host);
    drop(host);
    owner.types(&["erase", "models"], "accepted");
    owner.types(&["roll-back", "previous"], "not there");
    let latest = owner.latest();
    probe.power_up(&run, rest);
    let mut host = probe.host();
    assert_eq!(boot(&mut host).restored_model, None);
    let old = host.signed(&KEY, latest, &back);
    assert_eq!(old, Outcome::Refused(CommandRefusal::Replayed { latest }), "the counter outlives an erasure");
}

#[test]
fn what_needs_no_key_is_done_and_bounds_are_kept() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = drilled(11.0, REST_S, 2);
    let rest = &samples[12 * 200..];
    probe.power_up(&run(config, Some(KEY)), rest);
    at_rest(&mut probe.host());
    let owner = Owner::new(&probe);
    for arguments in [
        &["self-test"][..],
        &["stream", "--every", "100", "--bandwidth", "92160"],
        &["start-recording", "--for", "600"],
        &["stop-recording"],
        &["survey", "--within", "60"],
        &["send-vibration"],
    ] {
        owner.types(arguments, "accepted");
    }

    let mut host = probe.host();
    assert_eq!(host.plain(&Command::SelfTest), Outcome::Accepted);
    let tested = host.until("a self-test", |message| match message {
        Message::Health(health) => health.self_test,
        _ => None,
    });
    assert!(tested.is_passed(), "{tested:?}");
    assert!(
        tested.gravity_is_plausible() && tested.field_is_plausible() && tested.turns_wrong.is_empty(),
        "{tested:?}"
    );
    assert_eq!(host.plain(&Command::StartRecording { for_s: Some(2) }), Outcome::Accepted);
    let [mut first, mut last] = [None; 2];
    host.until("a recording and the end of it", |message| match message {
        Message::Sample(sample) => {
            first = first.or(Some(sample.sample.t_us));
            last = Some(sample.sample.t_us);
            None
        }
        Message::Health(health) => last.is_some_and(|last| health.t_us > last + 1_000_000).then_some(()),
        _ => None,
    });
    assert!((last.unwrap() - first.unwrap()).abs_diff(2_000_000) < 20_000, "{first:?} to {last:?}");
    let surveys = host.surveys;
    assert_eq!(host.plain(&Command::StationarySurvey { within_s: 60 }), Outcome::Accepted);
    assert!(host.surveys > surveys, "what was asked for comes before the answer");

    // Dose and worst second: all of it, in order.
    assert_eq!(host.plain(&Command::SendVibration), Outcome::Refused(CommandRefusal::NotAuthenticated));
    assert_eq!(owner.sends(&mut host, &Command::SendVibration), Outcome::Accepted);
    // The burst of the command typed before may still be on its way: the last that began counts.
    let whole = |burst: &[BurstPart]| {
        let parts = burst.get(burst.iter().rposition(|part| part.first == 0)?..)?;
        let samples: Vec<_> = parts.iter().flat_map(|part| part.samples.clone()).collect();
        (samples.len() >= usize::from(parts[0].of)).then_some(samples)
    };
    let samples = loop {
        match whole(&host.burst) {
            Some(samples) => break samples,
            None => host.until("the worst second", |message| matches!(message, Message::Burst(_)).then_some(())),
        }
    };
    assert!(host.dose.is_some());
    assert_eq!(samples.len(), BURST_SAMPLES);
    assert!(samples.windows(2).all(|pair| pair[1].t_us - pair[0].t_us == 5_000), "{samples:?}");
    assert!(
        samples.iter().all(|sample| sample.accel_m_s2.iter().all(|x| x.abs() < 20.0)) && host.burst[0].rms_m_s2 < 1.0
    );

    // The program checks bounds itself: the probe must, too.
    for (command, name) in [
        (Command::StartRecording { for_s: Some(0) }, "for_s"),
        (Command::StationarySurvey { within_s: 0 }, "within_s"),
        (Command::ConfigureStream(StreamConfig { bytes_per_s: 1, ..StreamConfig::default() }), "stream.bytes_per_s"),
        (Command::Configure(Config { sample_period_us: 1, ..config }), "sample_period_us"),
        (
            Command::ConfigureSurvey(SurveyConfig { toolface_offset_rad: f32::NAN, ..config.survey }),
            "survey.toolface_offset_rad",
        ),
    ] {
        let answer = if command.needs_the_key() { owner.sends(&mut host, &command) } else { host.plain(&command) };
        let Outcome::Refused(CommandRefusal::OutOfBounds { field }) = &answer else { panic!("{name}: {answer:?}") };
        assert_eq!(field.as_str(), name);
    }
    let other = Config { seed: 12_345, ..config };
    assert_eq!(owner.sends(&mut host, &Command::Configure(other)), Outcome::Accepted);
    assert_eq!(host.boot.unwrap().config, other);
    at_rest(&mut host);
    drop(host);
    fs::write(probe.at("config.toml"), toml::to_string(&config).unwrap()).unwrap();
    fs::write(probe.at("survey.toml"), "toolface_offset_rad = 0.5").unwrap();
    owner.types(&["configure", &probe.at("config.toml")], "accepted");
    at_rest(&mut probe.host());
    owner.types(&["configure-survey", &probe.at("survey.toml")], "accepted");
}

/// At rest a sensor fails, and then the tool drills: nobody can tell any more.
#[test]
fn a_sensor_that_failed_at_rest_lets_no_erasure_through() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = drilled(11.0, 60.0, 5);
    let (_, drilling) = drilled(260.0, 0.0, 5);
    let rest = &samples[12 * 200..52 * 200];
    for missing in [SampleFlags::ACCEL_MISSING, SampleFlags::GYRO_MISSING] {
        let mut samples = [rest, &drilling[20 * 200..260 * 200]].concat();
        samples[40 * 200..].iter_mut().for_each(|sample| sample.flags.insert(missing));
        probe.power_up(&run(config, Some(KEY)), &samples);
        let mut host = probe.host();
        at_rest(&mut host);
        let erase = Command::Erase { what: Erasure::Models };
        let counter = Owner::new(&probe).latest();
        assert_eq!(host.signed(&KEY, counter + 1, &erase), Outcome::Accepted, "while both are sound");
        let mut t_us = 42_000_000;
        for counter in counter + 2..counter + 30 {
            host.until("a moment later", |message| match message {
                Message::Health(health) => (health.t_us > t_us).then_some(()),
                _ => None,
            });
            t_us += 5_000_000;
            let while_drilling = Outcome::Refused(CommandRefusal::WhileDrilling);
            assert_eq!(host.signed(&KEY, counter, &erase), while_drilling, "{missing:?}, after {t_us}");
        }
        let latest = counter + 30;
        fs::write(probe.at("probe.key.counter"), latest.to_string()).unwrap();
    }
}

/// As many commands without a key as the line takes: the survey comes all the same, at once, and so do
/// attitudes.
#[test]
fn a_flood_of_commands_keeps_no_survey_from_the_line() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = drilled(11.0, REST_S, 6);
    let run =
        RealTime { stream: StreamConfig { bytes_per_s: 10_368, ..StreamConfig::default() }, ..run(config, Some(KEY)) };
    probe.power_up(&run, &samples[12 * 200..]);
    let mut host = probe.host();
    boot(&mut host);
    host.flooded_with(&Command::StartRecording { for_s: None });
    let (mut boots, mut answers, mut now_us, mut attitudes) = (0, 0, 0, Vec::new());
    let survey = host.until("a survey", |message| {
        match message {
            Message::Boot(_) => boots += 1,
            Message::Acknowledgement(_) => answers += 1,
            Message::Attitude(attitude) => {
                now_us = attitude.t_us;
                attitudes.push(attitude.t_us);
            }
            Message::Survey(survey) => return Some(survey.survey),
            _ => {}
        }
        None
    });
    let late_us = now_us.saturating_sub(survey.t_end_us);
    let silent_us = attitudes.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
    println!(
        "{boots} boots, {answers} answers, {} attitudes; {late_us} us late, {silent_us} us silent",
        attitudes.len()
    );
    assert!(late_us < 500_000, "{late_us} us");
    let seconds = survey.t_end_us / 1_000_000;
    assert!(
        boots <= 4 + seconds / 2 && answers <= 8 + 4 * (seconds + 1),
        "{boots} boots, {answers} answers in {seconds} s"
    );
    assert!(answers > 20, "{answers} answers: this is no flood");
    assert!(silent_us < 500_000, "{silent_us} us without an attitude");
}

#[test]
fn forged_and_plain_and_keyless_calibration_is_refused() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = drilled(11.0, REST_S, 3);
    let rest = &samples[12 * 200..];
    for (key, plain, signed) in [
        (Some(KEY), CommandRefusal::NotAuthenticated, CommandRefusal::Forged),
        (None, CommandRefusal::NoKey, CommandRefusal::NoKey),
    ] {
        probe.power_up(&run(config, key), rest);
        let mut host = probe.host();
        at_rest(&mut host);
        for command in calibrating() {
            assert_eq!(host.plain(&command), Outcome::Refused(plain.clone()), "{command:?}");
            assert_eq!(host.signed(&OTHER_KEY, 1, &command), Outcome::Refused(signed.clone()), "{command:?}");
        }
        if key.is_none() {
            let with_the_right_one = host.signed(&KEY, 1, &Command::Erase { what: Erasure::Models });
            assert_eq!(with_the_right_one, Outcome::Refused(CommandRefusal::NoKey));
        }
    }
}

#[test]
fn while_drilling_no_calibration_is_changed() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (config, samples) = drilled(900.0, 0.0, 4);
    probe.power_up(&run(config, Some(KEY)), &samples[20 * 200..]);
    let mut host = probe.host();
    boot(&mut host);
    let while_drilling = Outcome::Refused(CommandRefusal::WhileDrilling);
    for (counter, command) in (1..).zip(calibrating()) {
        assert_eq!(host.signed(&KEY, counter, &command), while_drilling, "{command:?}");
    }
    assert_eq!(host.plain(&Command::SelfTest), while_drilling);
    assert_eq!(host.plain(&Command::StartRecording { for_s: None }), Outcome::Accepted);
}
