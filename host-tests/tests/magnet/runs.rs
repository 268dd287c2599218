//! Runs with a known magnetic truth.

use crate::rig::handheld::Random;
use meerkat_mwd::{
    Config, Probe,
    attitude::AttitudeFlags,
    magnet::{HardIronCounts, HardIronInterval},
};
use nalgebra::Vector3;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Effects, MagneticBursts, Scenario, simulate},
    trace::Trace,
};

/// A direction whose part along z is at most `along`.
pub fn direction_across(random: &mut Random, along: f64) -> Vector3<f64> {
    loop {
        let v = random.direction();
        if v.z.abs() < along {
            return v;
        }
    }
}

/// A magnet on the body from `on_s` to `off_s`, microtesla; it is brought and taken away in `ramp_s`.
#[derive(Clone, Copy, Debug)]
pub struct Magnet {
    pub offset_ut: Vector3<f64>,
    pub on_s: f64,
    pub off_s: f64,
    pub ramp_s: f64,
}

impl Magnet {
    pub fn attach(&self, trace: &mut Trace) {
        let half = 0.5 * self.ramp_s;
        for sample in &mut trace.samples {
            let t_s = sample.t_us as f64 * 1e-6;
            let share = |edge_s: f64| ((t_s - edge_s + half) / self.ramp_s).clamp(0.0, 1.0);
            let there = self.offset_ut * (share(self.on_s) - share(self.off_s));
            for (reading, add) in sample.mag_ut.iter_mut().zip(there.iter()) {
                *reading += *add as f32;
            }
        }
    }
}

/// A drilling run of a probe whose P is off by 2 to 8 % and has just been switched on: hole, speed, iron of
/// the probe itself, lag and length are drawn.
pub fn drilling(seed: u64, length_s: [f64; 2], bursts_per_minute: f64) -> Trace {
    let random = &mut Random::new(seed);
    let mut scenario = Scenario { duration_s: random.between(length_s[0], length_s[1]), ..Scenario::default() };
    scenario.hole.inclination_deg = if seed.is_multiple_of(2) { 0.0 } else { 45.0 };
    scenario.hole.azimuth_deg = random.between(0.0, 360.0);
    scenario.rotation.mean_rpm = random.between(15.0, 60.0);
    scenario.rest_s = random.between(3.0, 12.0);
    scenario.effects = Effects {
        hard_iron_ut: (random.direction() * random.between(0.0, 2.0)).into(),
        mag_lag_ms: random.between(0.0, 15.0),
        magnetic_bursts: MagneticBursts { per_minute: bursts_per_minute, ..MagneticBursts::default() },
        ..Effects::default()
    };
    simulate(&scenario, seed).0
}

pub struct Watched {
    pub intervals: Vec<HardIronInterval>,
    pub counts: HardIronCounts,
    /// Part of the samples whose field was not used.
    pub unused: f64,
}

pub fn watch(trace: &Trace) -> Watched {
    watch_with(trace, &of_trace(trace), u64::MAX)
}

/// Flies a trace; from `freeze_at_us` on nothing new takes effect.
pub fn watch_with(trace: &Trace, config: &Config, freeze_at_us: u64) -> Watched {
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    probe.freeze(freeze_at_us);
    let mut unused = 0;
    for sample in &trace.samples {
        let output = probe.push(sample).unwrap();
        let flags = output.attitude.map(|attitude| attitude.flags);
        unused += u32::from(flags.is_none_or(|f| f.contains(AttitudeFlags::MAG_UNUSED)));
        probe.poll(probe.poll_budget());
    }
    Watched {
        intervals: probe.hard_iron_intervals().copied().collect(),
        counts: probe.hard_iron_counts(),
        unused: f64::from(unused) / trace.samples.len() as f64,
    }
}

/// Body-fixed offset that is taken out of the field at these times, seconds, by name or as a magnet's, microtesla.
pub fn iron_taken_out(trace: &Trace, at_s: &[f64]) -> Vec<Vector3<f64>> {
    let mut probe = Box::new(Probe::new());
    probe.configure(&of_trace(trace)).unwrap();
    let mut at_s = at_s.iter().peekable();
    let mut taken_out = Vec::new();
    for sample in &trace.samples {
        probe.push(sample).unwrap();
        probe.poll(probe.poll_budget());
        if at_s.next_if(|at_s| sample.t_us as f64 * 1e-6 >= **at_s).is_none() {
            continue;
        }
        let mut sum = Vector3::zeros();
        for found in probe.effects().iter() {
            if probe.library()[usize::from(found.index)].name() == "hard_iron" {
                sum += Vector3::from_row_slice(&found.parameters[..3]).cast::<f64>();
            }
        }
        for interval in probe.hard_iron_intervals().filter(|it| it.is_corrected() && it.to_us.is_none()) {
            sum += interval.offset().cast::<f64>();
        }
        taken_out.push(sum);
    }
    taken_out
}

/// Heading error over the moving part against the trace's own reference (NED), degrees root mean square.
pub fn heading_rms_deg(trace: &Trace, effects: bool) -> f64 {
    let config = Config { effects, ..of_trace(trace) };
    let flight = testbed::flight::fly(&config, &trace.samples, |_| {}).unwrap();
    testbed::score::score(trace, &flight, &testbed::score::Settings::default())
        .unwrap()
        .attitude_rms_deg
        .heading
        .unwrap()
}
