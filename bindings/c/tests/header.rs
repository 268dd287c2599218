//! The header that is committed is the one that cbindgen makes; its sizes fit.
#![allow(clippy::unwrap_used, missing_docs)]

use meerkat_mwd::{Config, config::OptimizerKind};
use meerkat_mwd_c::{
    MWD_ATTITUDE_FILTER_SIZE, MWD_MOUNTING_CHECK_SIZE, MWD_PROBE_SIZE, MWD_SURVEYOR_SIZE, MwdAttitudeFilter,
    MwdMountingCheck, MwdProbe, MwdSurveyor,
};
use serde_json::{Value, json};
use std::{env, fs, path::Path};

fn generated() -> String {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in [
        "status", "sizes", "config", "choices", "sample", "output", "window", "probe", "effects", "magnet", "survey",
        "mounting", "attitude", "frames",
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

/// Places of all numbers, names and absences in a configuration.
fn places(value: &Value, at: &str, into: &mut Vec<String>) {
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| places(value, &format!("{at}/{name}"), into)),
        Value::Array(items) => (0..).zip(items).for_each(|(k, item)| places(item, &format!("{at}/{k}"), into)),
        _ => into.push(at.to_owned()),
    }
}

/// Text that may stand in the place of a value.
fn others(value: &Value) -> Vec<Value> {
    match value {
        Value::Bool(on) => vec![json!(!on)],
        Value::Number(x) if x.is_f64() => {
            let x = x.as_f64().unwrap();
            vec![json!(x * 1.015625), json!(x * 0.984375), json!(x + 0.0625)]
        }
        Value::Number(x) => vec![json!(x.as_u64().unwrap() + 1), json!(x.as_u64().unwrap() - 1)],
        Value::Null => vec![json!(0.015625), json!(0.25), json!(30.0)],
        _ => vec![],
    }
}

/// Names that a configuration with a wrong one says it could have.
fn other_names(mut config: Value, place: &str) -> Vec<Value> {
    *config.pointer_mut(place).unwrap() = json!("?");
    let said = serde_json::from_value::<Config>(config).unwrap_err().to_string();
    let (_, expected) = said.split_once("expected").unwrap();
    expected.split('`').skip(1).step_by(2).map(|name| json!(name)).collect()
}

/// One field after the other takes a value that no default has.
#[test]
fn the_flat_configuration_holds_every_field() {
    let through = |config: &Config| meerkat_mwd_c::MwdConfig::from(config).checked_config();
    assert_eq!(through(&Config::default()), Some(Config::default()));
    let default = serde_json::to_value(Config::default()).unwrap();
    let mut all = Vec::new();
    places(&default, "", &mut all);
    for place in &all {
        let value = default.pointer(place).unwrap();
        let others = if value.is_string() { other_names(default.clone(), place) } else { others(value) };
        let configs = others.into_iter().filter_map(|other| {
            let mut changed = default.clone();
            *changed.pointer_mut(place).unwrap() = other;
            serde_json::from_value::<Config>(changed).ok()
        });
        // The baselines of searches are not for C.
        let is_for_c = |it: &Config| {
            let search = it.identification.optimizer;
            it.validate().is_ok() && matches!(search, OptimizerKind::Imoa | OptimizerKind::Lm | OptimizerKind::Ls)
        };
        let usable: Vec<_> = configs.filter(|it| *it != Config::default() && is_for_c(it)).collect();
        assert!(!usable.is_empty(), "{place}: no other value can be used");
        usable.iter().for_each(|config| assert_eq!(through(config), Some(*config), "{place}"));
    }
    assert!(all.len() > 80, "{}", all.len());
}
