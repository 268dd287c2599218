//! The attitude tier on a Vorago VA41630 (Cortex-M4F, 64 KiB of RAM, 256 KiB of code, made for high temperature): an
//! ISM330DHCX on SPI0 (PB15, PC0, PC1, select PB14) and an RM3100 on SPI1 (PC9 to PC11, select PC8), a clock of 40 MHz
//! on XTAL_N. It is compiled and held to its memory; nobody has run it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {}
