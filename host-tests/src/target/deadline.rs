//! Programs run to their end or to a deadline: nothing that `mwd` starts may wait for ever.

use std::{
    fs::File,
    io::{self, Read, Seek},
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Most output shown of a failed program, bytes.
const TAIL: usize = 2_000;

/// Reasons why a program did not succeed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// The program could not be started, or its output not stored.
    #[error("{program} cannot be run: {source}")]
    NotRun {
        /// The program.
        program: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The program was stopped at the deadline.
    #[error("{program} was stopped after {seconds} s\n{tail}")]
    TimedOut {
        /// The program.
        program: String,
        /// The deadline.
        seconds: u64,
        /// The end of its output.
        tail: String,
    },
    /// The program ended without success.
    #[error("{program} failed ({status})\n{tail}")]
    Failed {
        /// The program.
        program: String,
        /// Exit status of the program.
        status: ExitStatus,
        /// The end of its output.
        tail: String,
    },
}

/// Runs `command` without input and returns its standard output.
///
/// # Errors
/// The program could not be started, was stopped at the deadline, or failed; with the end of its output.
pub fn run(command: &mut Command, deadline: Duration) -> Result<String, CommandError> {
    let program = command.get_program().to_string_lossy().into_owned();
    let not_run = |source| CommandError::NotRun { program: program.clone(), source };

    // Output goes to files: a pipe fills up if nobody reads it, and stays open while a grandchild lives.
    let mut stdout = tempfile::tempfile().map_err(not_run)?;
    let mut stderr = tempfile::tempfile().map_err(not_run)?;
    command.stdin(Stdio::null());
    command.stdout(stdout.try_clone().map_err(not_run)?);
    command.stderr(stderr.try_clone().map_err(not_run)?);

    let ended = wait(command, deadline).map_err(not_run)?;
    let output = text(&mut stdout).map_err(not_run)?;
    let mut tail = || -> Result<String, CommandError> {
        let errors = text(&mut stderr).map_err(not_run)?;
        Ok(last(if errors.trim().is_empty() { &output } else { &errors }).to_owned())
    };
    match ended {
        Some(status) if status.success() => Ok(output),
        Some(status) => Err(CommandError::Failed { tail: tail()?, program, status }),
        None => Err(CommandError::TimedOut { tail: tail()?, program, seconds: deadline.as_secs() }),
    }
}

/// Waits for the end; `None` if the program had to be stopped.
fn wait(command: &mut Command, deadline: Duration) -> io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    let mut child = command.spawn()?;
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() >= deadline {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

fn text(file: &mut File) -> io::Result<String> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The last lines of a text, as many as fit, at least one.
fn last(text: &str) -> &str {
    let text = text.trim_end();
    let mut from = text.rfind('\n').map_or(0, |newline| newline + 1);
    for (newline, _) in text.rmatch_indices('\n') {
        if text.len() - newline > TAIL {
            return text.get(from..).unwrap_or_default();
        }
        from = newline + 1;
    }
    if text.len() <= TAIL { text } else { text.get(from..).unwrap_or_default() }
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn shell(script: &str, deadline: Duration) -> Result<String, CommandError> {
        run(Command::new("sh").args(["-c", script]), deadline)
    }

    #[test]
    fn output_comes_back_whole_even_when_it_is_larger_than_a_pipe() {
        let output = shell("echo noise >&2; yes | head -n 200000", Duration::from_secs(20)).unwrap();
        assert_eq!(output.len(), 400_000);
    }

    #[test]
    fn a_failure_tells_the_end_of_what_was_printed() {
        let error = shell("seq 100000 >&2; exit 7", Duration::from_secs(20)).unwrap_err();
        let CommandError::Failed { status, tail, .. } = error else { unreachable!("{error}") };
        assert_eq!(status.code(), Some(7));
        assert!(tail.ends_with("\n100000") && tail.len() <= TAIL, "{tail}");
        assert!(tail.lines().all(|line| line.len() >= 5), "a cut line: {tail}");
    }

    #[test]
    fn a_program_that_hangs_is_stopped() {
        let start = Instant::now();
        let error = shell("echo before; exec sleep 60", Duration::from_millis(200)).unwrap_err();
        assert!(matches!(&error, CommandError::TimedOut { tail, .. } if tail == "before"), "{error}");
        assert!(start.elapsed() < Duration::from_secs(20));
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let error = run(&mut Command::new("no-such-program"), Duration::from_secs(1)).unwrap_err();
        assert!(error.to_string().contains("no-such-program"), "{error}");
    }
}
