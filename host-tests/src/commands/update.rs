//! `mwd update`: send another image of the program into a probe, start it on trial, and wait until it has confirmed
//! itself.

use std::{
    fs,
    io::Write,
    path::PathBuf,
    thread,
    time::{Duration, Instant},
};

use blake2::{Blake2s256, Digest};
use clap::Args;
use meerkat_mwd::telemetry::{
    Command, CommandRefusal, ImagePart, Kind, MAX_PAYLOAD, Message, Outcome, ProbeId, ProgramReport, encode_payload,
};

use super::command::{HEALTH, exchange, heard, listen, no_answer, send_counting};
use crate::{
    port::{
        key_file::KeyFile,
        line::{Line, LineArgs},
    },
    target::image::Image,
};
use testbed::{command_frame::framed, console::stdout, failure::Failure};

/// Wait for the answer to a part before it is sent again.
const PART: Duration = Duration::from_secs(2);
/// Longest wait for the answer to a command before it is given again, also a quarter of the deadline: a survey and a
/// diagnosis on a line of 9,600 baud go first.
const COMMAND: Duration = Duration::from_secs(10);
/// First and longest pause before a command is given again to a probe that moves, or whose program is on trial. Each
/// pause is twice as long as the one before: every try takes room in the probe's flash, which ends while it drills.
const PAUSES: [Duration; 2] = [Duration::from_secs(2), Duration::from_secs(60)];
/// Pause before a part is sent again to a probe that still erases.
const ERASING: Duration = Duration::from_millis(300);

/// Options of `update`.
#[derive(Debug, Clone, Args)]
pub struct UpdateArgs {
    /// Port of the probe.
    #[command(flatten)]
    pub line: LineArgs,
    /// Image of the program, an ELF file or the bytes as they stand in the probe's memory
    #[arg(long, value_name = "FILE")]
    pub image: PathBuf,
    /// Number of the image, above those of the images that the probe has
    #[arg(long, value_name = "N")]
    pub number: u32,
    /// File with the probe's key, 64 hexadecimal digits
    #[arg(long, value_name = "FILE")]
    pub key: PathBuf,
    /// Seconds to wait for each answer, and for the new program to confirm itself
    #[arg(long, value_name = "S", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..=3_600))]
    pub deadline: u64,
}

/// A probe that takes another program.
struct Probe {
    line: Line,
    key: KeyFile,
    id: ProbeId,
    deadline: Duration,
    /// Sequence number of the latest part.
    sequence: u16,
}

/// Sends the image, has it started, and says whether it stays.
///
/// # Errors
/// 2 for bad usage, a refusal, and a probe that went back to the program before; 3 for a port, a file or an answer that
/// is not there.
pub fn run(args: &UpdateArgs) -> anyhow::Result<()> {
    let bytes = image(args)?;
    let key = KeyFile::open(&args.key)?;
    let mut line = Line::open(&args.line)?;
    if !line.is_live() {
        return Err(Failure::BadInput(format!("{}: a capture takes no commands", args.line.place)).into());
    }
    let deadline = Duration::from_secs(args.deadline);
    let id = heard(&mut line, deadline)?;
    let mut probe = Probe { line, key, id, deadline, sequence: 0 };
    let runs = probe.program(HEALTH.max(deadline))?;
    let mut stdout = stdout();
    writeln!(stdout, "probe: {id}, program {}{}", runs.number, if runs.confirmed { "" } else { ", on trial" })?;
    if runs.confirmed && runs.number > args.number {
        let what = format!("the probe runs program {}; it takes none with a lower number", runs.number);
        return Err(Failure::BadInput(what).into());
    }
    if runs.number != args.number {
        if runs.other == Some(args.number) {
            writeln!(stdout, "image {}: in the probe already", args.number)?;
        } else {
            probe.send(args.number, &bytes)?;
            writeln!(stdout, "image {}: {} bytes written and compared with their digest", args.number, bytes.len())?;
        }
        probe.restart(args.number)?;
    }
    let until = Instant::now() + deadline;
    loop {
        let runs = probe.program(until.saturating_duration_since(Instant::now()))?;
        if runs.number != args.number {
            let what = format!("image {} did not confirm itself: the probe went back to {}", args.number, runs.number);
            return Err(Failure::BadInput(what).into());
        }
        if runs.confirmed {
            return writeln!(stdout, "program {}: runs and has confirmed itself", args.number).map_err(Into::into);
        }
    }
}

