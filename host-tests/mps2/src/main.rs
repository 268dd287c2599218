//! Identification and field of QEMU's `lsm303dlhc_mag` on the machine `mps2-an386`, over I2C by two lines of
//! its SBCon: printed through semihosting. On a host this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod lsm303dlhc;
#[cfg(target_os = "none")]
mod sbcon;

#[cfg(not(target_os = "none"))]
fn main() {}
