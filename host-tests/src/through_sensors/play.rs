//! The recording as the truth of the models.

use meerkat_mwd::{
    Sample, SampleFlags,
    sensor_models::{Conversions, ModelledParts, PlayedCounts, Recording, RecordingPlayer},
    sensors::Counters,
};

/// Depth of the FIFO that is modelled; with a watermark of one frame two words are in it.
pub const WORDS: usize = 16;
/// The parts are switched on so long before the recording, so that they have settled when it begins; their time is that much later.
pub const WARM_UP_US: u64 = 1_000_000;
/// Samples for the parts to settle.
const WARM_UP_SAMPLES: u32 = 48;
/// What a part at rest shows in any case, so that its adapter can see that it lives: some codes either way.
const DITHER: [f32; 3] = [0.005, 0.02, 0.1];

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// One per sample of the recording, at its time; what did not come through is flagged missing.
    pub samples: Vec<Sample>,
    /// How many came through, and how they were stamped.
    pub counts: PlayedCounts,
    /// Readings that were there in the recording and are flagged missing now: gyro, accelerometer, magnetometer.
    pub flagged: [usize; 3],
    /// What the adapters counted: gyro and accelerometer, magnetometer.
    pub counters: [Counters; 2],
}

/// The truth that is played for a recording: first a while for the parts to settle, all of it [`WARM_UP_US`] later. The same on a host and on
/// the chip.
pub fn truth(samples: &[Sample], period_us: u32) -> impl Iterator<Item = Sample> + '_ {
    let first = samples.first().copied().unwrap_or_default();
    let settle = (0..WARM_UP_SAMPLES).map(move |k| {
        let t_us = first.t_us + WARM_UP_US - u64::from(WARM_UP_SAMPLES - k) * u64::from(period_us);
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let dithered = |v: [f32; 3], by: f32| v.map(|x| x + side * by);
        Sample {
            t_us,
            gyro_rad_s: dithered(first.gyro_rad_s, DITHER[0]),
            accel_m_s2: dithered(first.accel_m_s2, DITHER[1]),
            mag_ut: dithered(first.mag_ut, DITHER[2]),
            ..first
        }
    });
    settle.chain(samples.iter().map(|sample| Sample { t_us: sample.t_us + WARM_UP_US, ..*sample }))
}

/// How a recording is played: each sample is a conversion of the gyro and the accelerometer, each sample with a field one of the
/// magnetometer.
#[must_use]
pub fn recording(samples: &[Sample], period_us: u32) -> Recording {
    let fields: Vec<u64> =
        samples.iter().filter(|s| !s.flags.contains(SampleFlags::MAG_MISSING)).map(|s| s.t_us).collect();
    let mut steps: Vec<u64> = fields.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable();
    // A recorder's magnetometer may come unevenly: what is soon after the last is not too early.
    let magnetic = steps.get(steps.len() / 10).and_then(|step| u32::try_from(*step).ok());
    Recording {
        inertial_us: period_us,
        magnetic_us: magnetic.unwrap_or(period_us),
        settling: WARM_UP_SAMPLES,
        later_us: WARM_UP_US,
    }
}

/// The recording with each magnetometer reading once: many recorders hold one over several samples, which a part that is read when it has
/// measured does not do (and which looks like a part that is frozen).
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
    let through = |truth| {
        player.pass_to(&truth);
        player.service()
    };
    let mut through: Vec<Sample> = truth(samples, period_us).filter_map(through).collect();
    through.extend(std::iter::from_fn(|| player.finish()));
    let mut flagged = [0; 3];
    let sensors = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
    for (recorded, came) in samples.iter().zip(&through) {
        for (flagged, sensor) in flagged.iter_mut().zip(sensors) {
            *flagged += usize::from(came.flags.contains(sensor) && !recorded.flags.contains(sensor));
        }
    }
    Played { samples: through, counts: player.counts(), flagged, counters: player.counters() }
}
