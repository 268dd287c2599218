//! A probe that runs on in the emulator while hosts connect to its serial line and leave.

use super::drilling::PERIOD_US;
use crate::rig::{emulator::toolchain, files::scenario};
use meerkat_mwd::{
    Config, Sample,
    identification::WindowReport,
    survey::VibrationDose,
    telemetry::{
        Acknowledgement, Boot, BurstPart, Command, FrameDecoder, Key, Kind, MAX_DECODED, MAX_FRAME, MAX_PAYLOAD,
        Message, Outcome, authenticate, encode_frame, encode_payload,
    },
};
use mwd::target::{
    firmware::{Board, Firmware, build_firmware},
    machine::build_program,
    real_time::{PROBE, RealTime},
    toolchain::Toolchain,
};
use std::{
    collections::VecDeque,
    fs,
    io::{ErrorKind, Read, Write},
    os::unix::net::UnixStream,
    path::Path,
    process::{self, Child},
    thread,
    time::{Duration, Instant},
};
use testbed::{
    flight::configuration,
    simulate::{Scenario, simulate},
};

/// Time allowed for any step.
const PATIENCE: Duration = Duration::from_secs(300);

/// Key shared by the probe and its owner.
pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";

/// Size of the probe's three flash sectors.
const FLASH_BYTES: usize = 3 * 16 * 1024;

/// A configuration, and the samples of a run that drills from 10 s on and stands still from `stop_s` on for
/// `rest_s` at least.
pub fn drilled(stop_s: f64, rest_s: f64, seed: u64) -> (Config, Vec<Sample>) {
    let scenario = Scenario {
        duration_s: stop_s + 60.0,
        stop_s: Some(stop_s),
        sample_period_us: PERIOD_US as u32,
        ..scenario("drilling_45deg")
    };
    let (trace, _) = simulate(&scenario, seed);
    // At rest any minute is as good as another.
    let rest = &trace.samples[(stop_s * 1e6) as usize / PERIOD_US as usize..];
    let minutes = (rest_s / 60.0) as usize;
    let samples = trace.samples.iter().chain((0..minutes).flat_map(|_| rest)).copied().collect();
    (configuration::of_trace(&trace), samples)
}

/// The emulator, what it runs, and its flash.
pub struct LiveProbe {
    toolchain: Toolchain,
    firmware: Firmware,
    directory: tempfile::TempDir,
    qemu: Option<Child>,
}

impl LiveProbe {
    /// With a flash that was never written. `None`: there is no emulator.
    pub fn new() -> Option<Self> {
        Self::with(Board::Emulated)
    }

    /// One that a loader starts from one of two images, which are still to be written. `None`: there is no emulator.
    pub fn updatable() -> Option<Self> {
        let probe = Self::with(Board::Updatable)?;
        let loader = build_program(&probe.toolchain, "loader").unwrap();
        fs::copy(loader, probe.at("loader")).unwrap();
        Some(probe)
    }

    fn with(board: Board) -> Option<Self> {
        let toolchain = toolchain()?;
        let firmware = build_firmware(&toolchain, board).unwrap();
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("flash.bin"), vec![0xFF; FLASH_BYTES]).unwrap();
        Some(Self { toolchain, firmware, directory, qemu: None })
    }

    /// The ELF file of its program.
    pub fn elf(&self) -> &[u8] {
        &self.firmware.elf
    }

    /// Waits for the emulator to end by itself; returns its exit status.
    pub fn ended(&mut self) -> Option<i32> {
        self.qemu.take().unwrap().wait().unwrap().code()
    }

    pub fn at(&self, name: &str) -> String {
        self.directory.path().join(name).to_str().unwrap().to_owned()
    }

    /// Address of its line, for the command line.
    pub fn place(&self) -> String {
        format!("unix:{}", self.at("line.sock"))
    }

    /// Powers the probe up; whatever ran before loses power. The first host that connects starts the clock.
    pub fn power_up(&mut self, run: &RealTime, samples: &[Sample]) {
        self.power_off();
        let _ = fs::remove_file(self.at("line.sock"));
        run.prepare_in(self.directory.path(), &self.firmware, samples).unwrap();
        let mut qemu = run.emulator(self.directory.path(), &self.toolchain, "unix:line.sock,server=on,wait=on");
        self.qemu = Some(qemu.stdout(process::Stdio::null()).stderr(process::Stdio::null()).spawn().unwrap());
        let until = Instant::now() + PATIENCE;
        while !Path::new(&self.at("line.sock")).exists() {
            assert!(Instant::now() < until, "the emulator opens no socket");
            thread::sleep(Duration::from_millis(10));
        }
    }

    pub fn power_off(&mut self) {
        if let Some(mut qemu) = self.qemu.take() {
            let _ = qemu.kill();
            qemu.wait().unwrap();
        }
    }

    pub fn host(&self) -> Host {
        let until = Instant::now() + PATIENCE;
        let stream = loop {
            match UnixStream::connect(self.at("line.sock")) {
                Ok(stream) => break stream,
                Err(error) => assert!(Instant::now() < until, "{error}"),
            }
        };
        stream.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        Host {
            stream,
            heard: VecDeque::new(),
            decoder: Box::new(FrameDecoder::new()),
            sequence: 0,
            boot: None,
            surveys: 0,
            dose: None,
            burst: vec![],
        }
    }

    /// Runs the program; returns its exit status and output.
    pub fn mwd(&self, arguments: &[&str]) -> (i32, String) {
        let place = self.place();
        let [verb, rest @ ..] = arguments else { panic!("no verb") };
        let output =
            process::Command::new(env!("CARGO_BIN_EXE_mwd")).args([&[*verb, &place], rest].concat()).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code().unwrap(), String::from_utf8(said).unwrap())
    }
}

