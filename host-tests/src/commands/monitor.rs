//! `mwd monitor`: shows what a probe reports, live, as a page or once.

use std::{
    io::{self, IsTerminal, Write},
    thread,
    time::{Duration, Instant},
};

use clap::Args;
use meerkat_mwd::telemetry::{FrameDecoder, MAX_DECODED, Message};

use crate::port::{
    line::{Line, LineArgs, Received},
    monitor::{History, LivePage, State, draw, summary_lines},
};
use testbed::{console::stdout, failure::Failure};

/// Options of `monitor`.
#[derive(Debug, Clone, Args)]
pub struct MonitorArgs {
    /// Port of the probe.
    #[command(flatten)]
    pub line: LineArgs,
    /// Listen, print one summary and end; the default where standard output is no terminal
    #[arg(long)]
    pub once: bool,
    /// Seconds to listen with --once; a captured file is read to its end
    #[arg(long, value_name = "S", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub seconds: u64,
    /// Show it as a page for browsers on this machine, at http://127.0.0.1:N/; 0 takes any number that is
    /// free
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "7878", conflicts_with = "once")]
    pub web: Option<u16>,
}

/// Time between two pictures of the live view.
const FRAME: Duration = Duration::from_millis(100);

/// Time after which the live page has something new: half of what it waits between two questions.
const NEWS: Duration = Duration::from_millis(250);

/// Listens to the probe and shows what it reports, live or once.
///
/// # Errors
/// Bad usage, no port, or nothing that a probe said.
pub fn run(args: &MonitorArgs) -> anyhow::Result<()> {
    let mut line = Line::open(&args.line)?;
    let mut listener = Listener::default();
    if let Some(port) = args.web {
        return serve(port, &mut line, &mut listener);
    }
    if args.once || !io::stdout().is_terminal() {
        let until = Instant::now() + Duration::from_secs(args.seconds);
        while (!line.is_live() || Instant::now() < until) && listener.listen(&mut line)? {}
        let lines = summary_lines(listener.told());
        if lines.is_empty() {
            let heard = listener.decoder.counters();
            let what = format!("{}: nothing that a probe says: {} bad frames", args.line.place, heard.bad);
            return Err(if line.is_live() { Failure::Missing(what) } else { Failure::BadInput(what) }.into());
        }
        let mut out = stdout();
        for line in lines {
            writeln!(out, "{line}")?;
        }
        return Ok(());
    }
    let mut terminal = ratatui::init();
    let shown = show(&mut terminal, &mut line, &mut listener);
    ratatui::restore();
    shown
}

/// Serves the live view as a page until Ctrl-C; what a captured file holds stays to be seen.
fn serve(port: u16, line: &mut Line, listener: &mut Listener) -> anyhow::Result<()> {
    let page = LivePage::open(port)?;
    writeln!(stdout(), "live page: http://{}/ (Ctrl-C ends)", page.address())?;
    let mut goes_on = true;
    while goes_on {
        let next = Instant::now() + NEWS;
        while goes_on && Instant::now() < next {
            goes_on = listener.listen(line)?;
        }
        let lines = summary_lines(listener.told());
        page.show(&listener.history, &lines);
    }
    loop {
        thread::park();
    }
}

/// Shows the live view until q, Esc or Ctrl-C.
fn show(terminal: &mut ratatui::DefaultTerminal, line: &mut Line, listener: &mut Listener) -> anyhow::Result<()> {
    use ratatui::crossterm::event::{self, Event, KeyCode, KeyModifiers};
    let mut goes_on = true;
    loop {
        let next = Instant::now() + FRAME;
        while goes_on && Instant::now() < next {
            goes_on = listener.listen(line)?;
        }
        let state = listener.told();
        terminal.draw(|frame| draw(frame, state))?;
        while event::poll(if goes_on { Duration::ZERO } else { FRAME })? {
            if let Event::Key(key) = event::read()? {
                let control_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
                if control_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                    return Ok(());
                }
            }
        }
    }
}

#[derive(Default)]
struct Listener {
    decoder: FrameDecoder<MAX_DECODED>,
    state: State,
    history: History,
}

impl Listener {
    /// Takes the bytes that are there. Returns whether more may come.
    fn listen(&mut self, line: &mut Line) -> anyhow::Result<bool> {
        let mut buffer = [0; 4096];
        let count = match line.read(&mut buffer)? {
            Received::Bytes(count) => count,
            Received::Nothing => return Ok(true),
            Received::End => return Ok(false),
        };
        for &byte in buffer.get(..count).unwrap_or_default() {
            if let Some(frame) = self.decoder.push(byte) {
                match Message::decode(&frame) {
                    Ok(message) => {
                        self.history.take(&message);
                        self.state.take(message);
                    }
                    Err(_) => self.state.not_understood += 1,
                }
            }
        }
        Ok(true)
    }

    fn told(&mut self) -> &State {
        self.state.link = self.decoder.counters();
        &self.state
    }
}
