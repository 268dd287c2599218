//! Two images of the program in flash, for an update in the field: the new one is received beside the one that runs, is
//! started once on trial, and stays only if it confirms that it runs well.
//!
//! A slot is half of the region. Its last 512 bytes hold marks, each a record of its own that is written once: what the
//! image is (number, length, digest), that it was started on trial, that it was confirmed. An image counts when its
//! mark is whole and its bytes have the digest, BLAKE2s-256 (RFC 7693); the mark is written last and erased first, so
//! that no loss of power leaves a mark beside bytes that it does not describe.
//!
//! | who | calls |
//! |---|---|
//! | program, at rest | [`ImageSlots::begin`], [`ImageSlots::erase_next`] until it is done |
//! | program, then | [`ImageSlots::write`], [`ImageSlots::finish`] |
//! | loader, at every start | [`ImageSlots::choose`], and jumps |
//! | new program, when it has run well for a while | [`ImageSlots::confirm`] |
//!
//! The caller decides who may update: the digest has to come from a sender that has the key.

use super::{
    StorageError,
    granules::{is_blank, program, read_record},
    little_endian::Reader,
    record::{GRANULE, Kind, MAX_RECORD, encode},
};
use blake2::{Blake2s256, Digest};
use embedded_storage::nor_flash::NorFlash;

/// Bytes of a digest.
pub const DIGEST_BYTES: usize = 32;
/// Granules of a slot's end that hold marks.
const MARK_GRANULES: u32 = 16;
/// Granule of the image's own mark; it takes two.
const IMAGE: u32 = 0;
/// Granules of the trial's mark and of the confirmation's: one each, and room for three that were cut off.
const TRIAL: core::ops::Range<u32> = 2..6;
const CONFIRMED: core::ops::Range<u32> = 6..10;

/// One of the two places for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Slot {
    /// First half of the region.
    First,
    /// Second half.
    Second,
}

impl Slot {
    /// Both slots.
    pub const BOTH: [Self; 2] = [Self::First, Self::Second];

    /// The other slot.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// Identity of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct Image {
    /// Number that rises from image to image: one that is not above the stored ones is refused.
    pub number: u32,
    /// Length, bytes.
    pub length: u32,
    /// BLAKE2s-256 of the image's bytes.
    pub digest: [u8; DIGEST_BYTES],
}

/// Image to be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Start {
    /// Slot of an image that has run well.
    Confirmed(Slot),
    /// Slot of an image that is started for the first time: unless confirmed, the next start takes the other slot.
    Trial(Slot),
    /// Slot of an image that was never confirmed; no confirmed one is there.
    LastResort(Slot),
}

impl Start {
    /// Slot of the image to be started.
    #[must_use]
    pub const fn slot(self) -> Slot {
        match self {
            Self::Confirmed(slot) | Self::Trial(slot) | Self::LastResort(slot) => slot,
        }
    }
}

/// Image being received into a slot. After a loss of power the sender begins anew.
#[derive(Debug)]
pub struct Receiving {
    slot: Slot,
    image: Image,
    /// Bytes of the slot that are not erased yet, from its beginning on.
    unerased: u32,
    received: u32,
}

impl Receiving {
    /// Offset of the next bytes.
    #[must_use]
    pub const fn received(&self) -> u32 {
        self.received
    }

    /// Number of the image.
    #[must_use]
    pub const fn number(&self) -> u32 {
        self.image.number
    }
}

/// Content of a slot.
#[derive(Clone, Copy)]
struct Held {
    slot: Slot,
    image: Image,
    is_tried: bool,
    is_confirmed: bool,
}

/// The two slots. `flash` is their region alone.
pub struct ImageSlots<F> {
    flash: F,
}

impl<F: NorFlash> ImageSlots<F> {
    /// Takes the region; nothing is read or written yet.
    ///
    /// # Errors
    /// The region cannot be halved into whole sectors with room for marks.
    pub fn new(flash: F) -> Result<Self, StorageError<F::Error>> {
        let half = flash.capacity() / 2;
        let fits = F::ERASE_SIZE.is_multiple_of(GRANULE) && half.is_multiple_of(F::ERASE_SIZE) && half <= 1 << 30;
        if !fits || half <= (MARK_GRANULES as usize) * GRANULE {
            return Err(StorageError::Geometry("of two halves of whole pages, each longer than 512 bytes"));
        }
        if !GRANULE.is_multiple_of(F::WRITE_SIZE) || !GRANULE.is_multiple_of(F::READ_SIZE) {
            return Err(StorageError::Geometry("of words of 1, 2, 4, 8, 16 or 32 bytes"));
        }
        Ok(Self { flash })
    }

