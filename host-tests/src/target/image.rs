//! Memory of the chip that a firmware needs, read from its ELF file.

use object::{
    Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, SymbolKind, elf, read::elf::ProgramHeader,
};
use std::{collections::BTreeSet, fmt};

/// Start of the STM32F405's flash (data sheet DS8626, memory map).
pub const FLASH_START: u64 = 0x0800_0000;
/// Start of its RAM.
pub const RAM_START: u64 = 0x2000_0000;
/// Start of its CCM, which holds the stack and, below it, statics that nothing initialises.
const CCM_START: u64 = 0x1000_0000;
/// Part of the CCM for those statics, bytes, as in `memory.x`.
const BELOW_THE_STACK_BYTES: u64 = 12 * 1024;
/// Size of the CCM, bytes.
const CCM_BYTES: u64 = 64 * 1024;
/// Limit of the firmware's stack, bytes.
pub const STACK_LIMIT_BYTES: u64 = 12 * 1024;
/// Limit of the time from a sample's acquisition to its attitude, microseconds.
pub const DELAY_LIMIT_US: u64 = 2_000;
/// Limit of static data, bytes: the STM32F405's contiguous SRAM.
pub const RAM_LIMIT_BYTES: u64 = 128 * 1024;
/// Limit of flash, bytes: half of the STM32F405's.
pub const FLASH_LIMIT_BYTES: u64 = 514 * 1024;
/// Limit of further flash for sensor drivers and hardware library of a real board, bytes.
pub const DRIVERS_LIMIT_BYTES: u64 = 24 * 1024;

/// Memory of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChipMemory {
    /// Start of its flash, and of the vector table.
    pub flash_start: u64,
    /// Flash for an image, bytes; the rest is kept for stored models.
    pub flash_bytes: u64,
    /// RAM for static data, bytes, from [`RAM_START`] on.
    pub ram_bytes: u64,
    /// Stack pointer after reset: one past the stack's memory.
    pub stack_top: u64,
    /// Memory of the stack alone, bytes; `None` if it shares the RAM with static data.
    pub stack_bytes: Option<u64>,
}

impl ChipMemory {
    /// Memory that an image leaves for its stack, bytes.
    #[must_use]
    pub fn stack_bytes_beside(&self, size: &ImageSize) -> u64 {
        self.stack_bytes.unwrap_or(self.ram_bytes.saturating_sub(size.ram_bytes()))
    }
}

/// STM32F405xG (data sheet DS8626).
pub const STM32F405: ChipMemory = ChipMemory {
    flash_start: FLASH_START,
    flash_bytes: 1024 * 1024,
    ram_bytes: 128 * 1024,
    stack_top: CCM_START + CCM_BYTES,
    stack_bytes: Some(CCM_BYTES - BELOW_THE_STACK_BYTES),
};

/// STM32F405 as QEMU before 8.0 emulates it.
pub const STM32F405_CCM_BEHIND_SRAM: ChipMemory =
    ChipMemory { stack_top: RAM_START + STM32F405.ram_bytes + CCM_BYTES, ..STM32F405 };

/// MPS2 with the image AN386, as `src/bin/probe/mps2.x` divides its memory.
pub const MPS2: ChipMemory = ChipMemory {
    flash_start: 0x1_0000,
    flash_bytes: 1024 * 1024 - 512,
    ram_bytes: 192 * 1024,
    stack_top: RAM_START + 256 * 1024,
    stack_bytes: Some(CCM_BYTES - BELOW_THE_STACK_BYTES),
};

/// nRF52840 (product specification v1.7).
pub const NRF52840: ChipMemory = ChipMemory {
    flash_start: 0,
    flash_bytes: 960 * 1024,
    ram_bytes: 256 * 1024,
    stack_top: RAM_START + 256 * 1024,
    stack_bytes: None,
};

/// Size of an image in the chip's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Initialised static data, bytes; its initial values take flash too.
    pub data_bytes: u64,
    /// Zeroed or uninitialised static data, bytes.
    pub bss_bytes: u64,
    /// Flash: vector table, code, constants and the initial values of the data, bytes.
    pub flash_bytes: u64,
    /// Code of register models of the sensors, bytes: it replaces hardware and is not counted as firmware.
    pub models_bytes: u64,
}

/// Section of the register models, as in the linker script.
const MODELS_SECTION: &str = ".models";

/// Section of uninitialised statics in CCM below the stack; the linker script bounds it.
const BELOW_THE_STACK_SECTION: &str = ".ccm";

impl ImageSize {
    /// Static RAM, bytes, without the stack.
    #[must_use]
    pub const fn ram_bytes(&self) -> u64 {
        self.data_bytes + self.bss_bytes
    }
}

impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kib = |bytes: u64| bytes as f64 / 1024.0;
        write!(
            f,
            "static RAM {:.1} KiB (data {:.1}, bss {:.1}) of {} allowed; flash {:.1} KiB of {} allowed",
            kib(self.ram_bytes()),
            kib(self.data_bytes),
            kib(self.bss_bytes),
            RAM_LIMIT_BYTES / 1024,
            kib(self.flash_bytes),
            FLASH_LIMIT_BYTES / 1024,
        )?;
        match self.models_bytes {
            0 => Ok(()),
            bytes => write!(f, ", and {:.1} of sensor models", kib(bytes)),
        }
    }
}

/// The first two words of the vector table, and its address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VectorTable {
    /// Address of the table.
    pub address: u64,
    /// Stack pointer after reset.
    pub stack_pointer: u32,
    /// Address of the first instruction, with the Thumb bit.
    pub reset: u32,
}

