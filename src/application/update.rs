//! Update of the program over the line, as the loop of the program goes on with it.

use super::Board;
use crate::{
    storage::Image,
    telemetry::{Acknowledgement, CommandRefusal, Frame, ImagePart, Outcome},
};

/// Microseconds from the start to when a program that has fed its watchdog all the while runs well.
pub const PROVEN_US: u64 = 30_000_000;

/// Microseconds from the command to the restart, in which its answer leaves.
const ANSWER_US: u64 = 500_000;

/// Calls of [`ProgramUpdate::confirm`](super::ProgramUpdate::confirm) before a flash that fails is left alone.
const MOST_CONFIRMATIONS: u8 = 3;

/// Work still to be done for an update: a restart, and the confirmation of the program that runs.
pub(super) struct Update {
    /// When the program restarts, if a command has asked for it.
    restart_us: Option<u64>,
    /// Attempts to confirm the program.
    confirmations: u8,
}

impl Update {
    pub const fn new() -> Self {
        Self { restart_us: None, confirmations: 0 }
    }

    /// Restarts when the answer has left.
    pub fn restart<B: Board>(&mut self, board: &mut B, now_us: u64) -> Result<(), CommandRefusal> {
        board.program_update().ok_or(CommandRefusal::NotSupported)?;
        self.restart_us = Some(now_us.saturating_add(ANSWER_US));
        Ok(())
    }

    /// Restarts at once if a restart was due later: the clock went back.
    pub fn clock_went_back(&mut self, now_us: u64) {
        self.restart_us = self.restart_us.map(|_| now_us);
    }

    /// Erases a page for an image, at rest only, and restarts when it is time to.
    #[inline(never)]
    pub fn go_on<B: Board>(&mut self, board: &mut B, now_us: u64, stands_still: bool) {
        if self.restart_us.is_some_and(|at| now_us >= at) {
            self.restart_us = None;
            board.restart();
        }
        if stands_still && let Some(update) = board.program_update() {
            update.erase_next();
        }
    }

    /// Confirms the program once it has fed the watchdog for long enough.
    #[inline(never)]
    pub fn confirm<B: Board>(&mut self, board: &mut B) {
        if board.now_us() < PROVEN_US || self.confirmations >= MOST_CONFIRMATIONS {
            return;
        }
        self.confirmations += 1;
        if let Some(update) = board.program_update()
            && (update.report().confirmed || update.confirm())
        {
            self.confirmations = MOST_CONFIRMATIONS;
        }
    }
}

/// Takes a part of an image; returns the answer to it. Nothing answers a part that nobody with the key has announced.
#[inline(never)]
pub(super) fn take_part<B: Board>(board: &mut B, frame: &Frame<'_>) -> Option<Acknowledgement> {
    let update = board.program_update().filter(|update| update.report().received.is_some())?;
    let outcome = match postcard::take_from_bytes::<ImagePart<'_>>(frame.payload) {
        Ok((part, [])) => update.part(&part),
        _ => Err(CommandRefusal::Malformed),
    };
    let outcome = outcome.map_or_else(Outcome::Refused, |()| Outcome::Accepted);
    Some(Acknowledgement { sequence: frame.sequence, outcome })
}

/// Begins to receive an image.
pub(super) fn begin<B: Board>(board: &mut B, image: &Image) -> Result<(), CommandRefusal> {
    board.program_update().ok_or(CommandRefusal::NotSupported)?.begin(image)
}

/// Ends the transfer of an image.
pub(super) fn finish<B: Board>(board: &mut B) -> Result<(), CommandRefusal> {
    board.program_update().ok_or(CommandRefusal::NotSupported)?.finish()
}
