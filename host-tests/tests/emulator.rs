//! The firmware on the emulated chip: the same bytes as on the host, and no more memory than there is.
//!
//! Where the emulator cannot be had these tests say SKIPPED and pass; with `MWD_REQUIRE_EMULATOR=1` they
//! fail.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod rig;

use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags, config::OptimizerKind, estimator::UNIT_CYCLES, identification::WindowReport,
    probe::Output,
};
use mwd::{
    bench::size,
    target::{
        call_costs::{Call, count_calls},
        emulate::{self, EmulatedFlight, Feed},
        error::EmulateError,
        firmware::{Board, Firmware, build_firmware},
        image::{self, Image},
        machine::build_program,
        module_sizes, toolchain, wire,
    },
};
use nalgebra::Vector3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{process::Command, time::Duration};
use testbed::{
    flight::{self, configuration},
    simulate::{Scenario, simulate},
    trace::Trace,
};

use rig::emulator::toolchain;
use rig::files::scenario;

const MINUTE: Duration = Duration::from_secs(60);

/// A tool that tumbles, with everything that can be wrong with a recording: gaps, missing and frozen sensors,
/// clipped and non-finite readings, time that stands still or goes back.
fn troubled_samples(count: usize, seed: u64) -> Vec<Sample> {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut noise = move |sigma: f32| sigma * (rng.next_u32() as f32 / u32::MAX as f32 - 0.5) * 3.46;
    let down = Vector3::new(0.0, 0.0, 1.0);
    let field = Vector3::new(20.0, 0.0, 45.0);
    let mut body_to_ned = nalgebra::Rotation3::<f32>::identity();
    let mut t_us = 1_000_000;
    (0..count)
        .map(|i| {
            let t = i as f32 * 0.005;
            let turning = if (i / 400) % 4 == 3 { 0.0 } else { 1.0 };
            let rate =
                Vector3::new(libm::sinf(0.9 * t), 0.7 * libm::cosf(0.31 * t), 2.0 * libm::sinf(0.13 * t)) * turning;
            body_to_ned *= nalgebra::Rotation3::new(rate * 0.005);
            let raw = rate * 1.03 + Vector3::new(0.01, -0.02, 0.005);
            let accel = body_to_ned.inverse() * down * -9.81;
            let mag = body_to_ned.inverse() * field;
            let mut jitter = |v: Vector3<f32>, sigma| [v.x + noise(sigma), v.y + noise(sigma), v.z + noise(sigma)];
            let mut sample = Sample {
                t_us,
                gyro_rad_s: jitter(raw, 0.002),
                accel_m_s2: jitter(accel, 0.02),
                mag_ut: jitter(mag, 0.3),
                temperature_c: 40.0 + t,
                flags: SampleFlags::empty(),
            };
            match i % 997 {
                100 => sample.gyro_rad_s[1] = f32::NAN,
                200 => sample.accel_m_s2 = [f32::INFINITY, f32::NEG_INFINITY, 0.0],
                300..400 => sample.flags.insert(SampleFlags::MAG_MISSING),
                450 => sample.flags.insert(SampleFlags::ACCEL_MISSING | SampleFlags::GYRO_MISSING),
                500 => sample.gyro_rad_s = [f32::MAX, -35.0, f32::MIN_POSITIVE / 4.0],
                550..560 => sample.mag_ut = [0.0; 3],
                600 => sample.temperature_c = f32::NAN,
                650 => sample.flags.insert(SampleFlags::GYRO_CLIPPED | SampleFlags::FAULT),
                700 => sample.t_us -= 5_000,
                750 => sample.t_us -= 60_000,
                800 => sample.accel_m_s2 = [1e30, -1e30, 1e-30],
                _ => {}
            }
            t_us += if i % 1500 == 1499 { 3_000_000 } else { 5_000 };
            sample
        })
        .collect()
}

fn bytes(output: &Output) -> Vec<u8> {
    postcard::to_stdvec(output).unwrap()
}

