//! What is flown: drilling at 45 deg, 200 samples a second.

use meerkat_mwd::{Config, Sample};
use mwd::{
    configuration,
    simulate::{Scenario, simulate},
    toolchain::{self, Toolchain},
};
use std::{io::Write, path::Path};

pub fn drilling(duration_s: f64, seed: u64) -> (Config, Vec<Sample>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/drilling_45deg.toml");
    let scenario = Scenario { duration_s, sample_period_us: 5_000, ..Scenario::read(&path).unwrap() };
    let (trace, _) = simulate(&scenario, seed);
    (configuration::of_trace(&trace), trace.samples)
}

/// The toolchain, or `None` after the reason was printed.
pub fn toolchain() -> Option<Toolchain> {
    match toolchain::prepare() {
        Ok(toolchain) => Some(toolchain),
        Err(missing) if std::env::var_os("MWD_REQUIRE_EMULATOR").is_some_and(|v| v == "1") => panic!("{missing}"),
        Err(missing) => {
            // The runner keeps what the macros print to itself.
            std::io::stderr().write_all(format!("SKIPPED: {missing}\n").as_bytes()).unwrap();
            None
        }
    }
}
