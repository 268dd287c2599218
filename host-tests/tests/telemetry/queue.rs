//! A slow line: what goes, what stays, how fast and how late.

use crate::frames::Decoder;
use meerkat_mwd::{
    Sample,
    probe::Output,
    survey::DrillingDynamics,
    telemetry::{
        Acknowledgement, Health, LineCounters, MAX_FRAME, Message, Outcome, PushError, StreamConfig, TelemetryQueue,
    },
};
use proptest::prelude::*;

const RESULTS: usize = 300;
const SAMPLES: usize = 400;
const ATTITUDE: usize = 200;
type Queue = TelemetryQueue<RESULTS, SAMPLES, ATTITUDE>;

#[derive(Clone, Debug)]
enum Event {
    Result,
    Health,
    Sample,
    Attitude,
    Pass(u64),
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        1 => Just(Event::Result),
        1 => Just(Event::Health),
        4 => Just(Event::Sample),
        6 => Just(Event::Attitude),
        6 => (1_u64..80_000).prop_map(Event::Pass),
    ]
}

fn dynamics(number: u64) -> DrillingDynamics {
    DrillingDynamics {
        t_start_us: number,
        t_end_us: 0,
        axial_rms_m_s2: Some(1.0),
        lateral_rms_m_s2: None,
        peak_m_s2: None,
        shocks: 0,
        clipped: 0,
        rotation: None,
        axial_peak_m_s2: None,
        lateral_peak_m_s2: None,
        shocks_over: [0; 3],
        whirl: None,
    }
}

fn output(number: u64) -> Output {
    Output { t_us: number, rate_rad_s: [0.0; 3], attitude: None }
}

/// Message that left the queue, with its time and its length on the line.
#[derive(Clone, Debug)]
struct Sent {
    at_us: u64,
    bytes: usize,
    message: Message,
}

struct Run {
    sent: Vec<Sent>,
    /// When each was accepted, by number.
    results_us: Vec<u64>,
    attitudes_us: Vec<u64>,
    healths: usize,
    samples: usize,
    refused: u32,
    counters: LineCounters,
}

