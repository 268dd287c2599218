//! Receiver of another program: an image is announced, comes in parts, is compared with its digest, and is tried at the
//! next start. [`ImageSlots`] keeps it apart from the image that runs.

use crate::{
    storage::{Image, ImageSlots, Receiving, Slot, StorageError},
    telemetry::{CommandRefusal, ImagePart, ProgramReport},
};
use embedded_storage::nor_flash::NorFlash;

/// The part of a board that receives another program.
pub trait ProgramUpdate {
    /// Reports the program that runs.
    fn report(&self) -> ProgramReport;

    /// Begins to receive an image; what was being received is dropped.
    ///
    /// # Errors
    /// The reason of the refusal, which drops nothing: `Busy` while the program that runs is on trial.
    fn begin(&mut self, image: &Image) -> Result<(), CommandRefusal>;

    /// Erases one page, if one is left to erase.
    fn erase_next(&mut self);

    /// Takes the next bytes.
    ///
    /// # Errors
    /// The reason of the refusal; nothing was written.
    fn part(&mut self, part: &ImagePart<'_>) -> Result<(), CommandRefusal>;

    /// Compares the image with its digest and marks it, to be tried at the next start.
    ///
    /// # Errors
    /// The reason of the refusal.
    fn finish(&mut self) -> Result<(), CommandRefusal>;

    /// Marks the program that runs as well. Returns true if it is marked.
    fn confirm(&mut self) -> bool;
}

/// Receiver of an image into two slots.
pub struct Updater<F> {
    slots: ImageSlots<F>,
    running: Slot,
    receiving: Option<Receiving>,
    is_erased: bool,
    report: ProgramReport,
}

impl<F: NorFlash> Updater<F> {
    /// Takes the slots, and the slot of the image that runs, as the loader has chosen it. Reads both images.
    pub fn new(mut slots: ImageSlots<F>, running: Slot) -> Self {
        let (number, confirmed) =
            slots.image(running).map_or((0, false), |(image, confirmed)| (image.number, confirmed));
        let other = slots.image(running.other()).map(|(image, _)| image.number);
        let report = ProgramReport { number, confirmed, other, received: None };
        Self { slots, running, receiving: None, is_erased: false, report }
    }
}

impl<F: NorFlash> ProgramUpdate for Updater<F> {
    fn report(&self) -> ProgramReport {
        ProgramReport { received: self.receiving.as_ref().map(Receiving::received), ..self.report }
    }

    fn begin(&mut self, image: &Image) -> Result<(), CommandRefusal> {
        self.receiving = Some(self.slots.begin(self.running, *image).map_err(refusal)?);
        (self.is_erased, self.report.other) = (false, None);
        Ok(())
    }

    fn erase_next(&mut self) {
        if !self.is_erased
            && let Some(receiving) = &mut self.receiving
        {
            match self.slots.erase_next(receiving) {
                Ok(done) => self.is_erased = done,
                Err(_) => self.receiving = None,
            }
        }
    }

    fn part(&mut self, part: &ImagePart<'_>) -> Result<(), CommandRefusal> {
        let receiving = self.receiving.as_mut().ok_or(CommandRefusal::NothingThere)?;
        if !self.is_erased {
            return Err(CommandRefusal::Busy);
        }
        self.slots.write(receiving, part.offset, part.bytes).map_err(|error| match error {
            // The flash does not hold what was written; the image itself is compared at its end.
            StorageError::NotVerified => CommandRefusal::StorageFailed,
            error => refusal(error),
        })
    }

    fn finish(&mut self) -> Result<(), CommandRefusal> {
        let receiving = self.receiving.take().ok_or(CommandRefusal::NothingThere)?;
        let number = receiving.number();
        self.slots.finish(receiving).map_err(refusal)?;
        self.report.other = Some(number);
        Ok(())
    }

    fn confirm(&mut self) -> bool {
        self.report.confirmed |= self.slots.confirm(self.running).is_ok();
        self.report.confirmed
    }
}

fn refusal<E>(error: StorageError<E>) -> CommandRefusal {
    match error {
        StorageError::CounterGoesBack { stored } => {
            CommandRefusal::ImageNotNewer { stored: u32::try_from(stored).unwrap_or(u32::MAX) }
        }
        StorageError::Full => CommandRefusal::ImageSize,
        StorageError::Busy => CommandRefusal::Busy,
        StorageError::NotTheNext { expected } => CommandRefusal::NotTheNext { expected },
        StorageError::NotVerified => CommandRefusal::NotTheImage,
        _ => CommandRefusal::StorageFailed,
    }
}
