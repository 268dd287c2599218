//! Effects as they fly, and as they are reported.

use super::*;
use crate::{
    compensation::effects::LIBRARY,
    estimator::{CandidateSet, MAX_CANDIDATES},
};

fn claim_of(found: &FoundEffect) -> Claim {
    Claim {
        effect: found.index,
        step: 0,
        step_us: 0,
        evidence: 20.0,
        parameters: found.parameters,
        sigma: found.sigma,
        size: 0.1,
        size_sigma: 0.01,
        rivals: CandidateSet::EMPTY,
        is_taken_out: true,
    }
}

fn index_of(name: &str) -> u8 {
    LIBRARY.iter().take_while(|effect| effect.name() != name).count() as u8
}

#[test]
fn a_restored_delay_of_the_gyro_is_told_as_it_was_stored() {
    for gyro_s in [None, Some(0.003)] {
        let mut config = Config { sample_period_us: 20_000, ..Config::default() };
        config.latency.gyro_s = gyro_s;
        for name in ["gyro_lag", "mag_lag"] {
            let index = index_of(name);
            let mut stored = FoundEffect { index, ..FoundEffect::default() };
            stored.parameters[0] = 0.015;
            let mut flown = ActiveEffects::none();
            flown.add(stored);
            let estimated = as_estimated(&flown, &LIBRARY, &config);
            let found = estimated.iter().next().unwrap();
            let effect = LIBRARY[usize::from(index)];
            let told = Findings::<1>::zero().told(effect, &claim_of(found), 0, 50.0, &config);
            assert!((told.found.parameters[0] - 0.015).abs() < 1e-6, "{name}, {gyro_s:?}: {told:?}");
        }
    }
}

#[test]
fn what_does_not_fly_is_not_told_as_taken_out() {
    let config = Config::default();
    for (flies, is_restored) in [(false, false), (true, false), (false, true)] {
        let mut findings = Findings::<1>::zero();
        let index = index_of("eddy_lag");
        let found = FoundEffect { index, parameters: [0.01; 9], sigma: [0.001; 9] };
        if is_restored {
            let mut stored = ActiveEffects::none();
            stored.add(found);
            findings.restore(&stored);
        }
        let effect = LIBRARY[usize::from(index)];
        let mut report = DiagnosisReport {
            t_start_us: 0,
            t_end_us: 50,
            t_effect_us: 0,
            verdict: Verdict::EffectsFound,
            effects: [EffectReport::default(); MAX_CLAIMED],
            count: 1,
            tried: [0.0; MAX_CANDIDATES],
            candidates: 1,
            nis: [1.0; 2],
            remainder: crate::estimator::RemainderReport::default(),
        };
        report.effects[0] = findings.told(effect, &claim_of(&found), 50, 50.0, &config);
        let _ = findings.waiting.push((report, flies));
        findings.take_effect(60, true, &LIBRARY);
        let told = findings.take().unwrap();
        let is_flown = flies || is_restored;
        assert_eq!((told.effects[0].is_taken_out(), findings.flown().is_empty()), (is_flown, !is_flown));
    }
}
