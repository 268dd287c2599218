//! A drilling run with known truth, ways to trouble it, and checks that every flight must pass.

use super::{
    files::scenario,
    rotation::{angles_and_sigmas, rotation},
};
use meerkat_mwd::{
    Config, Sample,
    attitude::AttitudeFlags,
    compensation::GyroModel,
    compensation::effects::LIBRARY,
    identification::{Decision, Refusal, WindowReport},
    probe::Output,
};
use nalgebra::{UnitQuaternion, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use testbed::{
    flight::{Flight, configuration::of_trace, fly, fly_with},
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, Truth, simulate},
    trace::Trace,
};

/// Rate error of one window's P, deg/s rms, whatever P was before: 0.045 over 24 seeds.
pub const WINDOW_DEG_S: f64 = 0.045;

/// A simulated run at 45 deg of inclination with its truth.
pub struct Run {
    pub trace: Trace,
    pub truth: Truth,
    pub config: Config,
}

/// 100 Hz, 10 s at rest, then drilling.
pub fn run(duration_s: f64, seed: u64) -> Run {
    of_scenario(&Scenario { duration_s, ..scenario("drilling_45deg") }, seed)
}

pub fn of_scenario(scenario: &Scenario, seed: u64) -> Run {
    scenario.validate().unwrap();
    let (trace, truth) = simulate(scenario, seed);
    let config = of_trace(&trace);
    Run { trace, truth, config }
}

impl Run {
    /// The same run of a probe whose factory model is the true one: its attitude is good from the start.
    pub fn calibrated(mut self) -> Self {
        self.config.gyro = self.truth.gyro;
        self
    }

    /// Samples of the run, changed one by one (index, sample).
    pub fn with(&self, mut change: impl FnMut(usize, &mut Sample)) -> Vec<Sample> {
        let mut samples = self.trace.samples.clone();
        for (index, sample) in samples.iter_mut().enumerate() {
            change(index, sample);
        }
        samples
    }

    /// Flies these samples and checks what every flight must satisfy.
    pub fn fly(&self, samples: &[Sample]) -> Flight {
        flown(&self.config, samples)
    }

    /// Flies these samples with nothing new taking effect from an instant on, and checks the same.
    pub fn fly_frozen(&self, freeze_at_us: Option<u64>, samples: &[Sample]) -> Flight {
        let flight = fly_with(&LIBRARY, &self.config, freeze_at_us, samples).unwrap();
        sound(&flight, samples.len());
        flight
    }

    /// The true attitude at the time of an output.
    fn attitude(&self, t_us: u64) -> UnitQuaternion<f64> {
        let index = self.trace.samples.partition_point(|s| s.t_us < t_us);
        rotation(self.trace.reference[index].unwrap())
    }

    /// Angles between the estimate and the truth at an output, degrees: the whole, and that of the vertical.
    pub fn errors_deg(&self, output: &Output) -> Option<(f64, f64)> {
        let attitude = output.attitude?;
        let (estimate, truth) = (rotation(attitude.q.map(f64::from)), self.attitude(output.t_us));
        let down = (estimate.inverse() * Vector3::z()).angle(&(truth.inverse() * Vector3::z()));
        Some((estimate.angle_to(&truth).to_degrees(), down.to_degrees()))
    }

    /// Root mean square of both errors over the outputs from `from_s` to `to_s`, degrees.
    pub fn rms_deg(&self, flight: &Flight, from_s: f64, to_s: f64) -> (f64, f64) {
        let (mut total, mut tilt, mut count) = (0.0, 0.0, 0.0);
        for output in within(flight, from_s, to_s) {
            let (a, b) = self.errors_deg(output).expect("attitude streams");
            total += a * a;
            tilt += b * b;
            count += 1.0;
        }
        assert!(count > 0.0);
        ((total / count).sqrt(), (tilt / count).sqrt())
    }

    /// Largest ratio of the error of the vertical to the reported sigma of the inclination, from `from_s` on.
    pub fn worst_tilt_in_sigmas(&self, flight: &Flight, from_s: f64) -> f64 {
        let ratio = |output: &Output| {
            let sigma = f64::from(output.attitude.unwrap().sigma_inclination_rad).to_degrees();
            self.errors_deg(output).unwrap().1 / sigma
        };
        within(flight, from_s, f64::INFINITY).map(ratio).fold(0.0, f64::max)
    }

    /// Systematic rate errors over the whole run, deg/s: of bias only, of the report's fit, and of what it
    /// flies.
    pub fn rate_errors_deg_s(&self, report: &WindowReport) -> [f64; 3] {
        [report.bias_only, report.fitted, report.flown].map(|model| self.rate_error_deg_s(&model))
    }

    /// Systematic rate error of a model over the run, deg/s.
    pub fn rate_error_deg_s(&self, model: &GyroModel) -> f64 {
        let rates = self.trace.true_rate.as_ref().unwrap();
        systematic_rate_error_rad_s(&self.truth.gyro, model, rates).unwrap().to_degrees()
    }

