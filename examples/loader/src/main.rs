//! Loader of the emulated MPS2: it chooses one of the two images in an external NOR flash, copies it to where the
//! program is linked, starts the watchdog and jumps. An image that is tried and does not confirm itself is not started
//! again while there is one that did (`meerkat_mwd::storage::ImageSlots`).
//!
//! Another chip's loader differs in the flash's driver, the three addresses, the copy and the watchdog.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {}