/// Reasons why a file is not an image of the firmware.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file is no 32-bit ELF file.
    #[error("not an ELF image: {0}")]
    NotElf(#[from] object::Error),
    /// Nothing was linked: the linker script was not used.
    #[error("the image has no vector table: it was linked without its script")]
    NoVectorTable,
}

/// A function or static of an image.
pub struct Symbol<'a> {
    /// Mangled name.
    pub name: &'a str,
    /// Size.
    pub bytes: u64,
    /// True if it is in flash, false in RAM.
    pub in_flash: bool,
}

/// A linked firmware.
pub struct Image<'elf> {
    file: object::read::elf::ElfFile32<'elf, object::Endianness>,
}

impl<'elf> Image<'elf> {
    /// Parses an ELF file.
    ///
    /// # Errors
    /// It is not a 32-bit ELF file.
    pub fn parse(elf: &'elf [u8]) -> Result<Self, ImageError> {
        Ok(Self { file: object::read::elf::ElfFile32::parse(elf)? })
    }

    /// Size of the image in the chip's memory.
    #[must_use]
    pub fn size(&self) -> ImageSize {
        let mut size = ImageSize { data_bytes: 0, bss_bytes: 0, flash_bytes: 0, models_bytes: 0 };
        for section in self.file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            if !sh_flags.contains(elf::SHF_ALLOC) {
                continue;
            }
            if section.name() == Ok(BELOW_THE_STACK_SECTION) {
                continue;
            }
            if section.name() == Ok(MODELS_SECTION) {
                size.models_bytes += section.size();
                continue;
            }
            let in_file = section.kind() != SectionKind::UninitializedData;
            match (section.address() >= RAM_START, in_file) {
                (true, true) => {
                    size.data_bytes += section.size();
                    size.flash_bytes += section.size();
                }
                (true, false) => size.bss_bytes += section.size(),
                (false, _) => size.flash_bytes += section.size(),
            }
        }
        size
    }

    /// Returns true if the image holds a function whose mangled name contains `part`. The linker drops what cannot be
    /// reached, and keeps symbols.
    #[must_use]
    pub fn has_function(&self, part: &str) -> bool {
        !self.functions(&[part]).is_empty()
    }

    /// Names of functions, mangled, and of statics, with their sizes in bytes; statics in flash are constants. Of
    /// several names of one thing the first counts.
    pub fn symbols(&self) -> impl Iterator<Item = Symbol<'_>> {
        let mut seen = BTreeSet::new();
        self.file.symbols().filter_map(move |symbol| {
            let in_flash = (FLASH_START..RAM_START).contains(&symbol.address());
            let kind = matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data);
            let name = symbol.name().ok().filter(|_| kind && symbol.size() > 0)?;
            if !seen.insert(symbol.address()) {
                return None;
            }
            Some(Symbol { name, bytes: symbol.size(), in_flash })
        })
    }

    /// Size of the static whose mangled name contains `part`, bytes.
    #[must_use]
    pub fn data_of(&self, part: &str) -> Option<u64> {
        let is_one = |symbol: &object::read::elf::ElfSymbol32<'_, '_>| {
            symbol.kind() == SymbolKind::Data && symbol.name().is_ok_and(|name| name.contains(part))
        };
        self.file.symbols().find(is_one).map(|symbol| symbol.size())
    }

    /// Addresses of functions whose mangled names contain all of `parts`.
    #[must_use]
    pub fn functions(&self, parts: &[&str]) -> Vec<u64> {
        let is_one = |symbol: &object::read::elf::ElfSymbol32<'_, '_>| {
            symbol.kind() == SymbolKind::Text
                && symbol.name().is_ok_and(|name| parts.iter().all(|part| name.contains(part)))
        };
        // The lowest bit marks Thumb code.
        self.file.symbols().filter(is_one).map(|symbol| symbol.address() & !1).collect()
    }

    /// Bytes of the flash as they are when the image stands in it, from its first section to its last.
    ///
    /// # Errors
    /// The file ends before its sections do.
    pub fn loaded(&self) -> Result<Vec<u8>, ImageError> {
        let mut segments = Vec::new();
        for header in self.file.elf_program_headers() {
            let endian = self.file.endian();
            if header.p_type.get(endian) == elf::PT_LOAD && header.p_filesz.get(endian) > 0 {
                let bytes = header.data(endian, self.file.data()).map_err(|()| ImageError::NoVectorTable)?;
                segments.push((header.p_paddr.get(endian) as usize, bytes));
            }
        }
        segments.sort_unstable_by_key(|(address, _)| *address);
        let mut loaded = Vec::new();
        let start = segments.first().map_or(0, |(address, _)| *address);
        for (address, bytes) in segments {
            loaded.resize(address - start, 0xFF);
            loaded.extend_from_slice(bytes);
        }
        Ok(loaded)
    }

    /// Stack pointer, reset address and place of the vector table.
    ///
    /// # Errors
    /// The image has no vector table.
    pub fn vector_table(&self) -> Result<VectorTable, ImageError> {
        let section = self.file.section_by_name(".vector_table").ok_or(ImageError::NoVectorTable)?;
        let words = section.data()?;
        let word = |index: usize| -> Result<u32, ImageError> {
            let bytes = words.get(4 * index..4 * index + 4).ok_or(ImageError::NoVectorTable)?;
            Ok(bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte)))
        };
        Ok(VectorTable { address: section.address(), stack_pointer: word(0)?, reset: word(1)? })
    }
}
