//! A flight over a recording, and all that a probe says of it, as bytes on a line without limits.

use meerkat_mwd::{
    Config, Probe, Sample,
    config::SurveyConfig,
    survey::{SurveyNews, Surveyor},
    telemetry::{AttitudeFormat, Boot, Health, Identification, MAX_FRAME, StreamConfig, TelemetryQueue},
};
use testbed::{
    flight::configuration::of_trace,
    trace::{Trace, recordings},
};

pub fn recording(name: &str) -> (Config, Vec<Sample>) {
    let path = recordings::bundled().unwrap().into_iter().find(|path| recordings::name(path).contains(name)).unwrap();
    let mut trace = Trace::read(&path).unwrap();
    let config = of_trace(&trace);
    trace.mark_clipped(&config.full_scale);
    (config, trace.samples)
}

/// Bytes that a probe with everything switched on sends.
pub fn stream(config: &Config, samples: &[Sample], format: AttitudeFormat) -> Vec<u8> {
    let (mut probe, mut surveyor) = (Box::new(Probe::new()), Surveyor::new());
    let mut queue = Box::new(TelemetryQueue::<4096, 4096, 4096>::new());
    let stream =
        StreamConfig { bytes_per_s: 10_000_000, attitude_every: 1, attitude_format: format, ..StreamConfig::default() };
    queue.configure(&stream).unwrap();
    probe.configure(config).unwrap();
    let survey = SurveyConfig { settle_s: 1.0, average_s: 2.0, ..SurveyConfig::default() };
    surveyor.configure(&config.earth, &survey).unwrap();
    let mut bytes = Vec::new();
    let mut buffer = [0; MAX_FRAME];
    queue.push_result(0, &Boot::new(*config)).unwrap();
    for (number, sample) in (0..).zip(samples) {
        let now_us = sample.t_us;
        queue.push_sample(now_us, number, sample);
        let output = probe.push(sample);
        if let Some(output) = output {
            queue.push_attitude(now_us, &output);
            let news = surveyor.push(&probe.survey_input(sample, &output));
            if news.contains(SurveyNews::STATIONARY) {
                queue.push_result(now_us, surveyor.stationary().unwrap()).unwrap();
            }
            if news.contains(SurveyNews::DYNAMICS) {
                queue.push_result(now_us, surveyor.dynamics().unwrap()).unwrap();
            }
        }
        if let Some(report) = probe.poll(probe.poll_budget()) {
            queue.push_result(now_us, &Identification { report, temperature_c: None }).unwrap();
        }
        if let Some(report) = probe.take_diagnosis() {
            queue.push_result(now_us, &report).unwrap();
        }
        if number % 500 == 499 {
            let health =
                Health { t_us: now_us, counters: probe.counters(), sent: queue.counters(), ..Health::default() };
            queue.push_result(now_us, &health).unwrap();
        }
        while let Some(frame) = queue.pop(now_us, &mut buffer) {
            bytes.extend_from_slice(frame);
        }
    }
    for interval in probe.hard_iron_intervals() {
        queue.push_result(0, interval).unwrap();
    }
    let mut now_us = samples.last().unwrap().t_us;
    while !queue.is_empty() {
        now_us += 100_000;
        while let Some(frame) = queue.pop(now_us, &mut buffer) {
            bytes.extend_from_slice(frame);
        }
    }
    bytes
}
