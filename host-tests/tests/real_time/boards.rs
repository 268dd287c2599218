//! The image of every board: where its chip starts, and within its chip's memory.

use crate::rig::emulator::toolchain;
use mwd::target::{
    firmware::{Board, Firmware, build_firmware},
    image::{self, Image},
};

#[test]
fn every_board_starts_where_its_chip_does_and_fits_it() {
    let Some(toolchain) = toolchain() else { return };
    for board in [Board::Emulated, Board::Updatable, Board::Trace, Board::Stm32f405, Board::Nrf52840] {
        let Firmware { elf, size } = build_firmware(&toolchain, board).unwrap();
        let chip = board.chip(&toolchain);
        let table = Image::parse(&elf).unwrap().vector_table().unwrap();
        println!("{board:?}: vector table at {:#010x}, {size}", table.address);
        assert_eq!(table.address, chip.flash_start, "{board:?}");
        assert_eq!(u64::from(table.stack_pointer), chip.stack_top, "{board:?}");
        let code = chip.flash_start..chip.flash_start + size.flash_bytes;
        assert!(code.contains(&u64::from(table.reset)) && table.reset % 2 == 1, "{board:?}: {table:x?}");
        assert!(size.flash_bytes <= chip.flash_bytes && size.ram_bytes() <= chip.ram_bytes, "{board:?}: {size}");
        assert!(chip.stack_bytes_beside(&size) > image::STACK_LIMIT_BYTES, "{board:?}: {size}");
        let drivers = match board {
            // Code of the emulated board with a loader includes the sensors' models.
            Board::Stm32f405 | Board::Nrf52840 | Board::Updatable => image::DRIVERS_LIMIT_BYTES,
            _ => 0,
        };
        assert!(size.flash_bytes <= image::FLASH_LIMIT_BYTES + drivers, "{board:?}: {size}");
    }
}

/// Nothing in the firmware writes a float as text or, but for the searches that are compared on the trace board,
/// computes in emulated f64, as libm's sine does: that takes 15 and 10 KiB.
#[test]
fn no_board_formats_a_float_or_multiplies_in_f64() {
    let Some(toolchain) = toolchain() else { return };
    for board in [Board::Emulated, Board::Trace, Board::Stm32f405, Board::Nrf52840] {
        let Firmware { elf, .. } = build_firmware(&toolchain, board).unwrap();
        let image = Image::parse(&elf).unwrap();
        assert!(image.has_function("push"), "{board:?}: the names are not in the image");
        for part in ["flt2dec", "float_to_decimal", "float_to_general"] {
            assert!(!image.has_function(part), "{board:?} formats a float: {part}");
        }
        if matches!(board, Board::Emulated) {
            assert!(!image.has_function("__aeabi_dmul"), "{board:?} multiplies in emulated f64");
        }
    }
}
