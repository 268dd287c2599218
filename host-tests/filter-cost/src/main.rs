//! The attitude filter and those of `uf-ahrs` on the same samples on the emulated Cortex-M4F: one line for
//! each filter and rate, `name,rate_hz,mean,worst,stack`, in instructions a sample and bytes. On a host this
//! is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;
#[cfg(target_os = "none")]
mod stack;

#[cfg(not(target_os = "none"))]
fn main() {}
