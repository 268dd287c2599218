//! `mwd command`: ask a probe for something and wait for its answer.

mod key_file;
mod request;

use std::{
    io::{self, Write},
    path::PathBuf,
    time::{Duration, Instant, SystemTime},
};

use clap::Args;
use meerkat_mwd::telemetry::{
    Command, CommandRefusal, FrameDecoder, Kind, MAX_DECODED, MAX_FRAME, MAX_PAYLOAD, Message, Outcome, ProbeId,
    authenticate, encode_frame, encode_payload,
};

use crate::{
    failure::Failure,
    line::{Line, LineArgs, Received},
};
pub use key_file::KeyFile;
pub use request::Request;

/// How long a probe may take to say which it is.
const HEALTH: Duration = Duration::from_secs(10);

/// Options of `command`.
#[derive(Debug, Clone, Args)]
pub struct CommandArgs {
    /// Where the probe is
    #[command(flatten)]
    pub line: LineArgs,
    /// The probe's key, 64 hexadecimal digits; the counter is kept beside it. Commands that change
    /// calibration or the stream need it
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// The unique number of the probe that is meant, 24 hexadecimal digits. Without it that which the probe
    /// says
    #[arg(long, value_name = "DIGITS", value_parser = probe_id)]
    pub probe: Option<ProbeId>,
    /// How long to wait for the answer, seconds
    #[arg(long, value_name = "S", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3_600))]
    pub deadline: u64,
    /// What is asked for
    #[command(subcommand)]
    pub request: Request,
}

/// Sends the command; says what came of it.
///
/// # Errors
/// 2 for bad usage and for a refusal, 3 for a port, a key or an answer that is not there.
pub fn run(args: &CommandArgs) -> anyhow::Result<()> {
    let command = args.request.command()?;
    // The probe's clock is not known here; it looks at times itself.
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
    let mut answer = send(&mut line, &command, key.as_mut(), probe, deadline)?;
    // Another host may have used the counter further: once more from there.
    if let (
        Outcome::Refused(CommandRefusal::Replayed { latest } | CommandRefusal::CounterTooFar { latest }),
        Some(key),
    ) = (&answer, &mut key)
    {
        key.set_latest(*latest)?;
        answer = send(&mut line, &command, Some(key), probe, deadline)?;
    }
    match answer {
        Outcome::Accepted => writeln!(io::stdout(), "accepted").map_err(Into::into),
        Outcome::Refused(reason) => Err(Failure::BadInput(format!("the probe refused: {reason}")).into()),
        _ => Err(Failure::BadInput("the probe's answer is of another version".to_owned()).into()),
    }
}

/// The frame of a command that needs no authentication.
///
/// # Errors
/// None in practice: every command fits.
pub fn frame_of(command: &Command, sequence: u16) -> anyhow::Result<Vec<u8>> {
    let mut payload = [0; MAX_PAYLOAD];
    framed(Kind::Command, sequence, encode_payload(command, &mut payload)?)
}

fn framed(kind: Kind, sequence: u16, payload: &[u8]) -> anyhow::Result<Vec<u8>> {
    let mut buffer = [0; MAX_FRAME];
    // The zero cuts off whatever noise the probe has heard before.
    let mut bytes = vec![0];
    bytes.extend_from_slice(encode_frame(kind, sequence, payload, &mut buffer)?);
    Ok(bytes)
}

fn probe_id(digits: &str) -> Result<ProbeId, String> {
    ProbeId::of_digits(digits).ok_or_else(|| "must be 24 hexadecimal digits".to_owned())
}

/// Which probe it is, as it says in its next report: health comes every 5 s.
fn heard(line: &mut Line, deadline: Duration) -> anyhow::Result<ProbeId> {
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

/// What comes, until `is_it` finds something; else how much came.
fn listen<T>(
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
        for &byte in buffer.get(..count).unwrap_or_default() {
            let message = decoder.push(byte).and_then(|frame| Message::decode(&frame).ok());
            if let Some(found) = message.and_then(&is_it) {
                return Ok(Ok(found));
            }
        }
    }
    let heard = decoder.counters();
    Ok(Err(format!("{} frames came, {} bad", heard.frames, heard.bad)))
}

fn send(
    line: &mut Line,
    command: &Command,
    key: Option<&mut KeyFile>,
    probe: ProbeId,
    deadline: Duration,
) -> anyhow::Result<Outcome> {
    // An answer to an earlier command that comes late has another number.
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
    line.write(&frame).map_err(|e| Failure::Missing(format!("the command could not be sent: {e}")))?;
    let answered = listen(line, deadline, |message| match message {
        Message::Acknowledgement(answer) if answer.sequence == sequence => Some(answer.outcome),
        _ => None,
    })?;
    answered.map_err(|counters| {
        let seconds = deadline.as_secs();
        let what =
            format!("no answer within {seconds} s ({counters}): whether the command was carried out is not known");
        Failure::Missing(what).into()
    })
}
