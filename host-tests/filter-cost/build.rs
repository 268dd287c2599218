//! Linker arguments of the image, with the memory of the firmware's chip.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=../../memory.x");
    println!("cargo:rerun-if-changed=../../src/bin/probe/ccm");
    println!("cargo:rerun-if-env-changed=MWD_CCM_BEHIND_SRAM");
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        let root = format!("{}/../..", env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
        let behind = env::var_os("MWD_CCM_BEHIND_SRAM").is_some();
        let ccm = if behind { "behind_the_sram" } else { "beside_the_core" };
        println!("cargo:rustc-link-search={root}");
        println!("cargo:rustc-link-search={root}/src/bin/probe/ccm/{ccm}");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
}
