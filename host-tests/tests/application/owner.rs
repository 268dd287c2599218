//! Commands of an owner to a probe that drills, that is flooded, or that drills for a day.

use super::desk_board::{Desk, Images, KEY, PROBE, Seen, fly};
use meerkat_mwd::{
    Config, Sample,
    application::Updater,
    config::SurveyConfig,
    storage::{FactoryRecord, ImageSlots, Mounting, Slot},
    telemetry::{
        Command, CommandRefusal, EarlierModel, Erasure, ImagePart, Key, Kind, MAX_FRAME, MAX_PAYLOAD, Message, Outcome,
        authenticate, encode_frame, encode_payload,
    },
};
use mock_flash::MockFlash;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// A command with the key; its sequence number is its counter.
fn signed(counter: u16, command: &Command) -> Vec<u8> {
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let key = Key::new(&KEY, PROBE).unwrap();
    let payload = authenticate(&key, counter.into(), command, &mut payload).unwrap();
    encode_frame(Kind::AuthenticatedCommand, counter, payload, &mut buffer).unwrap().to_vec()
}

/// The probe's answer to the command of this sequence number, and when it had left.
fn answer(messages: &[(u64, Message)], sequence: u16) -> Option<(u64, Outcome)> {
    messages.iter().find_map(|(us, message)| match message {
        Message::Acknowledgement(answer) if answer.sequence == sequence => Some((*us, answer.outcome.clone())),
        _ => None,
    })
}

/// A line that gives each frame from its time on.
fn line_of(frames: Vec<(u64, Vec<u8>)>) -> Box<dyn FnMut(u64) -> Option<u8>> {
    let mut bytes = frames.into_iter().flat_map(|(us, frame)| frame.into_iter().map(move |byte| (us, byte))).peekable();
    Box::new(move |now_us| bytes.next_if(|(us, _)| *us <= now_us).map(|(_, byte)| byte))
}

/// Counters of refused commands fill the flash while the tool drills, where nothing may be erased. Once it stands still
/// the first refusal makes room, and the owner is heard again.
#[test]
fn an_owner_who_insists_while_drilling_is_heard_at_the_next_rest() {
    const SHAKES_UNTIL_US: u64 = 20_000_000;
    const COMMANDS: u16 = 900;
    let mut frames: Vec<(u64, Vec<u8>)> =
        (1..=COMMANDS).map(|n| (1_000_000 + u64::from(n) * 20_000, signed(n, &Command::SendVibration))).collect();
    frames.push((25_000_000, signed(COMMANDS + 1, &Command::SendVibration)));
    frames.push((26_000_000, signed(COMMANDS + 2, &Command::SendVibration)));
    let reads = |at_rest: Sample| {
        // It shakes: a turn that force and field do not show would be a fault of the gyro.
        let shaken = if at_rest.t_us >= SHAKES_UNTIL_US { 0.0 } else { 4.0 };
        let shaken = if (at_rest.t_us / 10_000).is_multiple_of(2) { shaken } else { -shaken };
        Sample { accel_m_s2: at_rest.accel_m_s2.map(|x| x + shaken), ..at_rest }
    };
    let seen = fly(
        Desk { line: line_of(frames), reads: Box::new(reads), flash: Some(MockFlash::new(3, 2)), ..Desk::default() },
        28,
    );
    let outcome = |sequence| answer(&seen.messages, sequence).map(|(_, outcome)| outcome);
    let refused = |why| Some(Outcome::Refused(why));
    assert_eq!(outcome(100), refused(CommandRefusal::WhileDrilling));
    // Most of these are not answered: without a counter of its own a command that somebody repeats is like any other's.
    let answers = (101..=COMMANDS).filter_map(outcome);
    let full = answers.filter(|outcome| *outcome == Outcome::Refused(CommandRefusal::CounterNotStored)).count();
    assert!(full > 10, "no room is left: {full}");
    assert_eq!(outcome(COMMANDS + 1), refused(CommandRefusal::CounterNotStored));
    assert_eq!(outcome(COMMANDS + 2), Some(Outcome::Accepted));
}

