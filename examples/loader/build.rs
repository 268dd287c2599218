//! The image has a linker script of its own: `memory.x` at the root of the workspace is another chip's.

fn main() {
    println!("cargo:rerun-if-changed=loader.x");
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-search={}", std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
        println!("cargo:rustc-link-arg-bins=-Tloader.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
}
