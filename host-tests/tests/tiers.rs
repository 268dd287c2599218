//! Three sizes of the pipeline (`examples/tiers`), and a full multi-station analysis, as images for a Cortex-M4F: what
//! each takes, and that it does on the emulated chip what it does here.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "rig/emulator.rs"]
mod emulator;

use meerkat_mwd::{Config, probe::Output};
use meerkat_mwd::{
    Probe, Sample,
    compensation::effects::LIBRARY,
    estimator::Estimator,
    probe::AttitudeProbe,
    survey::{
        Surveyor, Surveys,
        multi_station::{Decision, MAX_STATIONS, MultiStation},
    },
};
use mwd::{
    surveys::simulated_run::Run,
    target::{
        call_costs::count_function,
        deadline,
        image::Image,
        toolchain::{Toolchain, workspace},
    },
};
use std::{fs, path::Path, process::Command, time::Duration};
use testbed::{
    simulate::{Scenario, simulate},
    trace::{Trace, recordings},
};
use tiers::{Attitude, Digest, Full, FullProbe, Identify, Tier, analysed_run, by_hand, digest_of, pack, pack_station};

const BUILD: Duration = Duration::from_secs(600);
const RUN: Duration = Duration::from_secs(300);

/// Limits of an image: static RAM, stack and flash, bytes.
struct Limits {
    tier: &'static str,
    ram: u64,
    stack: u64,
    flash: u64,
}

/// Limits of the tiers' images. RAM is as required where that is reached: of the smallest, and of the largest, 64 KiB
/// with its stack, which the test adds. Every other limit is a little above what is measured, as the table of
/// `docs/new_board.md` has it.
const LIMITS: [Limits; 3] = [
    Limits { tier: "attitude", ram: 8 * 1024, stack: 5_700, flash: 80 * 1024 },
    Limits { tier: "identify", ram: 39 * 1024, stack: 10 * 1024, flash: 173 * 1024 },
    Limits { tier: "full", ram: 60 * 1024, stack: 12 * 1024, flash: 237 * 1024 },
];

/// Limits of the multi-station analysis, a tenth above what `docs/surveys.md` has: stack, bytes, and cycles.
const MOST_STACK: u32 = 12_540;
const MOST_CYCLES: u64 = 30_100_000;

/// RAM of the parts for 150 to 200 degC.
const SMALL_PART: u64 = 64 * 1024;

fn recording() -> (u32, Vec<Sample>) {
    let path = recordings::bundled().unwrap().into_iter().find(|path| path.to_string_lossy().contains("broad_06"));
    let trace = Trace::read(&path.unwrap()).unwrap();
    (trace.nominal_period_us(), trace.samples)
}

/// Digest of what a tier flies here, and its results.
fn flown(tier: &mut impl Tier, period_us: u32, samples: &[Sample]) -> (u32, u32) {
    assert!(tier.configure(&by_hand(period_us)));
    let mut digest = Digest::default();
    samples.iter().filter_map(|sample| tier.push(sample)).for_each(|output| digest.take(&output));
    (digest.number(), tier.results())
}

fn here(tier: &str, period_us: u32, samples: &[Sample]) -> (u32, u32) {
    let mut probe = Box::new(AttitudeProbe::new());
    match tier {
        "attitude" => flown(&mut Attitude::new(&mut probe, &mut Surveys::new()), period_us, samples),
        "identify" => flown(&mut Identify::new(&mut probe, &mut Box::new(Estimator::zero())), period_us, samples),
        _ => flown(&mut Full::new(&mut Box::new(FullProbe::zero()), &mut Surveyor::new()), period_us, samples),
    }
}

/// Samples, digest, results and stack of an image's run, as it prints them.
fn run(toolchain: &Toolchain, elf: &Path, samples: &[u8]) -> [u32; 4] {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("samples.bin"), samples).unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    on_the_board(&mut qemu, elf).current_dir(directory.path());
    numbers(&deadline::run(&mut qemu, RUN).unwrap_or_else(|error| panic!("{error}")))
}

fn on_the_board<'a>(qemu: &'a mut Command, elf: &Path) -> &'a mut Command {
    qemu.args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"]);
    qemu.args(["-serial", "none", "-semihosting-config", "enable=on,target=native", "-kernel"]).arg(elf)
}