fn run(config: &StreamConfig, events: &[Event]) -> Run {
    let mut queue = Queue::new();
    queue.configure(config).unwrap();
    let mut decoder = Decoder::new();
    let mut buffer = [0; MAX_FRAME];
    let mut run = Run {
        sent: vec![],
        results_us: vec![],
        attitudes_us: vec![],
        healths: 0,
        samples: 0,
        refused: 0,
        counters: LineCounters::default(),
    };
    let mut now_us = 1_000_000;
    // At the end everything that waits may leave.
    let end = std::iter::repeat_n(Event::Pass(5_000), 4_000);
    for event in events.iter().cloned().chain(end) {
        match event {
            Event::Result => match queue.push_result(now_us, &dynamics(run.results_us.len() as u64)) {
                Ok(()) => run.results_us.push(now_us),
                Err(error) => {
                    assert_eq!(error, PushError::Full);
                    run.refused += 1;
                }
            },
            Event::Health => match queue.push_result(now_us, &Health::default()) {
                Ok(()) => run.healths += 1,
                Err(_) => run.refused += 1,
            },
            Event::Sample => {
                let sample = Sample { t_us: now_us, ..Sample::default() };
                queue.push_sample(now_us, run.samples as u32, &sample);
                run.samples += 1;
            }
            Event::Attitude => {
                queue.push_attitude(now_us, &output(run.attitudes_us.len() as u64));
                run.attitudes_us.push(now_us);
            }
            Event::Pass(micros) => now_us += micros,
        }
        while let Some(frame) = queue.pop(now_us, &mut buffer) {
            let bytes = frame.len();
            let decoded = frame.iter().filter_map(|&byte| decoder.push(byte).map(|f| Message::decode(&f).unwrap()));
            let messages: Vec<Message> = decoded.collect();
            assert_eq!(messages.len(), 1);
            run.sent.push(Sent { at_us: now_us, bytes, message: messages[0].clone() });
        }
    }
    assert!(queue.is_empty());
    assert_eq!(decoder.counters().lost + decoder.counters().bad, 0);
    run.counters = queue.counters();
    run
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn nothing_is_lost_without_being_counted_and_no_result_ever(
        events in prop::collection::vec(event(), 0..400),
        bytes_per_s in 200_u32..20_000,
        max_age_us in 1_000_u32..3_000_000,
        attitude_every in 0_u16..4,
    ) {
        let config = StreamConfig { bytes_per_s, max_age_us, attitude_every, ..StreamConfig::default() };
        let run = run(&config, &events);

        // Every accepted result, in order; every refused one was the caller's to keep.
        let results: Vec<u64> = run.sent.iter()
            .filter_map(|sent| if let Message::Dynamics(d) = sent.message { Some(d.t_start_us) } else { None }).collect();
        prop_assert_eq!(results, (0..run.results_us.len() as u64).collect::<Vec<_>>());
        let healths = run.sent.iter().filter(|sent| matches!(sent.message, Message::Health(_))).count();
        prop_assert_eq!(healths, run.healths);
        prop_assert_eq!(run.counters.results_refused, run.refused);

        // Samples and attitudes: sent or counted, and what is sent is in order.
        let samples: Vec<u32> = run.sent.iter()
            .filter_map(|sent| if let Message::Sample(s) = sent.message { Some(s.number) } else { None }).collect();
        prop_assert!(samples.is_sorted());
        prop_assert_eq!(samples.len() as u32 + run.counters.samples_dropped, run.samples as u32);
        let attitudes: Vec<u64> = run.sent.iter()
            .filter_map(|sent| if let Message::Attitude(a) = sent.message { Some(a.t_us) } else { None }).collect();
        prop_assert!(attitudes.is_sorted());
        let turns = run.attitudes_us.len().checked_div(attitude_every.into()).unwrap_or(0);
        prop_assert_eq!(attitudes.len() + run.counters.attitude_dropped as usize, turns);
        prop_assert_eq!(run.counters.frames as usize, run.sent.len());

        // Bandwidth over every interval that begins and ends with a frame, the ends included.
        for (first, from) in run.sent.iter().enumerate() {
            let mut bytes = 0;
            for to in &run.sent[first..] {
                bytes += to.bytes;
                let interval_us = to.at_us - from.at_us + 10_000;
                let allowed = interval_us as f64 * 1e-6 * f64::from(bytes_per_s) + MAX_FRAME as f64;
                prop_assert!(bytes as f64 <= allowed, "{bytes} bytes in {interval_us} us");
            }
        }

        // Latency.
        for sent in &run.sent {
            match sent.message {
                Message::Attitude(a) => {
                    let waited_us = sent.at_us - run.attitudes_us[a.t_us as usize];
                    prop_assert!(waited_us <= max_age_us.into(), "{waited_us}");
                }
                Message::Dynamics(d) => {
                    let waited_us = sent.at_us - run.results_us[d.t_start_us as usize];
                    // The line is looked after every 80 ms at worst here, once for each frame of the lane.
                    let bytes = (RESULTS + MAX_FRAME) as u64;
                    let looks = (RESULTS / 10) as u64 * 80_000;
                    prop_assert!(waited_us <= bytes * 1_000_000 / u64::from(bytes_per_s) + looks, "{waited_us}");
                }
                _ => {}
            }
        }
    }

    /// With a line that keeps up nothing is dropped, whatever the order.
    #[test]
    fn a_fast_line_drops_nothing(events in prop::collection::vec(event(), 0..300)) {
        let config = StreamConfig { bytes_per_s: 10_000_000, attitude_every: 1, ..StreamConfig::default() };
        let events: Vec<Event> = events.into_iter().flat_map(|event| [event, Event::Pass(1_000)]).collect();
        let counters = run(&config, &events).counters;
        prop_assert_eq!((counters.attitude_dropped, counters.samples_dropped, counters.results_refused), (0, 0, 0));
    }
}