/// Parts of an image that are not the next one, as fast as the probe takes them, on a slow line: their answers neither
/// keep the owner's from it nor the health.
#[test]
fn a_flood_of_wrong_parts_drowns_neither_answers_nor_health() {
    const FLOOD_US: u64 = 6_000_000;
    const STOP_US: u64 = 12_000_000;
    let image = Command::BeginUpdate { number: 1, length: 1_000, digest: [7; 32] };
    let (mut payload, mut buffer) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let part = encode_payload(&ImagePart { offset: 320, bytes: &[1; 32] }, &mut payload).unwrap();
    let part = encode_frame(Kind::ImagePart, 500, part, &mut buffer).unwrap().to_vec();
    let mut waiting = [(4_000_000, signed(1, &image)), (STOP_US, signed(2, &Command::StopRecording))].into_iter();
    let (mut next, mut frame) = (waiting.next(), Vec::new().into_iter());
    let line = move |now_us| {
        if frame.as_slice().is_empty() {
            if let Some((_, bytes)) = next.take_if(|(us, _)| *us <= now_us) {
                (next, frame) = (waiting.next(), bytes.into_iter());
            } else if now_us > FLOOD_US {
                frame = part.clone().into_iter();
            }
        }
        frame.next()
    };
    let update = Updater::new(ImageSlots::new(Images::new(4, 3)).unwrap(), Slot::First);
    let seen = fly(
        Desk {
            line: Box::new(line),
            bytes_per_s: 1_000,
            flash: Some(MockFlash::new(3, 2)),
            update: Some(update),
            ..Desk::default()
        },
        24,
    );
    assert_eq!(answer(&seen.messages, 1).map(|(_, outcome)| outcome), Some(Outcome::Accepted));
    let stopped = answer(&seen.messages, 2);
    assert!(stopped.as_ref().is_some_and(|(us, _)| *us < STOP_US + 2_000_000), "{stopped:?}");
    let of_parts = seen.messages.iter().filter(|(_, message)| match message {
        Message::Acknowledgement(answer) => answer.sequence == 500,
        _ => false,
    });
    let (of_parts, flooded_s) = (of_parts.count() as u64, 24 - FLOOD_US / 1_000_000);
    assert!((1..=8 + 4 * flooded_s).contains(&of_parts), "{of_parts} answers");
    let health = seen
        .messages
        .iter()
        .filter(|(us, message)| *us > FLOOD_US + 1_000_000 && matches!(message, Message::Health(_)));
    assert!(health.count() >= 3);
}