/// Compares encodings: `==` would take -0 for 0.
fn assert_bit_identical(host: &flight::Flight, chip: &flight::Flight) {
    for (index, (host, chip)) in host.outputs.iter().zip(&chip.outputs).enumerate() {
        assert_eq!(bytes(host), bytes(chip), "output {index} differs\nhost {host:?}\nchip {chip:?}");
    }
    for (host, chip) in host.reports.iter().zip(&chip.reports) {
        assert_eq!(postcard::to_stdvec(host), postcard::to_stdvec(chip), "host {host:?}\nchip {chip:?}");
    }
    assert_eq!(host.outputs.len(), chip.outputs.len());
    assert_eq!(host.reports.len(), chip.reports.len());
    assert_eq!(host.counters, chip.counters);
}

/// Flies on both and compares.
fn fly_on_both(config: &Config, samples: &[Sample]) -> Option<EmulatedFlight> {
    toolchain()?;
    let host = flight::fly(config, samples, |_| ()).unwrap();
    let emulated = emulate::fly_emulated(config, None, samples, Feed::Direct).unwrap();
    assert_bit_identical(&host, &emulated.flight);
    assert_eq!(emulated.summary.push.calls, samples.len() as u64);
    assert_eq!(emulated.summary.poll.calls, samples.len() as u64);
    println!("{} samples; {}\n{:#?}", samples.len(), emulated.image, emulated.summary);
    Some(emulated)
}

#[test]
fn a_troubled_flight_is_bit_identical_on_host_and_chip() {
    let mut config = Config::default();
    config.full_scale.gyro_rad_s = Some(34.9);
    config.identification.window_s = 25.0;
    let Some(emulated) = fly_on_both(&config, &troubled_samples(9_000, 5)) else { return };
    assert!(emulated.flight.outputs.len() > 8_000);
}

#[test]
fn an_unbroken_flight_over_a_window_is_bit_identical_on_host_and_chip() {
    let config = Config::default();
    let mut samples = troubled_samples(400, 6);
    samples.retain(|sample| sample.sanitised() == *sample && sample.flags.is_empty());
    let samples: Vec<_> = samples.iter().cycle().take(13_000).zip(1..).collect();
    let samples: Vec<_> = samples.iter().map(|(s, i)| Sample { t_us: 5_000 * i, ..**s }).collect();
    fly_on_both(&config, &samples);
}

/// Each search's arithmetic on both sides; the default one is in the flights above and below.
#[test]
fn every_optimizer_is_bit_identical_on_host_and_chip() {
    use OptimizerKind::{De, ImoaLiteral, Lm, Moa, Pso, Random};
    let scenario = Scenario { duration_s: 56.0, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, 100);
    for kind in [ImoaLiteral, Moa, Pso, De, Random, Lm] {
        let mut config = configuration::of_trace(&trace);
        config.identification.optimizer = kind;
        let Some(emulated) = fly_on_both(&config, &trace.samples) else { return };
        // Levenberg-Marquardt may be done after two; the start's own is one.
        let searched = |report: &WindowReport| report.optimizer == kind && report.evaluations > 1;
        let evaluations: Vec<u32> = emulated.flight.reports.iter().map(|report| report.evaluations).collect();
        assert!(emulated.flight.reports.iter().any(searched), "{kind:?} did not search: {evaluations:?}");
    }
}

/// Every recording that is bundled, wherever its identification windows fall.
#[test]
fn the_bundled_recordings_are_bit_identical_on_host_and_chip() {
    let Ok(folder) = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/traces")) else { return };
    for path in folder.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "gz")) {
        let trace = Trace::read(&path).unwrap();
        println!("{}", path.display());
        fly_on_both(&configuration::of_trace(&trace), &trace.samples);
    }
}

