//! A NOR flash in memory: programs words (only from 1 to 0), erases whole sectors, counts both, and loses
//! power on request. A bit can be marginal, and a torn word unreadable, as with chips that correct errors.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::collections::BTreeSet;

/// State of the word or sector that is being changed when power goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// The change had not begun.
    Before,
    /// The change was under way: some bits of a word are programmed; each bit of a sector is as before,
    /// erased or random.
    Torn,
    /// The change was done, but not reported.
    After,
}

/// All kinds of cut.
pub const CUTS: [Cut; 3] = [Cut::Before, Cut::Torn, Cut::After];

/// Reasons why the flash refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MockError {
    /// The power is off.
    PowerCut,
    /// A word would be programmed twice, or erasing is not allowed: a defect of the caller.
    Forbidden,
    /// The error correction gave up on a word.
    Uncorrectable,
    /// The arguments are wrong.
    Arguments(NorFlashErrorKind),
}

impl NorFlashError for MockError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The flash; it programs `WORD` bytes at a time and erases `SECTOR` bytes.
#[derive(Clone, Debug)]
pub struct MockFlash<const WORD: usize = 4, const SECTOR: usize = 16384> {
    bytes: Vec<u8>,
    /// Words programmed and sectors erased so far.
    operations: u64,
    cut: Option<(u64, Cut)>,
    is_on: bool,
    may_erase: bool,
    stuck: Option<usize>,
    erases: Vec<u32>,
    words: Vec<u64>,
    /// Where the last word or sector begins that was touched.
    last_touched: usize,
    /// A byte and the bit of it that reads as it likes, each time anew.
    marginal: Option<(usize, u8)>,
    /// True if a torn word cannot be read.
    corrects_errors: bool,
    unreadable: BTreeSet<usize>,
    rng: Xoshiro128PlusPlus,
    /// Generator of what a marginal bit reads as.
    chance: Xoshiro128PlusPlus,
}

impl<const WORD: usize, const SECTOR: usize> MockFlash<WORD, SECTOR> {
    /// An erased flash of this many sectors. `seed` decides what torn changes leave.
    #[must_use]
    pub fn new(sectors: usize, seed: u64) -> Self {
        Self {
            bytes: vec![0xFF; sectors * SECTOR],
            operations: 0,
            cut: None,
            is_on: true,
            may_erase: true,
            stuck: None,
            erases: vec![0; sectors],
            words: vec![0; sectors],
            last_touched: 0,
            marginal: None,
            corrects_errors: false,
            unreadable: BTreeSet::new(),
            rng: Xoshiro128PlusPlus::seed_from_u64(seed),
            chance: Xoshiro128PlusPlus::seed_from_u64(!seed),
        }
    }

    /// Cuts the power after `operations` more words or erasures.
    pub fn cut_in(&mut self, operations: u64, cut: Cut) {
        self.cut = Some((self.operations + operations, cut));
    }

    /// Restores the power.
    pub fn power_up(&mut self) {
        (self.is_on, self.cut) = (true, None);
    }

    /// Returns true if the power is on.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.is_on
    }

    /// Allows or forbids erasing, which is forbidden while drilling.
    pub const fn allow_erase(&mut self, allowed: bool) {
        self.may_erase = allowed;
    }

    /// Makes one bit of a sector fail to erase.
    pub const fn wear_out(&mut self, sector: usize) {
        self.stuck = Some(sector);
    }

    /// Torn words cannot be read from now on, until their sector is erased.
    pub const fn correct_errors(&mut self) {
        self.corrects_errors = true;
    }

    /// Returns true if it is a flash that corrects errors.
    #[must_use]
    pub const fn corrects(&self) -> bool {
        self.corrects_errors
    }

    /// The word at this byte cannot be read from now on, until its sector is erased.
    pub fn make_unreadable(&mut self, at: usize) {
        self.unreadable.insert(at / WORD);
    }

    /// Returns true if the word at this byte can be read.
    #[must_use]
    pub fn is_readable(&self, at: usize) -> bool {
        !self.unreadable.contains(&(at / WORD))
    }

    /// Where the last word or sector begins that was touched.
    #[must_use]
    pub const fn last_touched(&self) -> usize {
        self.last_touched
    }

    /// From now on a bit of this byte reads as 0 or as 1 by chance, until its sector is erased.
    pub const fn make_marginal(&mut self, at: usize, bit: u8) {
        self.marginal = Some((at, 1 << bit));
    }

    /// Words programmed and sectors erased so far.
    #[must_use]
    pub const fn operations(&self) -> u64 {
        self.operations
    }

    /// Number of erasures of each sector.
    #[must_use]
    pub fn erases(&self) -> &[u32] {
        &self.erases
    }

    /// Number of words programmed in each sector.
    #[must_use]
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Puts words there, whole and readable, whatever was there: a change that a cut interrupted, brought to its end.
    pub fn put(&mut self, at: usize, words: &[u8]) {
        self.bytes[at..at + words.len()].copy_from_slice(words);
        self.unreadable.retain(|word| !(at..at + words.len()).contains(&(word * WORD)));
    }

    /// Content, for a test to read or spoil.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Counts an operation; returns the cut if power goes during it.
    fn begin(&mut self) -> Result<Option<Cut>, MockError> {
        if !self.is_on {
            return Err(MockError::PowerCut);
        }
        let cut = self.cut.filter(|(at, _)| *at == self.operations).map(|(_, cut)| cut);
        self.operations += 1;
        self.is_on = cut.is_none();
        Ok(cut)
    }
}

