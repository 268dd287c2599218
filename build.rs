//! Linker arguments of the firmware, and what it logs. The arguments stand here because a user's RUSTFLAGS would
//! replace those of `.cargo/config.toml`, and the image would link empty.

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=src/bin/probe/nrf52840.x");
    println!("cargo:rerun-if-changed=src/bin/probe/mps2.x");
    println!("cargo:rerun-if-changed=src/bin/probe/ccm");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=DEFMT_LOG");
    if std::env::var_os("DEFMT_LOG").is_none() {
        // Without a word defmt logs errors alone.
        println!("cargo:rustc-env=DEFMT_LOG=info");
    }
    let feature = |name: &str| std::env::var_os(format!("CARGO_FEATURE_{name}")).is_some();
    let bare_metal = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !bare_metal || !feature("FIRMWARE") {
        return;
    }
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    // The linker finds `memory.x` beside the workspace before any that a search path has, and cortex-m-rt's script asks
    // for that name. A board with other addresses therefore has a whole script of its own.
    if feature("BOARD_NRF52840") {
        println!("cargo:rustc-link-search={here}/src/bin/probe");
        println!("cargo:rustc-link-arg-bins=-Tnrf52840.x");
    } else if feature("BOARD_UPDATABLE") {
        println!("cargo:rustc-link-search={here}/src/bin/probe");
        println!("cargo:rustc-link-arg-bins=-Tmps2.x");
    } else {
        println!("cargo:rustc-link-search={here}");
        let emulated = feature("BOARD_EMULATED") || feature("BOARD_TRACE");
        if emulated {
            // No other board is built anew because of it.
            println!("cargo:rerun-if-env-changed=MWD_CCM_BEHIND_SRAM");
        }
        let behind = emulated && std::env::var_os("MWD_CCM_BEHIND_SRAM").is_some();
        let ccm = if behind { "behind_the_sram" } else { "beside_the_core" };
        println!("cargo:rustc-link-search={here}/src/bin/probe/ccm/{ccm}");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    if feature("DEFMT") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    println!("cargo:rustc-link-arg-bins=--nmagic");
    // Functions that came out the same are linked once: nothing here compares addresses of code.
    println!("cargo:rustc-link-arg-bins=--icf=all");
}