#[test]
fn the_instruction_counter_is_exact_and_repeats() {
    let Some(toolchain) = toolchain() else { return };
    let samples = troubled_samples(1_500, 7);
    let first = emulate::fly_emulated(&Config::default(), None, &samples, Feed::Direct).unwrap();
    let second = emulate::fly_emulated(&Config::default(), None, &samples, Feed::Direct).unwrap();
    assert_eq!(first, second, "the same flight costs the same");
    // 64 ns an instruction at 168 MHz.
    assert_eq!(first.summary.ticks_per_1000_instructions, 10_752);
    let push = first.summary.push;
    assert!(push.instructions_max >= push.instructions_mean() && push.instructions_mean() > 10, "{push:?}");
    // All but the guard.
    let stack_bytes = Board::Trace.chip(&toolchain).stack_bytes_beside(&first.image);
    assert_eq!(u64::from(first.summary.stack_size_bytes), stack_bytes - 128, "{:?}", first.summary);
    assert!(first.summary.stack_used_bytes > 256 && first.summary.stack_used_bytes < first.summary.stack_size_bytes);
}

/// Names of counted functions are found in the firmware, and a call's cost holds all that it calls.
#[test]
fn every_counted_call_is_in_the_firmware_and_costs_what_the_chip_counts() {
    let Some(_) = toolchain() else { return };
    let scenario = Scenario { duration_s: 14.0, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, 100);
    let config = configuration::of_trace(&trace);
    let costs = count_calls(&config, &trace.samples).unwrap();
    let flown = emulate::fly_emulated(&config, None, &trace.samples, Feed::Direct).unwrap();
    let [sample, work, piece, node] = [Call::Sample, Call::Work, Call::Piece, Call::Node].map(|call| costs.of(call));
    assert_eq!((sample.count, work.count), (trace.samples.len() as u64, trace.samples.len() as u64));
    // The chip counts its call's own instructions beside those of the function that is called.
    let near = |plugin: u64, chip: u64| plugin.abs_diff(chip) <= 30;
    let push = flown.summary.push;
    assert!(near(sample.sum.instructions / sample.count, push.instructions_mean()), "{sample:?}, {push:?}");
    let poll = flown.summary.poll;
    assert!(near(work.sum.instructions / work.count, poll.instructions_mean()), "{work:?}, {poll:?}");
    assert!(node.periods > 20 && node.sum.cycles < piece.sum.cycles, "{node:?}, {piece:?}");
    assert!(piece.sum.cycles < work.sum.cycles && piece.most.cycles <= work.most.cycles, "{piece:?}, {work:?}");
}

/// The clock's half that the work beside samples may take is enough for the dearest of its calls: a budget, and the one
/// piece that overshoots it.
#[test]
fn no_call_takes_more_cycles_than_its_budget_allows() {
    let Some(_) = toolchain() else { return };
    let scenario = Scenario { duration_s: 56.0, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, 101);
    let config = configuration::of_trace(&trace);
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    let unit = u64::from(UNIT_CYCLES);
    let budget = u64::from(probe.poll_budget()) * unit;
    let costs = count_calls(&config, &trace.samples).unwrap();
    let (work, sample) = (costs.of(Call::Work), costs.of(Call::Sample));
    let longest = [Call::Piece, Call::Searching, Call::Judging].map(|call| costs.of(call).most.cycles);
    println!("{} cycles of {budget}; pieces {longest:?}; a sample {}", work.most.cycles, sample.most.cycles);
    assert!(work.periods > 0, "a window was reported");
    assert!(work.most.cycles < budget + 650 * unit, "{work:?}");
    assert!(longest.iter().all(|cycles| *cycles < 650 * unit), "{longest:?}");
    // Cycles that the work leaves of a period at 168 MHz: enough for the dearest sample four times over.
    let period = u64::from(config.sample_period_us) * 168;
    assert!(budget * 2 < period && work.most.cycles + 4 * sample.most.cycles < period, "{sample:?}");
}

/// The table that the page shows, name by name.
#[test]
fn no_module_has_outgrown_its_row_of_the_page_of_sizes() {
    let Some(toolchain) = toolchain() else { return };
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measurements/size.md");
    let version = toolchain.compiler_version().unwrap();
    let now = module_sizes::measured(&size::flight().unwrap()).unwrap();
    now.iter().for_each(|(name, bytes)| println!("{bytes:8} {name}"));
    let Some(before) = size::of_page(&std::fs::read_to_string(page).unwrap(), &version) else {
        println!("SKIPPED: the page is of another compiler than {version}");
        return;
    };
    let grown = module_sizes::grown(&before, &now);
    let again = "cargo mwd bench --target --only size --markdown docs/measurements";
    assert!(grown.is_empty(), "grown by over 2 %:\n{}\nif that is meant: {again}", grown.join("\n"));
}

