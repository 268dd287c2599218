//! `mwd command`: ask a probe for something and wait for its answer.

use std::{
    io::Write,
    path::PathBuf,
    time::{Duration, Instant, SystemTime},
};

use clap::{Args, Subcommand, ValueEnum};
use meerkat_mwd::telemetry::{
    AttitudeFormat, Command, CommandRefusal, EarlierModel, Erasure, FrameDecoder, Kind, MAX_DECODED, MAX_PAYLOAD,
    Message, Outcome, ProbeId, StreamConfig, authenticate,
};

use super::toml_file;
use crate::port::{
    key_file::KeyFile,
    line::{Line, LineArgs, Received},
    monitor::self_test_text,
};
use testbed::{
    command_frame::{frame_of, framed},
    console::stdout,
    failure::Failure,
};

/// Time that a probe may take to say which it is.
pub(super) const HEALTH: Duration = Duration::from_secs(10);

/// Options of `command`.
#[derive(Debug, Clone, Args)]
pub struct CommandArgs {
    /// Port of the probe.
    #[command(flatten)]
    pub line: LineArgs,
    /// File with the probe's key, 64 hexadecimal digits; its counter is kept in a file beside it. Needed for
    /// commands that change calibration or the stream
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Unique number of the probe that is meant, 24 hexadecimal digits. Default: the one that the probe states
    #[arg(long, value_name = "DIGITS", value_parser = probe_id)]
    pub probe: Option<ProbeId>,
    /// Seconds to wait for the answer
    #[arg(long, value_name = "S", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3_600))]
    pub deadline: u64,
    /// The command.
    #[command(subcommand)]
    pub request: Request,
}

/// The commands of a probe, as subcommands of `command`.
#[derive(Debug, Clone, Subcommand)]
pub enum Request {
    /// Test sensors, their mounting and storage, and report their health. Turn the probe by hand before, about each of
    /// its axes
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 self-test")]
    SelfTest,
    /// Set what the probe sends over the line, and how fast. Needs --key
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key stream --every 5 --bandwidth 11520"
    )]
    Stream {
        /// Send every Nth attitude; 0 sends none
        #[arg(long, value_name = "N", default_value_t = StreamConfig::default().attitude_every)]
        every: u16,
        /// Bandwidth of the line
        #[arg(long, value_name = "BYTES_PER_S", default_value_t = StreamConfig::default().bytes_per_s)]
        bandwidth: u32,
        /// Drop an attitude that has waited for this many milliseconds
        #[arg(long, value_name = "MS", default_value_t = StreamConfig::default().max_age_us / 1_000)]
        max_age: u32,
        /// Send attitudes at full precision instead of angles in 16 bits
        #[arg(long)]
        exact: bool,
    },
    /// Start sending every raw sample
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 start-recording --for 60")]
    StartRecording {
        /// Stop by itself after this many seconds
        #[arg(long = "for", value_name = "S")]
        for_s: Option<u32>,
    },
    /// Stop sending raw samples
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 stop-recording")]
    StopRecording,
    /// Send the survey of this stop again; each stop gives one without a command
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 survey --within 300")]
    Survey {
        /// Seconds that the command carries; the firmware does not use them
        #[arg(long, value_name = "S", default_value_t = 600)]
        within: u16,
    },
    /// Restart with the configuration of a file; fields it does not name take their defaults. Needs --key
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key configure config.toml"
    )]
    Configure {
        /// The configuration, TOML
        file: PathBuf,
    },
    /// Set how surveys are taken from a file; fields it does not name take their defaults. Needs --key
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key configure-survey survey.toml"
    )]
    ConfigureSurvey {
        /// The configuration of surveys, TOML
        file: PathBuf,
    },
    /// Fly the model of the latest window, accepted or not. Needs --key
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key accept-model 75000000"
    )]
    AcceptModel {
        /// End of that window in microseconds, as its report states
        window_end_us: u64,
    },
    /// Fly an earlier model. Needs --key
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key roll-back previous"
    )]
    RollBack {
        /// Which model
        to: Earlier,
    },
    /// Send vibration dose and the raw samples of the worst second: monitor shows them. Needs --key
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key send-vibration")]
    SendVibration,
    /// Erase stored models, or end what commands have set. Needs --key
    #[command(after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 --key probe.key erase models")]
    Erase {
        /// Records to erase
        what: What,
    },
}

