//! Update of the program over the line, as the loop of the program goes on with it.

use super::{Application, Board, Statics};
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

impl<B: Board> Application<'_, B> {
    /// Takes a part of an image; returns the answer to it. Nothing answers a part that nobody with the key has
    /// announced, so that nobody else can fill the line with answers.
    #[inline(never)]
    pub(super) fn take_part(board: &mut B, frame: &Frame<'_>) -> Option<Acknowledgement> {
        let update = board.program_update().filter(|update| update.report().received.is_some())?;
        let outcome = match postcard::take_from_bytes::<ImagePart<'_>>(frame.payload) {
            Ok((part, [])) => update.part(&part),
            _ => Err(CommandRefusal::Malformed),
        };
        let outcome = outcome.map_or_else(Outcome::Refused, |()| Outcome::Accepted);
        Some(Acknowledgement { sequence: frame.sequence, outcome })
    }

    /// Begins to receive an image.
    pub(super) fn begin_update(&mut self, image: &Image) -> Result<(), CommandRefusal> {
        self.board.program_update().ok_or(CommandRefusal::NotSupported)?.begin(image)
    }

    /// Ends the transfer of an image.
    pub(super) fn finish_update(&mut self) -> Result<(), CommandRefusal> {
        self.board.program_update().ok_or(CommandRefusal::NotSupported)?.finish()
    }

    /// Restarts when the answer has left.
    pub(super) fn restart(&mut self, now_us: u64) -> Result<(), CommandRefusal> {
        self.board.program_update().ok_or(CommandRefusal::NotSupported)?;
        self.restart_us = Some(now_us.saturating_add(ANSWER_US));
        Ok(())
    }

    /// Erases a block for an image, at rest only, and restarts when it is time to.
    #[inline(never)]
    pub(super) fn go_on_updating(&mut self) {
        let now_us = self.board.now_us();
        if self.restart_us.is_some_and(|at| now_us >= at) {
            self.restart_us = None;
            self.board.restart();
        }
        let Statics { surveyor, .. } = &self.statics;
        if surveyor.stands_still(now_us)
            && let Some(update) = self.board.program_update()
        {
            update.erase_next();
        }
    }

    /// Confirms the program once it has fed the watchdog for long enough.
    #[inline(never)]
    pub(super) fn confirm_program(&mut self) {
        if self.board.now_us() < PROVEN_US || self.confirmations >= MOST_CONFIRMATIONS {
            return;
        }
        self.confirmations += 1;
        if let Some(update) = self.board.program_update()
            && (update.report().confirmed || update.confirm())
        {
            self.confirmations = MOST_CONFIRMATIONS;
        }
    }

    /// Sends which program runs.
    #[inline(never)]
    pub(super) fn report_program(&mut self, now_us: u64) {
        if let Some(report) = self.board.program_update().map(|update| update.report()) {
            self.statics.line.program(now_us, &report);
        }
    }
}