impl<const WORD: usize, const SECTOR: usize> ErrorType for MockFlash<WORD, SECTOR> {
    type Error = MockError;
}

impl<const WORD: usize, const SECTOR: usize> ReadNorFlash for MockFlash<WORD, SECTOR> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        if !self.is_on {
            return Err(MockError::PowerCut);
        }
        check_read(self, offset, bytes.len()).map_err(MockError::Arguments)?;
        let read = offset as usize..offset as usize + bytes.len();
        if self.unreadable.range(read.start / WORD..read.end.div_ceil(WORD)).next().is_some() {
            return Err(MockError::Uncorrectable);
        }
        bytes.copy_from_slice(&self.bytes[read.clone()]);
        if let Some((at, bit)) = self.marginal.filter(|(at, _)| read.contains(at))
            && self.chance.next_u32().is_multiple_of(2)
        {
            bytes[at - read.start] ^= bit;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const SECTOR: usize> NorFlash for MockFlash<WORD, SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        check_erase(self, from, to).map_err(MockError::Arguments)?;
        if !self.may_erase {
            return Err(MockError::Forbidden);
        }
        for sector in from as usize / SECTOR..to as usize / SECTOR {
            let cut = self.begin()?;
            self.erases[sector] += u32::from(cut != Some(Cut::Before));
            self.last_touched = sector * SECTOR;
            if cut != Some(Cut::Before) {
                self.marginal = self.marginal.filter(|(at, _)| at / SECTOR != sector);
                self.unreadable.retain(|word| word * WORD / SECTOR != sector);
            }
            let kind = self.rng.next_u32() % 4;
            for byte in &mut self.bytes[sector * SECTOR..][..SECTOR] {
                let noise = self.rng.next_u32();
                match (cut, kind) {
                    (Some(Cut::Before), _) => {}
                    // Torn erasure: some cells erased; all apparently erased; random; or all but a few
                    // erased.
                    (Some(Cut::Torn), 0) => *byte |= noise as u8,
                    (Some(Cut::Torn), 1) => *byte = noise as u8,
                    (Some(Cut::Torn), 2) if noise.is_multiple_of(1024) => {}
                    _ => *byte = 0xFF,
                }
            }
            if self.corrects_errors && cut == Some(Cut::Torn) && kind < 2 {
                self.unreadable.extend(sector * SECTOR / WORD..(sector + 1) * SECTOR / WORD);
            }
            if self.stuck == Some(sector) {
                self.bytes[sector * SECTOR + SECTOR / 2] &= 0x7F;
            }
            if cut.is_some() {
                return Err(MockError::PowerCut);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MockError> {
        check_write(self, offset, bytes.len()).map_err(MockError::Arguments)?;
        for (k, word) in bytes.chunks(WORD).enumerate() {
            let at = offset as usize + k * WORD;
            let cut = self.begin()?;
            let held = &mut self.bytes[at..at + WORD];
            if held.iter().any(|byte| *byte != 0xFF) {
                return Err(MockError::Forbidden);
            }
            self.words[at / SECTOR] += 1;
            self.last_touched = at;
            for (held, new) in held.iter_mut().zip(word) {
                *held &= match cut {
                    Some(Cut::Before) => 0xFF,
                    Some(Cut::Torn) => *new | self.rng.next_u32() as u8,
                    Some(Cut::After) | None => *new,
                };
            }
            if self.corrects_errors && cut == Some(Cut::Torn) {
                self.unreadable.insert(at / WORD);
            }
            if cut.is_some() {
                return Err(MockError::PowerCut);
            }
        }
        Ok(())
    }
}
