//! Plays a recording as the truth that the register models measure.

use meerkat_mwd::{
    Sample, SampleFlags,
    emulation::{Conversions, DITHER, ModelledParts, PlayedCounts, Recording, RecordingPlayer},
    sensors::Counters,
};

/// Depth of the modelled FIFO in words; with a watermark of one frame it holds two.
pub const WORDS: usize = 16;
/// Samples and counts after the models.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// One per sample of the recording, at its time; readings that did not come through are flagged missing.
    pub samples: Vec<Sample>,
    /// Number of samples that came through, and how they were stamped.
    pub counts: PlayedCounts,
    /// Readings present in the recording and flagged missing now: gyro, accelerometer, magnetometer.
    pub flagged: [usize; 3],
    /// Counters of the adapters: gyro with accelerometer, magnetometer.
    pub counters: [Counters; 2],
}

/// The truth played for a recording. A part has no missing readings, so gaps of gyro or accelerometer are
/// bridged linearly; their flags stay.
#[must_use]
pub fn truth(samples: &[Sample]) -> Vec<Sample> {
    let mut truth = samples.to_vec();
    let [gyro, accel, _] = DITHER;
    fill(&mut truth, SampleFlags::GYRO_MISSING, gyro, |sample| &mut sample.gyro_rad_s);
    fill(&mut truth, SampleFlags::ACCEL_MISSING, accel, |sample| &mut sample.accel_m_s2);
    truth
}

fn fill(samples: &mut [Sample], missing: SampleFlags, dither: f32, of: impl Fn(&mut Sample) -> &mut [f32; 3]) {
    let mut before = None;
    for k in 0..samples.len() {
        if !samples[k].flags.contains(missing) {
            before = Some(k);
            continue;
        }
        let after = (k..samples.len()).find(|k| !samples[*k].flags.contains(missing));
        let mut reading = |k: usize| (samples[k].t_us as f64, of(&mut samples[k]).map(f64::from));
        let (from, to) = (before.or(after).map(&mut reading), after.or(before).map(&mut reading));
        let (Some((from_us, from)), Some((to_us, to))) = (from, to) else { return };
        let part = if to_us > from_us { (samples[k].t_us as f64 - from_us) / (to_us - from_us) } else { 0.0 };
        let side = if k % 2 == 0 { dither } else { -dither };
        *of(&mut samples[k]) = std::array::from_fn(|axis| (from[axis] + part * (to[axis] - from[axis])) as f32 + side);
    }
}

/// Settings of the play: each sample is one conversion of gyro and accelerometer, each sample with a field
/// one of the magnetometer.
#[must_use]
pub fn recording(samples: &[Sample], period_us: u32) -> Recording {
    let fields: Vec<u64> =
        samples.iter().filter(|s| !s.flags.contains(SampleFlags::MAG_MISSING)).map(|s| s.t_us).collect();
    let mut steps: Vec<u64> = fields.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable();
    // A recorder's magnetometer may come unevenly: take the tenth percentile of the steps, so that a short
    // step is not too early.
    let magnetic = steps.get(steps.len() / 10).and_then(|step| u32::try_from(*step).ok());
    Recording { inertial_us: period_us, magnetic_us: magnetic.unwrap_or(period_us) }
}

/// The recording with each magnetometer reading once. Recorders often repeat one over several samples; a part
/// that is read when it has measured does not, and a repeated reading looks frozen.
#[must_use]
pub fn each_field_once(samples: &[Sample]) -> Vec<Sample> {
    let mut last = None;
    let once = samples.iter().map(|sample| {
        let held = last == Some(sample.mag_ut);
        last = Some(sample.mag_ut);
        match held {
            true => Sample { mag_ut: [0.0; 3], flags: sample.flags | SampleFlags::MAG_MISSING, ..*sample },
            false => *sample,
        }
    });
    once.collect()
}

/// Plays a recording through the models.
#[must_use]
pub fn play(samples: &[Sample], period_us: u32) -> Played {
    let parts = ModelledParts::<WORDS>::new(Conversions::WithEverySample);
    let mut player = RecordingPlayer::new(&parts, recording(samples, period_us));
    let truth = truth(samples);
    if let Some(first) = truth.first() {
        player.settle(first);
    }
    let through = |truth| {
        player.pass_to(truth);
        player.service()
    };
    let through: Vec<Sample> = truth.iter().map(through).collect();
    let mut flagged = [0; 3];
    let sensors = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
    for (recorded, came) in samples.iter().zip(&through) {
        for (flagged, sensor) in flagged.iter_mut().zip(sensors) {
            *flagged += usize::from(came.flags.contains(sensor) && !recorded.flags.contains(sensor));
        }
    }
    Played { samples: through, counts: player.counts(), flagged, counters: player.counters() }
}
