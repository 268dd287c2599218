//! `mwd command`: ask a probe for something and wait for its answer.

use std::{
    io::{self, Write},
    path::PathBuf,
    time::{Duration, Instant, SystemTime},
};

use clap::Args;
use meerkat_mwd::telemetry::{
    Command, CommandRefusal, FrameDecoder, Kind, MAX_DECODED, MAX_PAYLOAD, Message, Outcome, authenticate,
};

use super::request::Request;
use crate::{
    failure::Failure,
    port::{
        command_frame::{frame_of, framed},
        key_file::KeyFile,
        line::{Line, LineArgs, Received},
    },
};

/// Options of `command`.
#[derive(Debug, Clone, Args)]
pub struct CommandArgs {
    /// Where the probe is
    #[command(flatten)]
    pub line: LineArgs,
    /// The probe's key, 64 hexadecimal digits; the counter is kept beside it. Commands that change calibration need it
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
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
        None if command.changes_calibration() => {
            return Err(Failure::BadInput("this changes calibration and needs --key FILE".to_owned()).into());
        }
        None => None,
    };
    let mut line = Line::open(&args.line)?;
    if !line.is_live() {
        return Err(Failure::BadInput(format!("{}: a capture takes no commands", args.line.place)).into());
    }
    let deadline = Duration::from_secs(args.deadline);
    let mut answer = send(&mut line, &command, key.as_mut(), deadline)?;
    // Another host may have used the counter further: once more from there.
    if let (
        Outcome::Refused(CommandRefusal::Replayed { latest } | CommandRefusal::CounterTooFar { latest }),
        Some(key),
    ) = (&answer, &mut key)
    {
        key.set_latest(*latest)?;
        answer = send(&mut line, &command, Some(key), deadline)?;
    }
    match answer {
        Outcome::Accepted => writeln!(io::stdout(), "accepted").map_err(Into::into),
        Outcome::Refused(reason) => Err(Failure::BadInput(format!("the probe refused: {reason}")).into()),
        _ => Err(Failure::BadInput("the probe's answer is of another version".to_owned()).into()),
    }
}

fn send(line: &mut Line, command: &Command, key: Option<&mut KeyFile>, deadline: Duration) -> anyhow::Result<Outcome> {
    // An answer to an earlier command that comes late has another number.
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let sequence = now.as_millis() as u16;
    let frame = match key {
        Some(key) => {
            let counter = key.next_counter()?;
            let mut payload = [0; MAX_PAYLOAD];
            framed(Kind::AuthenticatedCommand, sequence, authenticate(key.key(), counter, command, &mut payload)?)?
        }
        None => frame_of(command, sequence)?,
    };
    line.write(&frame).map_err(|e| Failure::Missing(format!("the command could not be sent: {e}")))?;
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
            if let Some(frame) = decoder.push(byte)
                && let Ok(Message::Acknowledgement(answer)) = Message::decode(&frame)
                && answer.sequence == sequence
            {
                return Ok(answer.outcome);
            }
        }
    }
    let heard = decoder.counters();
    let what = format!(
        "no answer within {} s ({} frames came, {} bad): whether the command was carried out is not known",
        deadline.as_secs(),
        heard.frames,
        heard.bad
    );
    Err(Failure::Missing(what).into())
}