/// Models to roll back to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Earlier {
    /// The model that flew before the present one
    Previous,
    /// The factory's model
    Factory,
}

/// Records that `erase` erases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// All stored models
    Models,
    /// The settings of configure and configure-survey, from the next start on
    Settings,
}

impl Request {
    /// The library's command.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn command(&self) -> Result<Command, Failure> {
        Ok(match self {
            Self::SelfTest => Command::SelfTest,
            Self::Stream { every, bandwidth, max_age, exact } => Command::ConfigureStream(StreamConfig {
                bytes_per_s: *bandwidth,
                attitude_every: *every,
                attitude_format: if *exact { AttitudeFormat::Exact } else { AttitudeFormat::Compact },
                max_age_us: max_age.saturating_mul(1_000),
            }),
            Self::StartRecording { for_s } => Command::StartRecording { for_s: *for_s },
            Self::StopRecording => Command::StopRecording,
            Self::Survey { within } => Command::StationarySurvey { within_s: *within },
            Self::Configure { file } => Command::Configure(toml_file::read(file)?),
            Self::ConfigureSurvey { file } => Command::ConfigureSurvey(toml_file::read(file)?),
            Self::AcceptModel { window_end_us } => Command::AcceptModel { window_end_us: *window_end_us },
            Self::RollBack { to: Earlier::Previous } => Command::RollBackModel { to: EarlierModel::Previous },
            Self::RollBack { to: Earlier::Factory } => Command::RollBackModel { to: EarlierModel::Factory },
            Self::SendVibration => Command::SendVibration,
            Self::Erase { what: What::Models } => Command::Erase { what: Erasure::Models },
            Self::Erase { what: What::Settings } => Command::Erase { what: Erasure::Settings },
        })
    }
}

/// Sends the command and prints the probe's answer.
///
/// # Errors
/// 2 for bad usage, for a refusal and for a self-test that was not passed, 3 for a port, a key or an answer that is not
/// there.
pub fn run(args: &CommandArgs) -> anyhow::Result<()> {
    let command = args.request.command()?;
    // The host does not know the probe's clock: the probe checks times itself.
    command.check(u64::MAX)?;
    let mut key = match &args.key {
        Some(path) => Some(KeyFile::open(path)?),
        None if command.needs_the_key() => {
            return Err(Failure::BadInput("this needs --key FILE".to_owned()).into());
        }
        None => None,
    };
    let mut line = Line::open(&args.line)?;
    if !line.is_live() {
        return Err(Failure::BadInput(format!("{}: a capture takes no commands", args.line.place)).into());
    }
    let deadline = Duration::from_secs(args.deadline);
    let probe = match (&key, args.probe) {
        (None, _) => ProbeId::default(),
        (Some(_), Some(probe)) => probe,
        (Some(_), None) => heard(&mut line, deadline)?,
    };
    let answer = send_counting(&mut line, &command, key.as_mut(), probe, deadline)?;
    match answer.map_err(|counters| no_answer(deadline, &counters))? {
        Outcome::Accepted if matches!(args.request, Request::SelfTest) => {
            writeln!(stdout(), "accepted")?;
            let deadline = deadline.max(HEALTH);
            let found = listen(&mut line, deadline, |message| match message {
                Message::Health(health) => health.self_test,
                _ => None,
            })?;
            let test = found.map_err(|counters| {
                let seconds = deadline.as_secs();
                Failure::Missing(format!("the self-test's findings did not come within {seconds} s ({counters})"))
            })?;
            writeln!(stdout(), "{}", self_test_text(&test))?;
            if test.is_passed() {
                return Ok(());
            }
            Err(Failure::BadInput("the probe did not pass the self-test".to_owned()).into())
        }
        Outcome::Accepted => writeln!(stdout(), "accepted").map_err(Into::into),
        Outcome::Refused(reason) => Err(Failure::BadInput(format!("the probe refused: {reason}")).into()),
        _ => Err(Failure::BadInput("the probe's answer is of another version".to_owned()).into()),
    }
}

fn probe_id(digits: &str) -> Result<ProbeId, String> {
    ProbeId::of_digits(digits).ok_or_else(|| "must be 24 hexadecimal digits".to_owned())
}