/// Bytes of the image.
fn image(args: &UpdateArgs) -> Result<Vec<u8>, Failure> {
    let path = args.image.display();
    let bytes = fs::read(&args.image).map_err(|error| Failure::BadInput(format!("{path}: {error}")))?;
    if !bytes.starts_with(b"\x7fELF") {
        return Ok(bytes);
    }
    let loaded = Image::parse(&bytes).and_then(|image| image.loaded());
    loaded.map_err(|error| Failure::BadInput(format!("{path}: {error}")))
}

impl Probe {
    /// The program that runs, by the probe's next report.
    fn program(&mut self, deadline: Duration) -> anyhow::Result<ProgramReport> {
        let report = listen(&mut self.line, deadline, |message| match message {
            Message::Program(report) => Some(report),
            _ => None,
        })?;
        report.map_err(|counters| {
            Failure::Missing(format!("the probe does not say which program it runs ({counters})")).into()
        })
    }

    /// Gives a command with the key, again while the probe does not stand still or is busy. Where the command or its
    /// answer was lost, the probe's report tells whether it `is_done`; else the command is given again.
    fn ask(&mut self, command: &Command, is_done: impl Fn(&ProgramReport) -> bool) -> anyhow::Result<()> {
        let until = Instant::now() + self.deadline;
        let wait = COMMAND.min(self.deadline / 4);
        let [mut pause, longest] = PAUSES;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match send_counting(&mut self.line, command, Some(&mut self.key), self.id, wait)? {
                Ok(Outcome::Accepted) => return Ok(()),
                Ok(Outcome::Refused(CommandRefusal::WhileDrilling | CommandRefusal::Busy)) if !left.is_zero() => {
                    // Reports that the probe sends meanwhile are read, so that its latest is not an old one.
                    let _ = listen(&mut self.line, pause.min(left), |_| None::<()>)?;
                    pause = longest.min(2 * pause);
                }
                Ok(Outcome::Refused(reason)) => {
                    return Err(Failure::BadInput(format!("the probe refused: {reason}")).into());
                }
                Ok(_) => return Err(Failure::BadInput("the probe's answer is of another version".to_owned()).into()),
                Err(counters) if left.is_zero() => return Err(no_answer(self.deadline, &counters).into()),
                Err(_) if is_done(&self.program(HEALTH.max(self.deadline))?) => return Ok(()),
                Err(_) => (),
            }
        }
    }

    /// Starts the other image, and waits until the probe starts.
    fn restart(&mut self, number: u32) -> anyhow::Result<()> {
        self.ask(&Command::Restart, |report| report.number == number)?;
        let starts = listen(&mut self.line, self.deadline, |message| match message {
            Message::Boot(_) => Some(()),
            Message::Program(report) => (report.number == number).then_some(()),
            _ => None,
        })?;
        starts.map_err(|counters| Failure::Missing(format!("the probe does not start anew ({counters})")).into())
    }

    /// Announces the image, sends it part by part, and has it compared with its digest.
    fn send(&mut self, number: u32, bytes: &[u8]) -> anyhow::Result<()> {
        let too_long = |_| Failure::BadInput("the image does not fit".to_owned());
        let length = u32::try_from(bytes.len()).map_err(too_long)?;
        let digest = Blake2s256::digest(bytes).into();
        self.ask(&Command::BeginUpdate { number, length, digest }, |_| false)?;
        let mut offset = 0;
        let mut heard = Instant::now();
        while offset < length {
            let rest = bytes.get(offset as usize..).unwrap_or_default();
            let part = rest.get(..ImagePart::BYTES).unwrap_or(rest);
            match self.part(&ImagePart { offset, bytes: part })? {
                Some(Outcome::Accepted) => offset += part.len() as u32,
                // An answer was lost: what was sent is there.
                Some(Outcome::Refused(CommandRefusal::NotTheNext { expected })) => offset = expected,
                Some(Outcome::Refused(CommandRefusal::Busy)) => thread::sleep(ERASING),
                Some(Outcome::Refused(reason)) => {
                    return Err(Failure::BadInput(format!("the probe refused byte {offset}: {reason}")).into());
                }
                Some(_) => return Err(Failure::BadInput("an answer of another version".to_owned()).into()),
                None if heard.elapsed() > self.deadline => {
                    return Err(Failure::Missing(format!("no answer to the bytes from {offset} on")).into());
                }
                None => continue,
            }
            heard = Instant::now();
        }
        self.ask(&Command::FinishUpdate, |report| report.other == Some(number))
    }

    /// Sends a part; `None`: nothing answered.
    fn part(&mut self, part: &ImagePart<'_>) -> anyhow::Result<Option<Outcome>> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut payload = [0; MAX_PAYLOAD];
        let frame = framed(Kind::ImagePart, self.sequence, encode_payload(part, &mut payload)?)?;
        Ok(exchange(&mut self.line, &frame, self.sequence, PART)?.ok())
    }
}
