//! The header that is committed is the one that cbindgen makes; its sizes fit.
#![allow(clippy::unwrap_used, missing_docs)]

use meerkat_mwd::Config;
use meerkat_mwd_c::{
    MWD_ATTITUDE_FILTER_SIZE, MWD_MOUNTING_CHECK_SIZE, MWD_PROBE_SIZE, MWD_SURVEYOR_SIZE, MwdAttitudeFilter,
    MwdMountingCheck, MwdProbe, MwdSurveyor,
};
use std::{env, fs, path::Path};

fn generated() -> String {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in [
        "status", "sizes", "config", "sample", "output", "window", "probe", "effects", "survey", "mounting",
        "attitude", "frames",
    ] {
        builder = builder.with_src(here.join("src").join(module).with_extension("rs"));
    }
    let mut bytes = Vec::new();
    builder.generate().unwrap().write(&mut bytes);
    String::from_utf8(bytes).unwrap().replace(" * # Safety\n", " * Pointers:\n")
}

/// `MWD_BLESS=1` writes it.
#[test]
fn the_header_is_that_of_the_functions() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/meerkat_mwd.h");
    if env::var_os("MWD_BLESS").is_some() {
        fs::write(&path, generated()).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == generated(), "run: MWD_BLESS=1 cargo test -p meerkat-mwd-c --test header");
}

/// A function without a word about it is one that a C programmer has to guess.
#[test]
fn every_function_of_the_header_is_documented() {
    let header = generated();
    let declarations: Vec<usize> = header.match_indices("\nMwdStatus mwd_").map(|(at, _)| at).collect();
    assert!(declarations.len() >= 18, "{}", declarations.len());
    for at in declarations {
        assert!(header[..at].ends_with("*/"), "{}", header[at..].lines().nth(1).unwrap());
    }
}

/// Here and, at compile time, on the chip the macros are large enough; so little above that no memory is wasted.
#[test]
fn the_sizes_are_hardly_larger_than_the_objects() {
    for (object, macro_) in [
        (size_of::<MwdProbe>(), MWD_PROBE_SIZE),
        (size_of::<MwdSurveyor>(), MWD_SURVEYOR_SIZE),
        (size_of::<MwdAttitudeFilter>(), MWD_ATTITUDE_FILTER_SIZE),
        (size_of::<MwdMountingCheck>(), MWD_MOUNTING_CHECK_SIZE),
    ] {
        println!("{object} of {macro_}");
        assert!(object <= macro_ && macro_ - object < object / 16 + 256, "{object} of {macro_}: change src/sizes.rs");
    }
}

#[test]
fn the_flat_configuration_holds_every_field() {
    // Values that no default has, among them every kind of absence.
    let mut config = Config { seed: 5, effects: false, ..Config::default() };
    config.gyro.p[1][2] = 0.25;
    config.gyro.b_rad_s = [0.5, 0.25, 0.125];
    config.accel.matrix[2][0] = 0.125;
    config.mag.offset = [1.0, 2.0, 3.0];
    config.earth.dip_rad = Some(1.0);
    config.full_scale.mag_ut = Some(400.0);
    config.survey.grid_convergence_rad = Some(0.5);
    config.survey.limits.propagated = true;
    config.identification.max_evaluations = 7;
    for config in [Config::default(), config] {
        let flat = meerkat_mwd_c::MwdConfig::from(&config);
        assert_eq!(flat.checked_config(), Some(config));
    }
}