#[test]
fn the_freshest_attitudes_survive_a_line_that_stood_still() {
    let mut queue = Queue::new();
    queue.configure(&StreamConfig { attitude_every: 1, ..StreamConfig::default() }).unwrap();
    for number in 0..100 {
        queue.push_attitude(0, &output(number));
    }
    let (mut decoder, mut buffer, mut sent) = (Decoder::new(), [0; MAX_FRAME], vec![]);
    for now_us in (0..400_000).step_by(1_000) {
        while let Some(frame) = queue.pop(now_us, &mut buffer) {
            for &byte in frame {
                if let Some(frame) = decoder.push(byte)
                    && let Ok(Message::Attitude(attitude)) = Message::decode(&frame)
                {
                    sent.push(attitude.t_us);
                }
            }
        }
    }
    let dropped = queue.counters().attitude_dropped as u64;
    assert!(sent.len() >= 15, "{}", sent.len());
    assert_eq!(sent, (dropped..100).collect::<Vec<_>>());
}

/// Messages that are sent in so many seconds while a host asks without end.
fn sent(queue: &mut Queue, seconds: u64, mut each_ms: impl FnMut(&mut Queue, u64)) -> Vec<Message> {
    let (mut decoder, mut buffer, mut sent) = (Decoder::new(), [0; MAX_FRAME], vec![]);
    for now_us in (0..seconds * 1_000_000).step_by(1_000) {
        each_ms(queue, now_us);
        while let Some(frame) = queue.pop(now_us, &mut buffer) {
            let frames = frame.iter().filter_map(|&byte| decoder.push(byte).map(|f| Message::decode(&f).unwrap()));
            sent.extend(frames.collect::<Vec<_>>());
        }
    }
    sent
}

#[test]
fn answers_take_no_room_of_results_and_go_after_them() {
    let mut queue = Queue::new();
    queue.configure(&StreamConfig::default()).unwrap();
    let answer = Acknowledgement { sequence: 7, outcome: Outcome::Accepted };
    while queue.push_result(0, &answer).is_ok() {}
    assert_eq!(queue.results_room(), RESULTS, "all of it is the results'");
    for number in 0..4 {
        queue.push_result(0, &dynamics(number)).unwrap();
    }
    let first = &sent(&mut queue, 2, |_, _| ())[..4];
    assert!(first.iter().all(|message| matches!(message, Message::Dynamics(_))), "{first:?}");
}

/// 200 samples a second of 54 bytes are more than the line takes. Whoever asks for them, with the key or without, every
/// attitude leaves as it would without them, none later than by one frame.
#[test]
fn a_recording_takes_what_attitudes_leave() {
    let attitudes = |recording: bool, attitude_every| {
        let mut queue = Queue::new();
        queue.configure(&StreamConfig { attitude_every, ..StreamConfig::default() }).unwrap();
        let mut samples = 0;
        let said = sent(&mut queue, 10, |queue, now_us| {
            if now_us % 5_000 == 0 {
                if recording {
                    let sample = Sample { t_us: now_us, gyro_rad_s: [0.1; 3], ..Sample::default() };
                    queue.push_sample(now_us, (now_us / 5_000) as u32, &sample);
                }
                queue.push_attitude(now_us, &output(now_us));
            }
        });
        let attitudes = said.into_iter().filter(|message| {
            samples += usize::from(matches!(message, Message::Sample(_)));
            matches!(message, Message::Attitude(_))
        });
        (attitudes.count(), samples, queue.counters().attitude_dropped)
    };
    for attitude_every in [1, 3, 20] {
        let ((alone, _, dropped), (beside, samples, dropped_beside)) =
            (attitudes(false, attitude_every), attitudes(true, attitude_every));
        println!("every {attitude_every}: {alone} attitudes alone; {beside} beside {samples} samples");
        assert!(alone >= 100 && beside == alone && dropped == dropped_beside, "{alone}, {beside}");
        assert!(samples > 500, "{samples} samples");
    }
}

#[test]
fn what_never_fits_says_so() {
    let mut tiny = TelemetryQueue::<16, 16, 16>::new();
    tiny.configure(&StreamConfig { attitude_every: 1, ..StreamConfig::default() }).unwrap();
    assert_eq!(tiny.push_result(0, &dynamics(0)), Err(PushError::TooLong));
    tiny.push_sample(0, 0, &Sample::default());
    assert_eq!((tiny.counters().results_refused, tiny.counters().samples_dropped), (1, 1));
    assert!(tiny.is_empty());
}
