//! Linker arguments of the image, with the memory of the firmware's chip.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=../../memory.x");
    println!("cargo:rerun-if-env-changed=MWD_CCM_BEHIND_SRAM");
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-search={}/../..", env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
        if env::var_os("MWD_CCM_BEHIND_SRAM").is_some() {
            // Must come before the linker script, which asks whether it is defined.
            println!("cargo:rustc-link-arg-bins=--defsym=_ccm_behind_sram=1");
        }
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
}
