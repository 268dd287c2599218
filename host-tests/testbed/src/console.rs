//! Where a command reads, tells and writes: `-` stands for the standard input and output, a result on the
//! standard output sends what is told to the standard error, and a quiet run tells nothing.

use std::{
    fs::File,
    io::{self, IsTerminal, Read, Write},
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};

use crate::failure::Failure;

/// Name of the standard input among inputs, and of the standard output among outputs.
pub const STDIO: &str = "-";

static QUIET: AtomicBool = AtomicBool::new(false);
static RESULT_ON_STDOUT: AtomicBool = AtomicBool::new(false);
static READER_IS_GONE: AtomicBool = AtomicBool::new(false);

/// Sets what the whole run goes by: whether it tells nothing but errors, and whether its result is the standard output.
pub fn begin(quiet: bool, result_on_stdout: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
    RESULT_ON_STDOUT.store(result_on_stdout, Ordering::Relaxed);
}

/// Returns true if only errors are told.
#[must_use]
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Returns true if the standard output or error could not be written since its reader has closed it: it has what it
/// wanted.
#[must_use]
pub fn reader_is_gone() -> bool {
    READER_IS_GONE.load(Ordering::Relaxed)
}

/// Name of the standard output in an error.
const STDOUT: &str = "standard output";

/// The error of a standard output; if it is that of a closed pipe, keeps that in mind. The error of a probe's line that
/// broke is of the same kind, and must not pass for one.
fn noted(error: io::Error) -> io::Error {
    if error.kind() == io::ErrorKind::BrokenPipe {
        READER_IS_GONE.store(true, Ordering::Relaxed);
    }
    error
}

/// An output whose errors say that they are its own.
struct Named<W> {
    name: &'static str,
    out: W,
}

impl<W> Named<W> {
    /// The error with the output's name.
    fn failed(&self, error: io::Error) -> io::Error {
        let error = noted(error);
        io::Error::new(error.kind(), Failure::output(Path::new(self.name), &error))
    }
}

impl<W: Write> Write for Named<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes).map_err(|error| self.failed(error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush().map_err(|error| self.failed(error))
    }
}

/// The standard output in the place of a file, which who writes it names.
struct AsFile(io::Stdout);

impl Write for AsFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(noted)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(noted)
    }
}

/// The standard output, for a command whose result is always there.
#[must_use]
pub fn stdout() -> impl Write {
    Named { name: STDOUT, out: io::stdout() }
}

/// Where a command tells what it did, without colours where it is no terminal.
#[must_use]
pub fn told() -> Box<dyn Write> {
    if is_quiet() {
        Box::new(io::sink())
    } else if RESULT_ON_STDOUT.load(Ordering::Relaxed) {
        Box::new(Named { name: "standard error", out: anstream::stderr() })
    } else {
        Box::new(Named { name: STDOUT, out: anstream::stdout() })
    }
}

/// Returns true if what a command tells is read at a terminal.
#[must_use]
pub fn tells_a_terminal() -> bool {
    if RESULT_ON_STDOUT.load(Ordering::Relaxed) { io::stderr().is_terminal() } else { io::stdout().is_terminal() }
}

/// Returns true if a path stands for the standard input or output.
#[must_use]
pub fn is_stdio(path: &Path) -> bool {
    path.as_os_str() == STDIO
}

/// A file to write, or the standard output.
///
/// # Errors
/// The file cannot be made.
pub fn create(path: &Path) -> io::Result<Box<dyn Write>> {
    Ok(if is_stdio(path) { Box::new(AsFile(io::stdout())) } else { Box::new(File::create(path)?) })
}

/// Writes a text to a file or to the standard output.
///
/// # Errors
/// It cannot be written.
pub fn save(path: &Path, text: &str) -> io::Result<()> {
    let mut out = create(path)?;
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// A file to read, or the standard input.
///
/// # Errors
/// The file cannot be opened.
pub fn open(path: &Path) -> io::Result<Box<dyn Read>> {
    Ok(if is_stdio(path) { Box::new(io::stdin()) } else { Box::new(File::open(path)?) })
}

/// Text of a file, or of the standard input.
///
/// # Errors
/// It cannot be read, or is no UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text).map(|_| text)
}
