//! Images of the firmware, built for a board.

use super::{error::EmulateError, machine::BUILD};
use crate::target::{
    deadline,
    image::{self, ChipMemory, Image, ImageSize},
    toolchain::{self, Toolchain},
};
use std::fs;

/// A built firmware.
pub struct Firmware {
    /// The ELF file.
    pub elf: Vec<u8>,
    /// Its size in the chip's memory.
    pub size: ImageSize,
}

/// Boards that the firmware is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// The emulated STM32F405 without a clock: a trace in, a flight out.
    Trace,
    /// The emulated STM32F405 in real time.
    Emulated,
    /// The emulated MPS2 in real time, whose loader starts one of two images.
    Updatable,
    /// A real STM32F405.
    Stm32f405,
    /// A real nRF52840.
    Nrf52840,
    /// No board: only the pipeline's calls, to see what they can reach.
    Bare,
}

impl Board {
    /// Memory of the board's chip, or of the machine that emulates it.
    #[must_use]
    pub fn chip(self, toolchain: &Toolchain) -> ChipMemory {
        match self {
            Self::Updatable => image::MPS2,
            Self::Nrf52840 => image::NRF52840,
            Self::Trace | Self::Emulated if toolchain.ccm_is_behind_sram() => image::STM32F405_CCM_BEHIND_SRAM,
            _ => image::STM32F405,
        }
    }
}

/// Builds the firmware for a board, unless it is built already.
///
/// # Errors
/// The build fails, or its result is no image.
pub fn build_firmware(toolchain: &Toolchain, board: Board) -> Result<Firmware, EmulateError> {
    let file = |what| move |source| EmulateError::File { what, source };
    // Boards share one file name: hold the lock until the file is read.
    let _one_at_a_time =
        toolchain::lock("mwd-firmware.lock").map_err(file("the target directory cannot be written"))?;
    let mut cargo = toolchain.cargo_build();
    cargo.args(["-p", "meerkat-mwd", "--bin", "probe", "--features"]);
    cargo.arg(match board {
        Board::Trace => "board-trace",
        Board::Emulated => "board-emulated",
        Board::Updatable => "board-updatable",
        Board::Stm32f405 => "board-stm32f405",
        Board::Nrf52840 => "board-nrf52840",
        Board::Bare => "board-bare",
    });
    deadline::run(&mut cargo, BUILD).map_err(EmulateError::Build)?;
    let elf = fs::read(toolchain.built("probe")).map_err(file("the built firmware cannot be read"))?;
    let image = Image::parse(&elf)?;
    image.vector_table()?;
    let size = image.size();
    Ok(Firmware { elf, size })
}
