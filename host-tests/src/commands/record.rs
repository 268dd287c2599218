//! `mwd record`: turns the raw samples that a probe sends into a trace.

use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use anyhow::Context;
use clap::Args;
use meerkat_mwd::telemetry::{Command, FrameDecoder, MAX_DECODED, Message};

use crate::{
    commands::same_file::none_overwritten,
    port::{
        line::{Line, LineArgs, Received},
        recording::{Progress, Recording, beside, model_beside},
    },
};
use testbed::{command_frame::frame_of, console::told, failure::Failure};

/// Options of `record`.
#[derive(Debug, Clone, Args)]
pub struct RecordArgs {
    /// Port of the probe.
    #[command(flatten)]
    pub line: LineArgs,
    /// The trace to write, .csv or .csv.gz; the probe's configuration is written beside it as .toml
    #[arg(short, value_name = "TRACE.csv.gz")]
    pub output: PathBuf,
    /// End after this many seconds
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u64).range(1..))]
    pub seconds: Option<u64>,
    /// Only listen; do not ask the probe to start recording
    #[arg(long)]
    pub listen: bool,
    /// Also keep the bytes received
    #[arg(long, value_name = "FILE")]
    pub capture: Option<PathBuf>,
}

/// Records until the line ends or breaks, the time is over or somebody presses Ctrl-C; then writes the trace.
///
/// # Errors
/// Bad usage, no port, nothing recorded, a line that broke, or files that cannot be written.
pub fn run(args: &RecordArgs) -> anyhow::Result<()> {
    if args.output.to_str().is_none_or(|name| !name.ends_with(".csv") && !name.ends_with(".csv.gz")) {
        return Err(Failure::BadInput(format!("{}: must end in .csv or .csv.gz", args.output.display())).into());
    }
    let written = [args.output.clone(), beside(&args.output), model_beside(&args.output)];
    let outputs: Vec<&Path> = written.iter().chain(&args.capture).map(AsRef::as_ref).collect();
    none_overwritten(&outputs, &[Path::new(&args.line.place)])?;
    let mut line = Line::open(&args.line)?;
    let capture = match &args.capture {
        Some(path) => Some((path, File::create(path).map_err(|e| Failure::output(path, &e))?)),
        None => None,
    };
    let stop = Arc::new(AtomicBool::new(false));
    if line.is_live() {
        let stop = Arc::clone(&stop);
        ctrlc::set_handler(move || stop.store(true, Ordering::Relaxed))?;
    }
    let asks = line.is_live() && !args.listen;
    if asks {
        line.write(&frame_of(&Command::StartRecording { for_s: None }, 0)?)?;
    }

    let mut recording = Recording::default();
    let mut decoder = FrameDecoder::<MAX_DECODED>::new();
    let heard = listen(&mut line, args, capture, &stop, &mut decoder, &mut recording);
    if asks {
        // Even if this last command fails, the samples received so far are written.
        let _ = frame_of(&Command::StopRecording, 1).map(|frame| line.write(&frame));
    }
    if line.is_live() {
        recording.date = Some(chrono::DateTime::<chrono::Utc>::from(std::time::SystemTime::now()).date_naive());
    }
    recording.link = decoder.counters();
    if recording.is_empty() {
        heard?;
        let place = &args.line.place;
        let what = format!("{place}: no raw sample came: {}", recording.link_line());
        return Err(if line.is_live() { Failure::Missing(what) } else { Failure::BadInput(what) }.into());
    }
    let lines = recording.write(&args.output)?;
    let mut out = told();
    for line in lines {
        writeln!(out, "{line}")?;
    }
    heard.with_context(|| format!("the recording ends early, and what came before is in {}", args.output.display()))
}

/// Takes what the probe sends until the line ends, the time is over or `stop` is set.
///
/// # Errors
/// The line broke, or the capture cannot be written.
fn listen(
    line: &mut Line,
    args: &RecordArgs,
    mut capture: Option<(&PathBuf, File)>,
    stop: &AtomicBool,
    decoder: &mut FrameDecoder<MAX_DECODED>,
    recording: &mut Recording,
) -> Result<(), Failure> {
    let until = args.seconds.map(|seconds| Instant::now() + Duration::from_secs(seconds));
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) && until.is_none_or(|until| Instant::now() < until) {
        let count = match line.read(&mut buffer)? {
            Received::Bytes(count) => count,
            Received::Nothing => continue,
            Received::End => break,
        };
        let bytes = buffer.get(..count).unwrap_or_default();
        // Bytes that are captured are recorded, too, even if they are the last.
        let captured = match &mut capture {
            Some((path, file)) => file.write_all(bytes).map_err(|error| Failure::output(path, &error)),
            None => Ok(()),
        };
        for &byte in bytes {
            let Some(frame) = decoder.push(byte) else { continue };
            match Message::decode(&frame) {
                Ok(message) => {
                    if recording.take(message) == Progress::Over {
                        return captured;
                    }
                }
                Err(_) => recording.not_understood += 1,
            }
        }
        captured?;
    }
    Ok(())
}
