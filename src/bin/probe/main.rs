//! The firmware. On a host this is an empty program, so that `cargo test --all-features` works there.
#![cfg_attr(target_os = "none", no_std, no_main)]

// One board, one module; what boards share stands beside them.
#[cfg(all(target_os = "none", feature = "board-bare"))]
mod bare;
#[cfg(all(target_os = "none", feature = "board-emulated"))]
mod emulated;
#[cfg(all(target_os = "none", feature = "board-nrf52840"))]
mod nrf52840;
#[cfg(all(target_os = "none", feature = "board-stm32f405"))]
mod stm32f405;
#[cfg(all(target_os = "none", feature = "board-trace"))]
mod trace_flight;

#[cfg(all(target_os = "none", feature = "console"))]
mod console;
#[cfg(all(target_os = "none", feature = "application"))]
mod reset_record;
#[cfg(all(target_os = "none", feature = "application"))]
mod sample_clock;
#[cfg(all(target_os = "none", feature = "spi-sensors"))]
mod fault;
#[cfg(all(target_os = "none", feature = "spi-sensors"))]
mod sensor_board;
#[cfg(all(target_os = "none", feature = "spi-sensors"))]
mod serial_queues;
#[cfg(all(target_os = "none", not(feature = "board-bare")))]
mod stack;

#[cfg(all(
    target_os = "none",
    not(any(
        feature = "board-bare",
        feature = "board-emulated",
        feature = "board-nrf52840",
        feature = "board-stm32f405",
        feature = "board-trace"
    ))
))]
compile_error!("choose a board: --features board-stm32f405, board-nrf52840, board-emulated, board-trace or board-bare");

#[cfg(not(target_os = "none"))]
fn main() {}