/// A recording is replayed with the configuration of its boot: whatever set the surveys last stands in it.
#[test]
fn a_boot_has_the_surveys_settings_in_use() {
    let survey = |toolface_offset_rad| SurveyConfig {
        settle_s: 1.0,
        average_s: 1.0,
        toolface_offset_rad,
        ..SurveyConfig::default()
    };
    let recording = Command::StartRecording { for_s: Some(1) };
    let mounting = FactoryRecord::Mounting(Mounting { toolface_offset_rad: 1.0 });
    let commands = [
        (5, Command::ConfigureSurvey(survey(0.25))),
        (8, recording),
        (11, Command::Configure(Config { survey: survey(0.5), ..Config::default() })),
        (17, Command::ConfigureSurvey(survey(0.75))),
        (20, recording),
        (23, Command::Provision { record: mounting, only_check: false }),
        (26, recording),
    ];
    let frames = (1..).zip(commands).map(|(n, (s, command))| (s * 1_000_000, signed(n, &command))).collect();
    let seen = fly(Desk { line: line_of(frames), flash: Some(MockFlash::new(3, 2)), ..Desk::default() }, 30);
    let outcomes: Vec<_> = (1..=7).map(|n| answer(&seen.messages, n).map(|(_, outcome)| outcome)).collect();
    assert_eq!(outcomes, vec![Some(Outcome::Accepted); 7]);
    let boots = seen.messages.iter().filter_map(|(_, message)| match message {
        Message::Boot(boot) => Some(boot.config.survey.toolface_offset_rad),
        _ => None,
    });
    assert_eq!(boots.collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
}

/// Without a line downwards nobody sends settings again in the hole: what commands have set holds after every start,
/// until another command, or the factory, sets something else. A mounting that the factory writes is not kept on this
/// desk.
#[test]
fn what_commands_have_set_holds_after_a_start() {
    let mut dice = Xoshiro128PlusPlus::seed_from_u64(20);
    let mut drawn = |most: f32| most * (dice.next_u32() as f32 / u32::MAX as f32);
    let survey = |toolface_offset_rad| SurveyConfig {
        settle_s: 1.0,
        average_s: 1.0,
        toolface_offset_rad,
        ..SurveyConfig::default()
    };
    let mut config = || {
        let mut config = Config { seed: drawn(1e6) as u64, survey: survey(drawn(3.0)), ..Config::default() };
        config.earth.dip_rad = Some(drawn(1.5));
        config.earth.declination_rad = Some(drawn(0.5));
        config.gyro.b_rad_s = [drawn(0.03), -drawn(0.03), drawn(0.03)];
        config
    };
    let [first, second, third] = [config(), config(), config()];
    let mounting = FactoryRecord::Mounting(Mounting { toolface_offset_rad: 1.0 });
    let mounting = Command::Provision { record: mounting, only_check: false };
    let other = survey(-0.5);
    let factory = fly(Desk::default(), 2);
    let factory = boots(&factory).next().unwrap();
    // The commands of a power-up, and the configuration of the next one.
    let power_ups = [
        (vec![Command::Configure(first)], first),
        (vec![Command::ConfigureSurvey(other)], Config { survey: other, ..first }),
        (vec![Command::RollBackModel { to: EarlierModel::Factory }], Config { survey: other, ..first }),
        (vec![Command::ConfigureSurvey(third.survey), Command::Configure(second)], second),
        (vec![Command::Erase { what: Erasure::Models }], second),
        (vec![Command::Erase { what: Erasure::Settings }], factory),
        (vec![Command::ConfigureSurvey(other)], Config { survey: other, ..factory }),
        (vec![Command::Configure(third)], third),
        (vec![mounting], factory),
        (vec![], factory),
    ];
    let (mut flash, mut counter, mut before) = (MockFlash::new(3, 2), 0, factory);
    for (number, (commands, after)) in power_ups.into_iter().enumerate() {
        let frames = (5..).step_by(3).zip(&commands).map(|(s, command)| {
            counter += 1;
            (s * 1_000_000, signed(counter, command))
        });
        let line = line_of(frames.collect());
        let seen = fly(Desk { line, flash: Some(flash), ..Desk::default() }, 12);
        assert_eq!(boots(&seen).next(), Some(before), "{number}");
        for of in counter + 1 - commands.len() as u16..=counter {
            assert_eq!(
                answer(&seen.messages, of).map(|(_, outcome)| outcome),
                Some(Outcome::Accepted),
                "{number}: {of}"
            );
        }
        (flash, before) = (seen.flash.unwrap(), after);
        flash.power_up();
    }
}

/// A full scale of 5 m/s^2 (g in the place of m/s^2) makes every reading a clipped one, so that no rest is ever seen;
/// it is valid. A mounting that cannot be one needs no key.
#[test]
fn settings_that_hide_every_rest_can_be_ended_and_a_refused_record_ends_none() {
    let mut wrong = Config { survey: SurveyConfig { settle_s: 1.0, ..SurveyConfig::default() }, ..Config::default() };
    wrong.full_scale.accel_m_s2 = Some(5.0);
    let no_mounting = FactoryRecord::Mounting(Mounting { toolface_offset_rad: f32::NAN });
    let refused =
        [Command::Provision { record: no_mounting, only_check: false }, Command::Configure(Config::default())];
    let mut flash = MockFlash::new(3, 2);
    let mut power_up = |commands: &[(u16, &Command)]| {
        let frames =
            commands.iter().map(|(number, command)| (u64::from(*number) * 5_000_000, signed(*number, command)));
        let line = line_of(frames.collect());
        let seen = fly(Desk { line, flash: Some(flash.clone()), ..Desk::default() }, 25);
        flash = seen.flash.clone().unwrap();
        flash.power_up();
        let answers = commands.iter().map(|(number, _)| answer(&seen.messages, *number).map(|(_, outcome)| outcome));
        (boots(&seen).next().unwrap(), answers.flatten().collect::<Vec<_>>())
    };
    let (factory, done) = power_up(&[(1, &Command::Configure(wrong))]);
    assert_eq!(done, [Outcome::Accepted]);
    let (flown, done) = power_up(&[(2, &refused[0]), (3, &refused[1])]);
    assert_eq!(flown, wrong);
    let [of_mounting, of_configuration] =
        [CommandRefusal::Malformed, CommandRefusal::WhileDrilling].map(Outcome::Refused);
    assert_eq!(done, [of_mounting, of_configuration]);
    let (flown, done) = power_up(&[(4, &Command::Erase { what: Erasure::Settings })]);
    assert_eq!((flown, done), (wrong, vec![Outcome::Accepted]));
    assert_eq!(power_up(&[]).0, factory);
}

/// Configurations that the probe says it flies.
fn boots(seen: &Seen) -> impl Iterator<Item = Config> {
    seen.messages.iter().filter_map(|(_, message)| match message {
        Message::Boot(boot) => Some(boot.config),
        _ => None,
    })
}

/// More reports of the vibration dose than a byte counts, on a probe without a flash to keep them in.
#[test]
fn a_day_of_doses_without_a_flash_ends_nothing() {
    let desk = Desk { period_us: 20_000, dynamics_s: 0.2, ..Desk::default() };
    let seen = fly(desk, 640);
    let doses = seen.messages.iter().filter(|(_, message)| matches!(message, Message::Dose(_))).count();
    assert!(doses > 256 && seen.resets == 0, "{doses}");
}
