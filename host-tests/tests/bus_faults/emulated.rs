//! The sampling path on the emulated chip: the same samples to the bit; and a driver against a device model
//! that nobody here wrote.
//!
//! Where the emulator cannot be had these tests say SKIPPED and pass; with `MWD_REQUIRE_EMULATOR=1` they
//! fail.

use crate::rig::emulator::toolchain;
use mwd::target::{
    emulate::{Feed, fly_emulated},
    machine::build_program,
    toolchain::Toolchain,
};
use std::{
    io::{BufRead, BufReader, Write},
    os::unix::net::UnixStream,
    path::Path,
    process::{Command, Stdio},
    time::Duration,
};
use testbed::{
    flight::{
        configuration, fly,
        through_sensors::{each_field_once, play},
    },
    simulate::simulate,
    study::one_window,
};

#[test]
fn a_flight_through_adapters_on_models_is_the_same_to_the_bit_on_host_and_chip() {
    if toolchain().is_none() {
        return;
    }
    let mut scenario = one_window::scenario("drilling_45deg").unwrap();
    scenario.duration_s = 62.0;
    let (trace, _) = simulate(&scenario, 9);
    let config = configuration::of_trace(&trace);
    let recorded = each_field_once(&trace.samples);
    let played = play(&recorded, config.sample_period_us);
    let host = fly(&config, &played.samples, |_| {}).unwrap();
    let chip = fly_emulated(&config, None, &recorded, Feed::ThroughSensors).unwrap();
    assert!(host.outputs.len() >= recorded.len() - 1 && !host.reports.is_empty());
    assert_eq!(postcard::to_stdvec(&host.outputs), postcard::to_stdvec(&chip.flight.outputs));
    assert_eq!(postcard::to_stdvec(&host.reports), postcard::to_stdvec(&chip.flight.reports));
    assert_eq!(host.counters, chip.flight.counters);
    let cost = chip.sampling.unwrap();
    println!("{cost:?}");
    assert_eq!(cost.counts, played.counts);
    assert!(cost.adapters > 100.0 && cost.wires > 100.0 && cost.most >= cost.adapters);
    // Fly what the adapters made of the recording, not the recording.
    let direct = fly_emulated(&config, None, &recorded, Feed::Direct).unwrap();
    assert_ne!(direct.flight.outputs, chip.flight.outputs);
    assert_eq!(direct.sampling, None);
}

/// Sends a command of QEMU's machine protocol and returns its answer, without events.
fn command(socket: &mut BufReader<UnixStream>, text: &str) -> String {
    writeln!(socket.get_mut(), "{text}").unwrap();
    loop {
        let mut line = String::new();
        assert!(socket.read_line(&mut line).unwrap() > 0, "{text}: the emulator is gone");
        if !line.contains("\"event\"") {
            assert!(line.contains("\"return\""), "{text}: {line}");
            return line;
        }
    }
}

fn connect(path: &Path) -> BufReader<UnixStream> {
    for _ in 0..600 {
        if let Ok(stream) = UnixStream::connect(path) {
            stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
            return BufReader::new(stream);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("the emulator opens no socket");
}

/// Output of the image for a field in nanotesla. The field is set after the machine is set up, which resets
/// the device, and before it runs.
fn measured(toolchain: &Toolchain, image: &[u8], field_nt: [u32; 3]) -> String {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("image"), image).unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.current_dir(directory.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    qemu.args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none", "-S"]);
    qemu.args(["-qmp", "unix:qmp,server=on,wait=off", "-device", "lsm303dlhc_mag,address=0x1e,id=mag"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel", "image"]);
    let child = qemu.spawn().unwrap();
    let mut socket = connect(&directory.path().join("qmp"));
    let mut greeting = String::new();
    socket.read_line(&mut greeting).unwrap();
    command(&mut socket, r#"{"execute":"qmp_capabilities"}"#);
    for (axis, nt) in ["x", "y", "z"].into_iter().zip(field_nt) {
        let set = format!(
            r#"{{"execute":"qom-set","arguments":{{"path":"/machine/peripheral/mag","property":"mag-{axis}","value":{nt}}}}}"#
        );
        command(&mut socket, &set);
    }
    // The program may have ended before this is answered.
    writeln!(socket.get_mut(), r#"{{"execute":"cont"}}"#).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_field_of_qemus_lsm303dlhc_is_read_over_a_bit_banged_bus() {
    let Some(toolchain) = toolchain() else { return };
    let image = std::fs::read(build_program(&toolchain, "mps2-magnetometer").unwrap()).unwrap();
    for field_nt in [[0, 0, 0], [20_000, 3_000, 45_000], [61_234, 33_333, 7], [4_999, 58_001, 28_765]] {
        let said = measured(&toolchain, &image, field_nt);
        let mut lines = said.lines();
        assert_eq!(lines.next(), Some("identification 48 34 33"));
        let field = lines.next().and_then(|line| line.strip_prefix("field ")).unwrap();
        // An LSB is 91 nT on x and y, 102 nT on z; model and conversion both truncate.
        for (nt, (word, lsb_nt)) in field_nt.iter().zip(field.split(' ').zip([91, 91, 103])) {
            let read: u32 = word.parse().unwrap();
            assert!(read <= *nt && nt - read <= lsb_nt + 1, "{field} for {field_nt:?}");
        }
        assert_eq!(lines.next(), Some("nobody true"));
    }
}