/// Programs that only a bench runs.
#[test]
fn programs_for_the_chip_alone_build() {
    let Some(toolchain) = toolchain() else { return };
    build_program(&toolchain, "filter-cost").unwrap();
}

#[test]
fn the_image_fits_the_chip() {
    let Some(toolchain) = toolchain() else { return };
    let Firmware { elf, size } = build_firmware(&toolchain, Board::Trace).unwrap();
    println!("{size}");
    assert!(size.ram_bytes() <= image::RAM_LIMIT_BYTES, "{size}");
    assert!(size.flash_bytes <= image::FLASH_LIMIT_BYTES, "{size}");
    assert!(size.data_bytes < 1024, "a static is not all zero bytes and takes flash too: {size}");
    let table = Image::parse(&elf).unwrap().vector_table().unwrap();
    assert_eq!(table.address, image::FLASH_START);
    assert_eq!(u64::from(table.stack_pointer), Board::Trace.chip(&toolchain).stack_top);
    let code = image::FLASH_START..image::FLASH_START + size.flash_bytes;
    assert!(code.contains(&u64::from(table.reset)) && table.reset % 2 == 1, "{table:x?}");
}

#[test]
fn no_panic_can_be_reached_from_the_pipeline() {
    let Some(toolchain) = toolchain() else { return };
    let Firmware { elf, .. } = build_firmware(&toolchain, Board::Bare).unwrap();
    let image = Image::parse(&elf).unwrap();
    for call in
        ["configure_probe", "push_sample", "poll_probe", "configure_surveyor", "push_survey", "continuous_survey"]
    {
        assert!(image.has_function(call), "{call} is not in the image: nothing is shown");
    }
    // Length and name, as the mangling writes the module of core; and the handler that every panic ends in.
    assert!(!image.has_function("9panicking"), "a function of core::panicking is in the image");
    assert!(!image.has_function("rust_begin_unwind"), "the panic handler is in the image");
}

#[test]
fn the_library_builds_alone_for_the_chip() {
    let Some(toolchain) = toolchain() else { return };
    let built = toolchain.cargo_build().args(["-p", "meerkat-mwd", "--lib"]).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
}

#[test]
fn the_firmware_refuses_a_bad_trace_with_a_message() {
    let Some(toolchain) = toolchain() else { return };
    let firmware = build_firmware(&toolchain, Board::Trace).unwrap();
    let message = |trace: &[u8]| match emulate::run_firmware(&toolchain, &firmware, trace, MINUTE) {
        Err(EmulateError::Run(error)) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let malformed = "trace.bin does not hold a configuration and whole samples";
    assert!(message(&[]).contains(malformed));

    let trace = wire::encode_trace(&Config::default(), None, None, troubled_samples(300, 8)).unwrap();
    assert!(message(&trace[..trace.len() - 1]).contains(malformed));

    let mut config = Config::default();
    config.identification.max_evaluations = 0;
    let trace = wire::encode_trace(&config, None, None, []).unwrap();
    assert!(message(&trace).contains("identification.max_evaluations must be 1 to 100000"), "{}", message(&trace));
}

#[test]
fn a_trace_of_no_samples_is_a_flight_of_none() {
    let Some(emulated) = fly_on_both(&Config::default(), &[]) else { return };
    assert!(emulated.flight.outputs.is_empty());
}

#[test]
fn the_firmware_is_the_same_whatever_flags_the_user_sets() {
    let Some(toolchain) = toolchain() else { return };
    // The environment reaches cargo through this process: ask the command that would be run.
    let flags_of = |command: &Command| {
        command
            .get_envs()
            .find(|(name, _)| *name == "CARGO_ENCODED_RUSTFLAGS")
            .and_then(|(_, v)| v.map(ToOwned::to_owned))
    };
    assert_eq!(flags_of(&toolchain.cargo_build()), Some(toolchain::RUSTFLAGS.join("\u{1f}").into()));
}
