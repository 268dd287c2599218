use meerkat_mwd::diagnosis::RemainderReport;
use serde::Serialize;

/// Correlates of an unexplained residual and its memory, for the JSON.
#[derive(Debug, Serialize)]
pub(super) struct RemainderJson {
    goes_with: Vec<CorrelateJson>,
    memory: MemoryJson,
    is_white: bool,
}

#[derive(Debug, Serialize)]
struct CorrelateJson {
    name: &'static str,
    share: f32,
    p_value: f32,
}

#[derive(Debug, Serialize)]
struct MemoryJson {
    correlation: f32,
    apart_s: f32,
    p_value: f32,
}

impl RemainderJson {
    pub fn new(remainder: &RemainderReport) -> Self {
        let goes_with = remainder.named().map(|found| CorrelateJson {
            name: found.correlate.name(),
            share: found.share,
            p_value: found.p_value,
        });
        let memory = &remainder.memory;
        Self {
            goes_with: goes_with.collect(),
            memory: MemoryJson { correlation: memory.correlation, apart_s: memory.apart_s, p_value: memory.p_value },
            is_white: remainder.is_white(),
        }
    }
}