    /// Address of a slot's first byte in the region.
    #[must_use]
    pub fn address(&self, slot: Slot) -> u32 {
        match slot {
            Slot::First => 0,
            Slot::Second => self.slot_bytes(),
        }
    }

    /// Longest image, bytes.
    #[must_use]
    pub fn longest(&self) -> u32 {
        self.slot_bytes() - MARK_GRANULES * GRANULE as u32
    }

    /// Returns the whole image of a slot, and true if it is confirmed. Every byte of it is read.
    pub fn image(&mut self, slot: Slot) -> Option<(Image, bool)> {
        self.held(slot).map(|held| (held.image, held.is_confirmed))
    }

    /// Decides which image is started. An untried image is marked as tried before it is returned, and is not tried if
    /// the mark cannot be written. `None`: there is no whole image.
    #[inline(never)]
    pub fn choose(&mut self) -> Option<Start> {
        let held = Slot::BOTH.map(|slot| self.held(slot));
        let newest = |of: fn(&Held) -> bool| held.iter().flatten().filter(|it| of(it)).max_by_key(|it| it.image.number);
        let confirmed = newest(|it| it.is_confirmed);
        let is_newer = |it: &&Held| confirmed.is_none_or(|confirmed| it.image.number > confirmed.image.number);
        if let Some(new) = newest(|it| !it.is_confirmed && !it.is_tried).filter(is_newer)
            && self.mark(new.slot, TRIAL, Kind::TRIAL).is_ok()
        {
            return Some(Start::Trial(new.slot));
        }
        if let Some(confirmed) = confirmed {
            return Some(Start::Confirmed(confirmed.slot));
        }
        newest(|_| true).map(|it| Start::LastResort(it.slot))
    }

    /// Marks the running image as confirmed. Does nothing if it is marked already. The loader compared its bytes with
    /// their digest before it ran; comparing them again takes too long while samples come.
    ///
    /// # Errors
    /// The slot holds no image, or the flash failed: then the call can be repeated, three times.
    pub fn confirm(&mut self, running: Slot) -> Result<(), StorageError<F::Error>> {
        let held = self.described(running).ok_or(StorageError::NotVerified)?;
        if held.is_confirmed { Ok(()) } else { self.mark(running, CONFIRMED, Kind::CONFIRMED) }
    }

    /// Begins to receive an image into the slot that does not run. Nothing is erased or written yet.
    ///
    /// # Errors
    /// The image is empty or too long, or its number is not above those of the images that are there; or the running
    /// image is on trial and the other slot holds the confirmed one, which stays until the trial is over (`Busy`).
    pub fn begin(&mut self, running: Slot, image: Image) -> Result<Receiving, StorageError<F::Error>> {
        if image.length == 0 || image.length > self.longest() {
            return Err(StorageError::Full);
        }
        let held = Slot::BOTH.map(|slot| self.held(slot));
        if let Some(stored) = held.iter().flatten().map(|it| it.image.number).filter(|it| *it >= image.number).max() {
            return Err(StorageError::CounterGoesBack { stored: stored.into() });
        }
        let (trial, kept) = ((running, false), (running.other(), true));
        let is_held = |slot| held.iter().flatten().any(|it| (it.slot, it.is_confirmed) == slot);
        if is_held(trial) && is_held(kept) {
            return Err(StorageError::Busy);
        }
        Ok(Receiving { slot: running.other(), image, unerased: self.slot_bytes(), received: 0 })
    }

    /// Erases the next page of the slot, the one with the marks first; at rest only, with a watchdog fed between.
    /// Returns true when nothing is left to erase.
    ///
    /// # Errors
    /// The flash failed.
    pub fn erase_next(&mut self, receiving: &mut Receiving) -> Result<bool, StorageError<F::Error>> {
        let page = F::ERASE_SIZE as u32;
        if receiving.unerased >= page {
            let to = self.address(receiving.slot) + receiving.unerased;
            self.flash.erase(to - page, to).map_err(StorageError::Flash)?;
            receiving.unerased -= page;
        }
        Ok(receiving.unerased == 0)
    }