/// The probe's identity as it states it in its next report; health comes every 5 s.
///
/// # Errors
/// The line failed, or no report came.
pub(super) fn heard(line: &mut Line, deadline: Duration) -> anyhow::Result<ProbeId> {
    let deadline = deadline.max(HEALTH);
    let found = listen(line, deadline, |message| match message {
        Message::Health(health) => Some(health.probe),
        Message::Boot(boot) => Some(boot.probe),
        _ => None,
    })?;
    found.map_err(|counters| {
        let what = format!("the probe does not say which it is within {} s ({counters}): --probe", deadline.as_secs());
        Failure::Missing(what).into()
    })
}

/// Reads the line until `is_it` finds a message; else says how much came.
pub(super) fn listen<T>(
    line: &mut Line,
    deadline: Duration,
    is_it: impl Fn(Message) -> Option<T>,
) -> anyhow::Result<Result<T, String>> {
    let until = Instant::now() + deadline;
    let mut decoder = FrameDecoder::<MAX_DECODED>::new();
    let mut buffer = [0; 1024];
    while Instant::now() < until {
        let count = match line.read(&mut buffer)? {
            Received::Bytes(count) => count,
            Received::Nothing => continue,
            Received::End => return Err(Failure::Missing("the line ended without an answer".to_owned()).into()),
        };
        let read = buffer.get(..count).unwrap_or_default();
        for (place, &byte) in (1..).zip(read) {
            let message = decoder.push(byte).and_then(|frame| Message::decode(&frame).ok());
            if let Some(found) = message.and_then(&is_it) {
                line.put_back(read.get(place..).unwrap_or_default());
                return Ok(Ok(found));
            }
        }
    }
    let heard = decoder.counters();
    Ok(Err(format!("{} frames came, {} bad", heard.frames, heard.bad)))
}

/// Sends a command, once more if the probe has seen a higher counter from another host or had no room for the counter,
/// and waits for the answer; else says how much came.
///
/// # Errors
/// The line failed, or the key cannot be used.
pub(super) fn send_counting(
    line: &mut Line,
    command: &Command,
    mut key: Option<&mut KeyFile>,
    probe: ProbeId,
    deadline: Duration,
) -> anyhow::Result<Result<Outcome, String>> {
    let answer = send(line, command, key.as_deref_mut(), probe, deadline)?;
    match (&answer, key) {
        (
            Ok(Outcome::Refused(CommandRefusal::Replayed { latest } | CommandRefusal::CounterTooFar { latest })),
            Some(key),
        ) => {
            key.set_latest(*latest)?;
            send(line, command, Some(key), probe, deadline)
        }
        // At rest the probe has made room by now.
        (Ok(Outcome::Refused(CommandRefusal::CounterNotStored)), Some(key)) => {
            send(line, command, Some(key), probe, deadline)
        }
        _ => Ok(answer),
    }
}

/// Sends a command and waits for the answer; else says how much came.
///
/// # Errors
/// The line failed, or the key cannot be used.
fn send(
    line: &mut Line,
    command: &Command,
    key: Option<&mut KeyFile>,
    probe: ProbeId,
    deadline: Duration,
) -> anyhow::Result<Result<Outcome, String>> {
    // A late answer to an earlier command must not count: each command has its own sequence number.
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let sequence = now.as_millis() as u16;
    let frame = match key {
        Some(key) => {
            let counter = key.next_counter()?;
            let key = key.key(probe).ok_or_else(|| Failure::BadInput("no key".to_owned()))?;
            let mut payload = [0; MAX_PAYLOAD];
            framed(Kind::AuthenticatedCommand, sequence, authenticate(&key, counter, command, &mut payload)?)?
        }
        None => frame_of(command, sequence)?,
    };
    exchange(line, &frame, sequence, deadline)
}

/// Why a command has no answer, with what came.
pub(super) fn no_answer(deadline: Duration, counters: &str) -> Failure {
    let seconds = deadline.as_secs();
    Failure::Missing(format!(
        "no answer within {seconds} s ({counters}): whether the command was carried out is not known"
    ))
}

/// Sends a frame and waits for the answer to its sequence number; else says how much came.
///
/// # Errors
/// The line failed.
pub(super) fn exchange(
    line: &mut Line,
    frame: &[u8],
    sequence: u16,
    deadline: Duration,
) -> anyhow::Result<Result<Outcome, String>> {
    line.write(frame).map_err(|e| Failure::Missing(format!("the command could not be sent: {e}")))?;
    listen(line, deadline, |message| match message {
        Message::Acknowledgement(answer) if answer.sequence == sequence => Some(answer.outcome),
        _ => None,
    })
}
