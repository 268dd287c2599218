//! A probe behind a socket: the pipeline, the queue and the gate as a firmware has them, in a thread.

use crate::{
    commands::{Counters, PROBE, key},
    frames::Decoder,
};
use meerkat_mwd::{
    Config, Probe, Sample,
    probe::Output,
    telemetry::{
        Acknowledgement, AttitudeFormat, Boot, Command, CommandGate, CommandRefusal, Health, ImagePart, Judgement,
        Kind, MAX_FRAME, Outcome, ProgramReport, SelfTest, Situation, StreamConfig, TelemetryQueue,
    },
};
use std::{
    io::{ErrorKind, Read, Write},
    mem,
    net::TcpListener,
    thread::{self, JoinHandle},
    time::Duration,
};

/// Log of what a probe did until its host hung up.
#[derive(Default)]
pub struct Log {
    /// Outputs that it computed for the samples that it sent.
    pub outputs: Vec<Output>,
    /// Commands that it carried out.
    pub carried_out: Vec<Command>,
    /// Counters that it stored.
    pub counters: Vec<u64>,
    /// Bytes of the program that came.
    pub program: Vec<u8>,
}

/// Behaviour of a played probe.
#[derive(Clone, Copy, Default)]
pub struct Manner {
    pub drilling: bool,
    pub deaf: bool,
    /// It takes another program; its first answer to each command is lost on the line.
    pub loses_answers: bool,
    /// Its program is on trial when the first announcement of another one comes.
    pub on_trial: bool,
    /// It has no room for the first counter.
    pub full: bool,
    /// The latest counter in its memory.
    pub latest: u64,
    /// Findings that it reports after a self-test; without any it keeps them to itself.
    pub self_test: Option<SelfTest>,
    /// Samples after which it hangs up; 0 never.
    pub hangs_up_after: usize,
}

/// Starts one that serves `hosts` hosts, one after another; gives its address for the command line.
pub fn start(config: Config, samples: Vec<Sample>, manner: Manner, hosts: usize) -> (String, JoinHandle<Log>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp:{}", listener.local_addr().unwrap());
    let thread = thread::spawn(move || {
        let mut store = Counters { stored: vec![manner.latest], broken: manner.full };
        let mut log = Log::default();
        for _ in 0..hosts {
            let (stream, _) = listener.accept().unwrap();
            stream.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
            serve(stream, &config, &samples, manner, &mut store, &mut log);
        }
        log.counters = store.stored;
        log
    });
    (place, thread)
}

fn serve(
    mut stream: impl Read + Write,
    config: &Config,
    samples: &[Sample],
    manner: Manner,
    store: &mut Counters,
    log: &mut Log,
) {
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    let mut queue = Box::new(TelemetryQueue::<4096, 4096, 2048>::new());
    let format = AttitudeFormat::Compact;
    let fast =
        StreamConfig { bytes_per_s: 1_000_000, attitude_every: 10, attitude_format: format, max_age_us: 1_000_000 };
    queue.configure(&fast).unwrap();
    let mut gate = CommandGate::new(Some(key()));
    let mut decoder = Decoder::new();
    let mut frame = [0; MAX_FRAME];
    let mut recording = false;
    let mut heard = [0; 256];
    let boot = Boot { probe: PROBE, restored_model: Some(3), ..Boot::new(*config) };
    queue.push_result(0, &boot).unwrap();
    let mut program = ProgramReport { number: 1, confirmed: true, other: None, received: None };
    let mut announced = 0;
    let mut number = 0;
    let mut rounds = 0_u64;
    loop {
        rounds += 1;
        // Its clock: a round is a sample while it records, else a millisecond of waiting.
        let mut now_us = rounds * 10_000;
        if recording && let Some(sample) = samples.get(number) {
            now_us = now_us.max(sample.t_us);
            queue.push_sample(now_us, number as u32, sample);
            number += 1;
            if let Some(output) = probe.push(sample) {
                queue.push_attitude(now_us, &output);
                log.outputs.push(output);
            }
            let _ = probe.poll(probe.poll_budget());
            let _ = probe.take_diagnosis();
        } else if rounds.is_multiple_of(20) {
            let self_test = manner.self_test.filter(|_| log.carried_out.contains(&Command::SelfTest));
            let counters = probe.counters();
            let health = Health { probe: PROBE, t_us: now_us, counters, self_test, ..Health::default() };
            let _ = queue.push_result(now_us, &health);
            if manner.loses_answers || manner.on_trial {
                queue.push_result(now_us, &program).unwrap();
            }
        }
        while let Some(bytes) = queue.pop(now_us, &mut frame) {
            if stream.write_all(bytes).is_err() {
                return;
            }
        }
        if manner.hangs_up_after > 0 && number == manner.hangs_up_after && queue.is_empty() {
            return;
        }
        if recording && !rounds.is_multiple_of(50) {
            continue;
        }
        let count = match stream.read(&mut heard) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(_) => return,
        };
        for &byte in &heard[..count] {
            let Some(frame) = decoder.push(byte) else { continue };
            if manner.deaf {
                continue;
            }
            if frame.kind == Kind::ImagePart.number() {
                let part: ImagePart = postcard::from_bytes(frame.payload).unwrap();
                log.program.extend_from_slice(part.bytes);
                let answer = Acknowledgement { sequence: frame.sequence, outcome: Outcome::Accepted };
                queue.push_result(now_us, &answer).unwrap();
                continue;
            }
            let situation = Situation { now_us, drilling: manner.drilling };
            let answer = match gate.judge(&frame, situation, store) {
                Judgement::CarryOut { sequence, command, .. } => {
                    let kind = mem::discriminant(&command);
                    let is_first = log.carried_out.iter().all(|before| mem::discriminant(before) != kind);
                    if manner.on_trial && is_first && matches!(command, Command::BeginUpdate { .. }) {
                        log.carried_out.push(command);
                        let outcome = Outcome::Refused(CommandRefusal::Busy);
                        queue.push_result(now_us, &Acknowledgement { sequence, outcome }).unwrap();
                        continue;
                    }
                    match command {
                        Command::StartRecording { .. } => recording = true,
                        Command::StopRecording => recording = false,
                        Command::BeginUpdate { number, .. } => announced = number,
                        Command::FinishUpdate => program.other = Some(announced),
                        Command::Restart => program = ProgramReport { number: announced, other: Some(1), ..program },
                        _ => {}
                    }
                    log.carried_out.push(command);
                    if manner.loses_answers && is_first {
                        continue;
                    }
                    Acknowledgement { sequence, outcome: Outcome::Accepted }
                }
                Judgement::Refuse(answer) => {
                    // It makes room.
                    store.broken = false;
                    answer
                }
                Judgement::Ignore => continue,
            };
            queue.push_result(now_us, &answer).unwrap();
        }
    }
}
