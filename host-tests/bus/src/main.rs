//! The sampling path on the emulated STM32F405: `truth.bin` of the emulator's working directory through the register models and the adapters,
//! `samples.bin` out, and what it took on the standard output. On a host this is an empty program.
//!
//! In: postcard's encoding of the parts' periods in microseconds (two `u32`), then of one truth (a `Sample`) after another. Out: `Sample`s.
//! Printed: how many truths, ticks of the sampling path, its most, and how many of them were the wires' and the models'.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {}
