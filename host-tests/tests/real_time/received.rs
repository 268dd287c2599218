//! Messages that came over the serial line.

use meerkat_mwd::{
    diagnosis::DiagnosisReport,
    probe::Output,
    survey::SurveyReport,
    telemetry::{Boot, FrameDecoder, Health, Identification, LinkCounters, MAX_DECODED, Message, RawSample},
};

#[derive(Default)]
pub struct Received {
    pub boots: Vec<Boot>,
    pub outputs: Vec<Output>,
    pub samples: Vec<RawSample>,
    pub healths: Vec<Health>,
    pub identifications: Vec<Identification>,
    pub diagnoses: Vec<DiagnosisReport>,
    pub surveys: Vec<SurveyReport>,
    pub link: LinkCounters,
}

impl Received {
    pub fn of(serial: &[u8]) -> Self {
        let mut decoder = FrameDecoder::<MAX_DECODED>::new();
        let mut received = Self::default();
        for byte in serial {
            let Some(frame) = decoder.push(*byte) else { continue };
            match Message::decode(&frame).unwrap() {
                Message::Boot(boot) => received.boots.push(boot),
                Message::Output(output) => received.outputs.push(output),
                Message::Sample(sample) => received.samples.push(sample),
                Message::Health(health) => received.healths.push(health),
                Message::Identification(report) => received.identifications.push(report),
                Message::Diagnosis(report) => received.diagnoses.push(report),
                Message::Survey(report) => received.surveys.push(report),
                _ => {}
            }
        }
        received.link = decoder.counters();
        received
    }

    /// Returns true if every byte belonged to a frame and no frame is missing.
    pub fn is_whole(&self) -> bool {
        let LinkCounters { bad, oversize, lost, .. } = self.link;
        (bad, oversize, lost) == (0, 0, 0)
    }
}