impl Drop for LiveProbe {
    fn drop(&mut self) {
        self.power_off();
    }
}

/// A host connected to the line.
pub struct Host {
    stream: UnixStream,
    /// Bytes received and not decoded yet.
    heard: VecDeque<u8>,
    decoder: Box<FrameDecoder<MAX_DECODED>>,
    sequence: u16,
    /// The latest that came.
    pub boot: Option<Boot>,
    /// Number of surveys that came.
    pub surveys: u32,
    /// The latest that came.
    pub dose: Option<VibrationDose>,
    /// Parts of the worst second.
    pub burst: Vec<BurstPart>,
}

impl Host {
    /// Receives messages up to and including the first for which `is_last` returns a value.
    pub fn until<T>(&mut self, what: &str, mut is_last: impl FnMut(&Message) -> Option<T>) -> T {
        let until = Instant::now() + PATIENCE;
        let mut buffer = [0; 4096];
        while Instant::now() < until {
            while let Some(byte) = self.heard.pop_front() {
                // A host that connects midway receives the rest of a frame first.
                let message = self.decoder.push(byte).and_then(|frame| Message::decode(&frame).ok());
                if let Some(Message::Boot(boot)) = &message {
                    self.boot = Some(*boot);
                }
                match &message {
                    Some(Message::Dose(dose)) => self.dose = Some(*dose),
                    Some(Message::Burst(part)) => self.burst.push(part.clone()),
                    _ => {}
                }
                self.surveys += u32::from(matches!(message, Some(Message::Survey(_))));
                if let Some(last) = message.as_ref().and_then(&mut is_last) {
                    return last;
                }
            }
            let count = match self.stream.read(&mut buffer) {
                Ok(0) => panic!("the line ended before: {what}"),
                Ok(count) => count,
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
                Err(error) => panic!("{what}: {error}"),
            };
            self.heard.extend(&buffer[..count]);
        }
        panic!("in vain: {what}");
    }

    /// Reads what there is; returns false once the line has ended.
    pub fn is_there(&mut self) -> bool {
        match self.stream.read(&mut [0; 4096]) {
            Ok(count) => count > 0,
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        }
    }

    /// Listens through the drilling and until a survey was taken at rest. Returns the latest window whose fit
    /// was judged.
    pub fn drill(&mut self, stop_us: u64) -> WindowReport {
        let mut reports = Vec::new();
        self.until("a survey after drilling", |message| match message {
            Message::Identification(window) => {
                reports.push(window.report);
                None
            }
            Message::Survey(survey) => (survey.survey.t_end_us > stop_us).then_some(()),
            _ => None,
        });
        println!("{:?}", reports.iter().map(|report| (report.t_end_us, report.decision)).collect::<Vec<_>>());
        *reports.iter().rfind(|report| report.cost_after.is_some()).unwrap()
    }

    /// Has somebody beside send the same plain command without end, until the emulator ends.
    pub fn flooded_with(&self, command: &Command) {
        let mut payload = [0; MAX_PAYLOAD];
        let mut buffer = [0; MAX_FRAME];
        let payload = encode_payload(command, &mut payload).unwrap();
        let frame = encode_frame(Kind::Command, 9, payload, &mut buffer).unwrap().to_vec();
        println!("a flood of {} bytes, again and again", frame.len());
        let mut stream = self.stream.try_clone().unwrap();
        thread::spawn(move || while stream.write_all(&frame).is_ok() {});
    }

    fn ask(&mut self, kind: Kind, payload: &[u8]) -> Outcome {
        // Who asks without the key gets a few answers a second: of the probe's time, of which an attitude or
        // its health tells.
        self.until("a sign of life", |message| {
            matches!(message, Message::Attitude(_) | Message::Health(_)).then_some(())
        });
        self.sequence += 1;
        let sequence = self.sequence;
        let mut buffer = [0; MAX_FRAME];
        self.stream.write_all(&[0]).unwrap();
        self.stream.write_all(encode_frame(kind, sequence, payload, &mut buffer).unwrap()).unwrap();
        self.until("an answer", |message| match message {
            Message::Acknowledgement(Acknowledgement { sequence: s, outcome }) if *s == sequence => {
                Some(outcome.clone())
            }
            _ => None,
        })
    }

    /// Sends a command without authentication.
    pub fn plain(&mut self, command: &Command) -> Outcome {
        let mut buffer = [0; MAX_PAYLOAD];
        let payload = encode_payload(command, &mut buffer).unwrap().to_vec();
        self.ask(Kind::Command, &payload)
    }

    /// Sends a command with the owner's key.
    pub fn signed(&mut self, key: &[u8; 32], counter: u64, command: &Command) -> Outcome {
        let mut buffer = [0; MAX_PAYLOAD];
        let key = Key::new(key, PROBE).unwrap();
        let payload = authenticate(&key, counter, command, &mut buffer).unwrap().to_vec();
        self.ask(Kind::AuthenticatedCommand, &payload)
    }
}