fn numbers(printed: &str) -> [u32; 4] {
    let numbers: Vec<u32> = printed.split_whitespace().map(|number| number.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

fn build(toolchain: &Toolchain) {
    // For size: these are for parts with little memory.
    let mut build = toolchain.cargo_build();
    build.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "s").args(["-p", "tiers"]);
    deadline::run(&mut build, BUILD).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn each_tier_fits_and_flies_the_same_on_the_chip() {
    let Some(toolchain) = emulator::toolchain() else { return };
    build(&toolchain);
    let (period_us, samples) = recording();
    let mut file = period_us.to_le_bytes().to_vec();
    file.extend(samples.iter().flat_map(pack));
    println!("| tier | static RAM | stack | flash | results |\n|---|---|---|---|---|");
    for Limits { tier, ram, stack, flash } in LIMITS {
        let path = toolchain.built(tier);
        let elf = fs::read(&path).unwrap();
        let size = Image::parse(&elf).unwrap().size();
        let [number, digest, results, used] = run(&toolchain, &path, &file);
        let statics = size.data_bytes + size.bss_bytes;
        println!("| {tier} | {statics} | {used} | {} | {results} |", size.flash_bytes);
        assert_eq!(number as usize, samples.len());
        assert_eq!((digest, results), here(tier, period_us, &samples), "{tier}");
        assert!(statics + u64::from(used) <= SMALL_PART, "{tier} does not run on 64 KiB");
        assert!(statics <= ram && u64::from(used) <= stack && size.flash_bytes <= flash, "{tier} has grown");
    }
}

/// As many stations as an analysis holds, with a string that magnetises and a disturbed station, so that every part of
/// the analysis runs: a station left out, a prior widened, both decisions.
#[test]
fn a_full_multi_station_analysis_on_the_chip_says_what_it_says_here() {
    let Some(toolchain) = emulator::toolchain() else { return };
    build(&toolchain);
    let drawn = Run { stations: MAX_STATIONS, ..Run::default() }.drawn(7);
    let mut stations = MultiStation::new();
    for (k, truth) in drawn.stations.iter().enumerate() {
        let mut station = truth.station;
        station.field_ut[2] += 1.5 * k as f32 / (MAX_STATIONS - 1) as f32;
        station.field_ut[0] += if k == 20 { 3.0 } else { 0.0 };
        stations.push(station).unwrap();
    }
    let report = analysed_run(&stations).unwrap();
    assert!(report.left_out == 1 << 20 && report.azimuth == Decision::Corrected && report.axial_field_grows());

    let directory = tempfile::tempdir().unwrap();
    let file: Vec<u8> = stations.stations().iter().flat_map(pack_station).collect();
    fs::write(directory.path().join("stations.bin"), file).unwrap();
    let path = toolchain.built("stations");
    let elf = fs::read(&path).unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    on_the_board(&mut qemu, &path);
    let name = ["12analysed_run17h"];
    let (printed, calls) = count_function(&toolchain, &mut qemu, &elf, &name, directory.path()).unwrap();
    let [number, digest, counted, stack] = numbers(&printed);
    let millions = calls.sum.cycles as f64 * 1e-6;
    println!("{number} stations: {millions:.1} million cycles, {stack} bytes of stack");
    assert_eq!((number as usize, digest), (MAX_STATIONS, digest_of(&report, stations.stations())));
    assert_eq!((counted as usize, calls.count), (report.counted, 1));
    assert!(stack <= MOST_STACK && calls.sum.cycles < MOST_CYCLES, "{stack} {calls:?}");
}

/// The effects that the columns of the largest tier hold, in the library's order, the likelier first. The steps of the
/// bias come with a shock, and take what is left then.
#[test]
fn the_likelier_effects_of_the_gyro_have_columns_in_the_largest_tier() {
    let mut left = tiers::COLUMNS;
    let mut fits = Vec::new();
    for effect in LIBRARY.iter().filter(|effect| effect.vector_error().is_none()) {
        let columns = effect.parameters().len();
        println!("{}: {columns}", effect.name());
        if let Some(rest) = left.checked_sub(columns).filter(|_| !effect.is_bias_step()) {
            left = rest;
            fits.push(effect.name());
        }
    }
    println!("in {} columns: {fits:?}", tiers::COLUMNS);
    assert!(fits.len() >= 3, "{fits:?}");
}

/// Inclination and azimuth of an attitude, degrees.
fn direction(q: [f64; 4]) -> [f64; 2] {
    let [w, x, y, z] = q;
    let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
    [axis[2].clamp(-1.0, 1.0).acos().to_degrees(), axis[1].atan2(axis[0]).to_degrees()]
}

/// Errors of a tier in a run, rms of inclination and azimuth in degrees, from 70 s on.
fn errors(tier: &mut impl Tier, config: &Config, trace: &Trace) -> [f64; 2] {
    assert!(tier.configure(config));
    let outputs: Vec<Option<Output>> = trace.samples.iter().map(|sample| tier.push(sample)).collect();
    let from = trace.samples.iter().position(|sample| sample.t_us > trace.first_us() + 70_000_000).unwrap();
    let mut squares = [0.0; 2];
    for (output, truth) in outputs.iter().zip(&trace.reference).skip(from) {
        let told = direction(output.unwrap().attitude.unwrap().q.map(f64::from));
        let truth = direction(truth.unwrap());
        for k in 0..2 {
            let error = (told[k] - truth[k] + 540.0).rem_euclid(360.0) - 180.0;
            squares[k] += error * error / (outputs.len() - from) as f64;
        }
    }
    squares.map(f64::sqrt)
}

/// Errors of each tier in a scenario, and of a probe with every capacity as it is: mean of some runs of 180 s.
fn errors_of_tiers(scenario: &str) -> [[f64; 2]; 4] {
    let scenario = Scenario::read(&workspace().join("host-tests/scenarios").join(scenario)).unwrap();
    let scenario = Scenario { duration_s: 180.0, ..scenario };
    let mut sums = [[0.0_f64; 2]; 4];
    const RUNS: u64 = 4;
    for seed in 1..=RUNS {
        let (trace, _) = simulate(&scenario, seed);
        let config = testbed::flight::configuration::of_trace(&trace);
        let (mut small, mut smaller) = (Box::new(AttitudeProbe::new()), Box::new(AttitudeProbe::new()));
        let of = [
            errors(&mut Attitude::new(&mut smaller, &mut Surveys::new()), &config, &trace),
            errors(&mut Identify::new(&mut small, &mut Box::new(Estimator::zero())), &config, &trace),
            errors(&mut Full::new(&mut Box::new(FullProbe::zero()), &mut Surveyor::new()), &config, &trace),
            errors(&mut Full::new(&mut Box::new(Probe::new()), &mut Surveyor::new()), &config, &trace),
        ];
        sums.iter_mut().zip(of).for_each(|(sum, of)| (0..2).for_each(|k| sum[k] += of[k] / RUNS as f64));
    }
    sums
}

/// Errors of each tier, which show what it gives up: with a gyro that is off by percents, drilling at 45 deg and 30
/// revolutions a minute, without effects and with three that nobody declares.
#[test]
fn a_larger_tier_is_worth_it_while_drilling() {
    let [plain, troubled] = ["drilling_45deg.toml", "undeclared_effects.toml"].map(errors_of_tiers);
    println!("| tier | inclination, deg rms | azimuth, deg rms | with effects: inclination | azimuth |");
    println!("|---|---|---|---|---|");
    let names = LIMITS.iter().map(|limits| limits.tier).chain(["every capacity as it is"]);
    for (tier, (plain, troubled)) in names.zip(plain.iter().zip(&troubled)) {
        println!("| {tier} | {:.2} | {:.2} | {:.2} | {:.2} |", plain[0], plain[1], troubled[0], troubled[1]);
    }
    let [attitude, identify, full, whole] = plain;
    assert!([attitude, identify, full].iter().all(|tier| tier[0] < 1.5 * whole[0]), "{plain:?}");
    let [attitude, identify, full, whole] = troubled;
    assert!(whole[1] < 0.5 * full[1] && full[1] < 0.5 * identify[1], "{troubled:?}");
    assert!(identify[0] < 0.5 * attitude[0], "{troubled:?}");
}