    /// Returns true if the report's P flies and leaves at most a tenth of the rate error of bias only. Accuracy of a
    /// window is measured elsewhere, without trouble.
    pub fn identified(&self, report: &WindowReport) -> bool {
        let [bias_only, _, flown] = self.rate_errors_deg_s(report);
        println!("{bias_only:.3} -> {flown:.3} deg/s, {:?}", report.decision);
        accepted(report) && flown < 0.1 * bias_only
    }

    /// Checks that nothing that flies is worse than bias only by more than a right P of one window leaves.
    pub fn never_worse_than_bias_only(&self, flight: &Flight) {
        for report in flight.reports.iter().filter(|r| r.t_effect_us.is_some()) {
            let [bias_only, _, flown] = self.rate_errors_deg_s(report);
            assert!(
                flown <= 1.05 * bias_only + WINDOW_DEG_S,
                "{flown} deg/s against {bias_only} with bias only: {report:?}"
            );
        }
    }
}

pub fn within(flight: &Flight, from_s: f64, to_s: f64) -> impl Iterator<Item = &Output> {
    flight.outputs.iter().filter(move |o| (from_s..to_s).contains(&(o.t_us as f64 * 1e-6)))
}

/// Flies any samples and checks that every number is finite and every sample counted.
pub fn flown(config: &Config, samples: &[Sample]) -> Flight {
    let flight = fly(config, samples, |_| {}).unwrap();
    sound(&flight, samples.len());
    flight
}

pub fn sound(flight: &Flight, pushed: usize) {
    let counters = &flight.counters;
    assert_eq!(counters.samples + u64::from(counters.out_of_order), pushed as u64, "{counters:?}");
    assert_eq!(counters.samples, flight.outputs.len() as u64);
    assert!(flight.outputs.windows(2).all(|pair| pair[0].t_us < pair[1].t_us), "times of validity increase");
    flight.outputs.iter().for_each(sound_output);
    flight.reports.iter().for_each(sound_report);
    let overruns = flight.reports.iter().filter(|r| refusal(r) == Some(Refusal::Overrun)).count();
    assert!(overruns <= counters.overruns as usize);
}

pub fn sound_output(output: &Output) {
    assert!(output.rate_rad_s.iter().all(|x| x.is_finite()), "{output:?}");
    if let Some(attitude) = &output.attitude {
        let norm = libm::sqrtf(attitude.q.iter().map(|x| x * x).sum());
        assert!((norm - 1.0).abs() < 1e-3, "{output:?}");
        assert!(angles_and_sigmas(attitude).iter().all(|x| x.is_finite()), "{output:?}");
    }
}

pub fn sound_report(report: &WindowReport) {
    assert!(report.t_start_us <= report.t_end_us, "{report:?}");
    assert!(report.bias_only.is_valid() && report.flown.is_valid(), "{report:?}");
    // A fit of wrong samples may be no valid P: then it must be refused.
    let fitted = report.fitted.p.as_flattened().iter().chain(&report.fitted.b_rad_s);
    assert!(fitted.clone().all(|x| x.is_finite()) && (report.fitted.is_valid() || !accepted(report)), "{report:?}");
    let optional = [report.cost_before, report.cost_after, report.cost_gained_by_search];
    let figures = [report.rest_s, report.motion_s, report.innovation_nis, report.deg_per_turn];
    let all = report.sigma.iter().chain(report.p_covariance.as_flattened()).chain(&report.widths).chain(&figures);
    assert!(all.chain(optional.iter().flatten()).all(|x| x.is_finite()), "{report:?}");
    assert!(report.sigma.iter().all(|s| *s > 0.0) && report.directions_decided <= 9, "{report:?}");
    let reason = match report.decision {
        Decision::Accepted => 0.0,
        Decision::Refused(refusal) => match refusal {
            Refusal::NotEnoughMotion { motion_s, .. } => motion_s,
            Refusal::GyroUnusable { share } | Refusal::NoMagnetometer { share } => share,
            Refusal::Implausible { sigmas } => sigmas,
            Refusal::Diverged { nis } => nis,
            Refusal::MagnetometerUncalibrated { hard_iron_share } => hard_iron_share,
            _ => 0.0,
        },
        _ => 0.0,
    };
    assert!(reason.is_finite(), "{report:?}");
}

pub fn accepted(report: &WindowReport) -> bool {
    report.decision == Decision::Accepted
}

pub fn refusal(report: &WindowReport) -> Option<Refusal> {
    if let Decision::Refused(refusal) = report.decision { Some(refusal) } else { None }
}

/// Reading of a sensor with this full scale.
pub fn saturated(reading: [f32; 3], limit: f32) -> [f32; 3] {
    reading.map(|x| if x.abs() > limit { limit.copysign(x) } else { x })
}

/// Number of outputs whose attitude has these flags.
pub fn flagged(flight: &Flight, flags: AttitudeFlags) -> usize {
    flight.outputs.iter().filter(|o| o.attitude.is_some_and(|a| a.flags.contains(flags))).count()
}

/// Uniform deviates in [0, 1).
pub struct Dice(Xoshiro128PlusPlus);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    pub fn roll(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 4_294_967_296.0
    }
}