    /// Writes the next bytes of the image and reads them back. All but the last are multiples of 32 bytes.
    ///
    /// # Errors
    /// The bytes are none, not the next ones, or too many; the slot is not erased; or the flash failed: the sender
    /// begins anew.
    #[inline(never)]
    pub fn write(
        &mut self,
        receiving: &mut Receiving,
        offset: u32,
        bytes: &[u8],
    ) -> Result<(), StorageError<F::Error>> {
        let Receiving { slot, image, unerased, received } = receiving;
        let end = u64::from(offset) + bytes.len() as u64;
        let is_whole = bytes.len().is_multiple_of(GRANULE) || end == u64::from(image.length);
        if bytes.is_empty() || offset != *received || end > u64::from(image.length) || !is_whole || *unerased > 0 {
            return Err(StorageError::NotTheNext { expected: *received });
        }
        let base = self.address(*slot);
        for chunk in bytes.chunks(GRANULE) {
            let mut granule = [0xFF; GRANULE];
            granule.iter_mut().zip(chunk).for_each(|(to, from)| *to = *from);
            program(&mut self.flash, base + *received, &granule)?;
            *received += chunk.len() as u32;
        }
        Ok(())
    }

    /// Compares the whole image with its digest and marks it: the next start takes it on trial.
    ///
    /// # Errors
    /// Bytes are missing, are not those of the digest, or the flash failed. The image is not marked then.
    pub fn finish(&mut self, receiving: Receiving) -> Result<(), StorageError<F::Error>> {
        let Receiving { slot, image, received, .. } = receiving;
        if received != image.length {
            return Err(StorageError::NotTheNext { expected: received });
        }
        if !self.has_digest(slot, &image) {
            return Err(StorageError::NotVerified);
        }
        let mut record = [0; 2 * GRANULE];
        let encoded = encode(&mut record, Kind::IMAGE, 1, image.number, |writer| {
            writer.u32(image.length);
            writer.bytes(&image.digest);
        });
        encoded.ok_or(StorageError::Full)?;
        let address = self.mark_address(slot, IMAGE);
        program(&mut self.flash, address, &record)
    }

    /// Returns the region, to be used for anything but reading or writing; its content must not change.
    pub const fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Returns the region.
    pub fn into_flash(self) -> F {
        self.flash
    }

    fn slot_bytes(&self) -> u32 {
        // At most 2^30, as `new` has checked.
        (self.flash.capacity() / 2) as u32
    }

    fn mark_address(&self, slot: Slot, granule: u32) -> u32 {
        self.address(slot) + self.longest() + granule * GRANULE as u32
    }

    /// Returns the image and marks of a slot, if the image is whole.
    fn held(&mut self, slot: Slot) -> Option<Held> {
        let held = self.described(slot)?;
        self.has_digest(slot, &held.image).then_some(held)
    }

    /// Returns the image and marks of a slot, without a look at the image itself.
    #[inline(never)]
    fn described(&mut self, slot: Slot) -> Option<Held> {
        let mut buffer = [0; MAX_RECORD];
        let address = self.mark_address(slot, IMAGE);
        let header = read_record(&mut self.flash, address, &mut buffer)?;
        if (header.kind, header.version) != (Kind::IMAGE, 1) {
            return None;
        }
        let mut reader = Reader(header.payload(&buffer)?);
        let image = Image { number: header.number, length: reader.u32()?, digest: reader.bytes()? };
        if image.length == 0 || image.length > self.longest() {
            return None;
        }
        let is_tried = self.is_marked(slot, TRIAL, Kind::TRIAL);
        let is_confirmed = self.is_marked(slot, CONFIRMED, Kind::CONFIRMED);
        Some(Held { slot, image, is_tried, is_confirmed })
    }

    fn has_digest(&mut self, slot: Slot, image: &Image) -> bool {
        let (mut digest, base) = (Blake2s256::new(), self.address(slot));
        let mut at = 0;
        while at < image.length {
            let mut granule = [0; GRANULE];
            if self.flash.read(base + at, &mut granule).is_err() {
                return false;
            }
            let left = (image.length - at) as usize;
            digest.update(granule.get(..left).unwrap_or(&granule));
            at += GRANULE as u32;
        }
        digest.finalize().as_slice() == image.digest
    }

    fn is_marked(&mut self, slot: Slot, granules: core::ops::Range<u32>, kind: Kind) -> bool {
        let mut buffer = [0; MAX_RECORD];
        granules.into_iter().any(|granule| {
            let address = self.mark_address(slot, granule);
            let header = read_record(&mut self.flash, address, &mut buffer);
            header.is_some_and(|header| header.kind == kind)
        })
    }

    /// Writes a mark into the first granule of its room that is blank.
    fn mark(&mut self, slot: Slot, granules: core::ops::Range<u32>, kind: Kind) -> Result<(), StorageError<F::Error>> {
        let mut record = [0; GRANULE];
        encode(&mut record, kind, 1, 0, |_| {}).ok_or(StorageError::Full)?;
        for granule in granules {
            let address = self.mark_address(slot, granule);
            if is_blank(&mut self.flash, address, 1) {
                return program(&mut self.flash, address, &record);
            }
        }
        Err(StorageError::Full)
    }
}
