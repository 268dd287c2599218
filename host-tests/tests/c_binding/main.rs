//! The C interface: the example in C gives the bytes that the library gives in Rust, compiled as C99 and as C++17 for
//! this machine, and by the cross compiler for an emulated Cortex-M4F.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "../rig/emulator.rs"]
mod emulator;

use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    config::Motion,
    survey::{SurveyNews, Surveyor},
    telemetry::{
        AttitudeFrame, Boot, Identification, MAX_FRAME, MAX_PAYLOAD, Payload, ProbeId, ResetReason, encode_frame,
        encode_payload,
    },
};
use mwd::target::{
    deadline,
    image::Image,
    toolchain::{self, Toolchain},
};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};
use testbed::trace::{Trace, recordings};

const BUILD: Duration = Duration::from_secs(600);
const RUN: Duration = Duration::from_secs(300);
/// Warnings that a vendor's build may have switched on.
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-Wpedantic"];
const CROSS: [&str; 7] =
    ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-Os", "-ffreestanding", "-nostdlib"];

fn folder() -> PathBuf {
    toolchain::workspace().join("bindings/c")
}

fn run(command: &mut Command, time: Duration) -> String {
    deadline::run(command, time).unwrap_or_else(|error| panic!("{error}"))
}

fn recording() -> (Config, Vec<Sample>) {
    let path = recordings::bundled().unwrap().into_iter().find(|path| path.to_string_lossy().contains("broad_06"));
    let trace = Trace::read(&path.unwrap()).unwrap();
    let mut config = Config { sample_period_us: trace.nominal_period_us(), ..Config::default() };
    config.identification.motion = Motion::Hand;
    (config, trace.samples)
}

/// Input of the example, as its source lays it out.
fn samples_bin(config: &Config, samples: &[Sample]) -> Vec<u8> {
    let mut bytes = config.sample_period_us.to_le_bytes().to_vec();
    bytes.extend(u32::from(config.identification.motion == Motion::DrillString).to_le_bytes());
    for sample in samples {
        bytes.extend(sample.t_us.to_le_bytes());
        let numbers = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
        bytes.extend(numbers.as_flattened().iter().chain([&sample.temperature_c]).flat_map(|x| x.to_le_bytes()));
        bytes.extend(u32::from(sample.flags.bits()).to_le_bytes());
    }
    bytes
}

#[derive(Default)]
struct Line {
    sequence: u16,
    bytes: Vec<u8>,
}

impl Line {
    fn send<P: Payload>(&mut self, payload: &P) {
        let (mut room, mut frame) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
        let payload = encode_payload(payload, &mut room).unwrap();
        self.bytes.extend(encode_frame(P::KIND, self.sequence, payload, &mut frame).unwrap());
        self.sequence = self.sequence.wrapping_add(1);
    }
}

/// Flight of the example, in Rust. Returns the frames' bytes, and the number of accepted windows.
fn in_rust(config: &Config, samples: &[Sample]) -> (Vec<u8>, usize) {
    let mut line = Line::default();
    let mut accepted = 0;
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    let mut surveyor = Surveyor::new();
    surveyor.configure(&config.earth, &config.survey).unwrap();
    let id = ProbeId([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    line.send(&Boot { probe: id, reset: ResetReason::Unknown, ..Boot::new(*config) });
    for (k, sample) in samples.iter().enumerate() {
        if let Some(output) = probe.push(sample) {
            line.send(&output);
            if k.is_multiple_of(20) {
                line.send(&AttitudeFrame::of(&output));
            }
            let news = surveyor.push(&probe.survey_input(sample, &output));
            if news.contains(SurveyNews::STATIONARY) {
                line.send(surveyor.stationary().unwrap());
            }
        }
        if let Some(report) = probe.poll(probe.poll_budget()) {
            accepted += usize::from(report.decision == meerkat_mwd::identification::Decision::Accepted);
            line.send(&Identification { report, temperature_c: Some(sample.temperature_c) });
        }
    }
    (line.bytes, accepted)
}

/// Both are the same bytes, or the place of the first that is not.
fn hold(sent: &[u8], expected: &[u8], who: &str) {
    if sent != expected {
        let at = sent.iter().zip(expected).take_while(|(one, other)| one == other).count();
        let frame = |bytes: &[u8]| -> Vec<u8> {
            let start = bytes[..at.min(bytes.len())].iter().rposition(|byte| *byte == 0).map_or(0, |zero| zero + 1);
            bytes[start..].iter().copied().take_while(|byte| *byte != 0).take(100).collect()
        };
        panic!("{who}: {at} of {} bytes are the same, then\n{:?}\n{:?}", expected.len(), frame(sent), frame(expected));
    }
}

/// Compiles the example for this machine and flies the samples; returns the frames' bytes.
fn on_the_host(directory: &Path, compiler: &[&str]) -> Vec<u8> {
    let (here, library) = (folder(), toolchain::target_dir().join("debug/libmeerkat_mwd_c.a"));
    let program = directory.join("replay");
    let mut command = Command::new(compiler[0]);
    command.args(&compiler[1..]).args(WARNINGS).arg("-O1").arg("-I").arg(here.join("include"));
    command.args(["replay.c", "host.c"].map(|file| here.join("examples").join(file)));
    // The library's archive is no C++ source.
    command.args(["-x", "none"]).arg(library).args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program);
    run(&mut command, BUILD);
    run(Command::new(&program).current_dir(directory).args(["samples.bin", "frames.bin"]), RUN);
    fs::read(directory.join("frames.bin")).unwrap()
}

#[test]
fn c_and_cpp_on_the_host_give_the_bytes_of_rust() {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(
        Command::new(cargo).current_dir(toolchain::workspace()).args(["build", "--locked", "-p", "meerkat-mwd-c"]),
        BUILD,
    );
    let (config, samples) = recording();
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("samples.bin"), samples_bin(&config, &samples)).unwrap();
    let (expected, accepted) = in_rust(&config, &samples);
    // The comparison is of a flight in which something is learnt.
    assert!(accepted > 0 && expected.len() > 1_000_000, "{accepted} {}", expected.len());
    for compiler in [["gcc", "-std=c99", "-xc"], ["g++", "-std=c++17", "-xc++"]] {
        hold(&on_the_host(directory.path(), &compiler), &expected, compiler[0]);
    }
    println!("{} samples: {} bytes of frames, {accepted} windows accepted", samples.len(), expected.len());
}

/// Builds the example for the emulated chip.
fn cross_built(toolchain: &Toolchain, directory: &Path) -> Vec<u8> {
    run(toolchain.cargo_build().args(["-p", "meerkat-mwd-c"]), BUILD);
    let (here, image) = (folder(), directory.join("replay.elf"));
    let mut command = Command::new("arm-none-eabi-gcc");
    command.args(CROSS).args(["-std=c99", "-Wall", "-Wextra", "-Werror"]).arg("-I").arg(here.join("include"));
    command.args(["replay.c", "mps2/start.c"].map(|file| here.join("examples").join(file)));
    command.arg(toolchain.built("libmeerkat_mwd_c.a")).arg("-T").arg(here.join("examples/mps2/link.x"));
    run(command.args(["-Wl,--gc-sections", "-lgcc", "-o"]).arg(&image), BUILD);
    fs::read(image).unwrap()
}

#[test]
fn c_on_the_emulated_chip_gives_the_bytes_of_rust_and_reaches_no_panic() {
    let Some(toolchain) = emulator::toolchain() else { return };
    let compiler = deadline::run(Command::new("arm-none-eabi-gcc").arg("--version"), BUILD);
    if let Err(missing) = compiler {
        assert!(std::env::var_os("MWD_REQUIRE_EMULATOR").is_none(), "apt-get install gcc-arm-none-eabi: {missing}");
        eprintln!("SKIPPED: apt-get install gcc-arm-none-eabi: {missing}");
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let elf = cross_built(&toolchain, directory.path());
    let image = Image::parse(&elf).unwrap();
    assert!(!image.has_function("9panicking"), "a panic can be reached");
    assert!(image.has_function("mwd_probe_push"));

    let (config, samples) = recording();
    // A faulty sample must not end anything either.
    let samples: Vec<Sample> = samples
        .into_iter()
        .enumerate()
        .map(|(k, sample)| match k % 5_000 {
            4_000 => Sample { gyro_rad_s: [f32::NAN; 3], flags: SampleFlags::ACCEL_CLIPPED, ..sample },
            4_001 => Sample { t_us: 0, ..sample },
            _ => sample,
        })
        .collect();
    fs::write(directory.path().join("samples.bin"), samples_bin(&config, &samples)).unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.current_dir(directory.path()).args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"]);
    qemu.args(["-serial", "none", "-semihosting-config", "enable=on,target=native", "-kernel", "replay.elf"]);
    run(&mut qemu, RUN);
    let (expected, accepted) = in_rust(&config, &samples);
    assert!(accepted > 0);
    hold(&fs::read(directory.path().join("frames.bin")).unwrap(), &expected, "the chip");
    let size = image.size();
    println!("flash {} bytes, static RAM {}", size.flash_bytes, size.bss_bytes + size.data_bytes);
}
