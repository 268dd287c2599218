//! From a flight into flash and back into a flight.

use super::models::{Chip, Dice, limits, prepare};
use crate::rig::files::scenario;
use meerkat_mwd::{
    Config, Probe,
    compensation::{ActiveEffects, FoundEffect, GyroModel, VectorModel, effects::LIBRARY},
    probe::{NotRestored, Output},
    storage::{
        Implausible, Limits, ModelHistory, ModelStore, Outcome, StabilityGate, StoreReason, StoredModel, fingerprint,
    },
};
use nalgebra::Vector3;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Scenario, simulate},
    trace::Trace,
};

/// The probe is at rest until then.
const FIRST_MOTION_US: u64 = 10_000_000;

pub fn drilling(duration_s: f64, seed: u64) -> (Trace, Config) {
    let (trace, _) = simulate(&Scenario { duration_s, ..scenario("drilling_45deg") }, seed);
    let config = of_trace(&trace);
    (trace, config)
}

pub fn probe(config: &Config, model: Option<&StoredModel>) -> Box<Probe> {
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    if let Some(model) = model {
        probe.restore(model).unwrap();
    }
    probe
}

fn bits(model: &GyroModel) -> Vec<u32> {
    model.p.iter().flatten().chain(&model.b_rad_s).map(|x| x.to_bits()).collect()
}

/// Returns true if what flies is this to the bit.
fn flies(probe: &Probe, model: &StoredModel) -> bool {
    bits(probe.gyro_model()) == bits(&model.gyro) && *probe.effects() == model.effects
}

fn rate_error_deg_s(trace: &Trace, outputs: &[Output]) -> f64 {
    let truths = trace.true_rate.as_ref().unwrap();
    let square = |(truth, output): (&[f64; 3], &Output)| {
        (Vector3::from(output.rate_rad_s.map(f64::from)) - Vector3::from(*truth)).norm_squared()
    };
    (truths.iter().zip(outputs).map(square).sum::<f64>() / outputs.len() as f64).sqrt().to_degrees()
}

fn through_flash(model: &StoredModel, config: &Config) -> StoredModel {
    let open = |flash| ModelStore::<_, 3>::open(flash, Limits::new(config, &LIBRARY)).unwrap();
    let mut store = open(Chip::new(3, 1));
    prepare(&mut store);
    store.store_model(model).unwrap();
    match open(store.into_flash()).restore(None).unwrap().outcome {
        Outcome::Chosen { model, .. } => model,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_model_that_has_proved_stable_is_stored_and_flies_from_the_first_sample_after_power_up() {
    for seed in [3, 4] {
        let (trace, config) = drilling(240.0, seed);
        let mut first = probe(&config, None);
        let mut gate = StabilityGate::new(&config.gyro, None);
        let mut stored = Vec::new();
        let mut outputs = Vec::new();
        for sample in &trace.samples {
            gate.sample(sample);
            outputs.extend(first.push(sample));
            let Some(report) = first.poll(first.poll_budget()) else { continue };
            if let Some(model) = first.model_worth_storing(&report, &mut gate) {
                assert!(flies(&first, &model));
                gate.stored(&model);
                stored.push(through_flash(&model, &config));
            }
        }
        assert_eq!(stored.len(), 1, "seed {seed}: once, for the next is not due before half an hour");
        let model = stored[0];
        let StoreReason::Stable { windows } = model.reason else { panic!("{model:?}") };
        assert!(windows >= 3 && model.gyro.p != config.gyro.p);

        let opening = trace.samples.len() * 50 / 240;
        let mut second = probe(&config, Some(&model));
        let restored: Vec<Output> = trace.samples[..opening]
            .iter()
            .filter_map(|sample| {
                let output = second.push(sample);
                second.poll(second.poll_budget());
                if sample.t_us < FIRST_MOTION_US {
                    assert_eq!(bits(second.gyro_model())[..9], bits(&model.gyro)[..9], "P before the first motion");
                }
                output
            })
            .collect();
        let [with, without] = [&restored[..], &outputs[..opening]].map(|outputs| rate_error_deg_s(&trace, outputs));
        println!("seed {seed}: first 50 s, {with:.3} deg/s with the stored model, {without:.3} without");
        assert!(with < 0.2 * without);
    }
}

/// At any instant of a flight, what flies then, through flash, flies in another probe: P, b and effects, to
/// the bit.
#[test]
fn a_flight_that_is_broken_off_anywhere_goes_on_with_the_same_model() {
    let (trace, config) = drilling(170.0, 5);
    let mut first = probe(&config, None);
    let mut different = 0;
    for (k, sample) in trace.samples.iter().enumerate() {
        first.push(sample);
        first.poll(first.poll_budget());
        if k % 997 != 996 {
            continue;
        }
        let model = StoredModel {
            gyro: *first.gyro_model(),
            sigma: [0.001; 12],
            effects: *first.effects(),
            library: fingerprint(&LIBRARY, &config),
            temperature_c: None,
            t_us: sample.t_us,
            reason: StoreReason::Command,
        };
        let model = through_flash(&model, &config);
        assert!(flies(&first, &model));
        different += u32::from(model.gyro != config.gyro);
        let mut second = probe(&config, Some(&model));
        assert!(flies(&second, &model));
        for sample in trace.samples[k + 1..].iter().take(300) {
            second.push(sample).unwrap();
            second.poll(second.poll_budget());
        }
        assert!(flies(&second, &model));
    }
    assert!(different > 5);
}

/// Effects of every kind.
#[test]
fn effects_are_restored_to_the_bit() {
    let (trace, config) = drilling(12.0, 6);
    let mut dice = Dice::new(51);
    for effects in 0..=6 {
        for _ in 0..10 {
            let library = fingerprint(&LIBRARY, &config);
            let model = StoredModel { library, ..dice.model(effects, 0, 0) };
            let restored = through_flash(&model, &config);
            assert_eq!(restored, model);
            let mut probe = probe(&config, Some(&restored));
            for sample in &trace.samples[..200] {
                probe.push(sample).unwrap();
            }
            assert!(flies(&probe, &model));
        }
    }
}

/// Asking for models and refusing some changes nothing in a flight.
#[test]
fn with_nothing_restored_the_flight_is_the_same_to_the_bit() {
    let (trace, config) = drilling(100.0, 7);
    let mut dice = Dice::new(52);
    let mut bad = dice.model(2, 0, 0);
    bad.gyro.p[1][1] = 1.5;
    let (mut plain, mut asked) = (probe(&config, None), probe(&config, None));
    assert!(matches!(asked.restore(&bad), Err(NotRestored::Implausible(Implausible::P { row: 1, column: 1, .. }))));
    let mut gate = StabilityGate::new(&config.gyro, None);
    for sample in &trace.samples {
        gate.sample(sample);
        let [one, other] = [plain.push(sample), asked.push(sample)].map(|output| postcard::to_stdvec(&output).unwrap());
        assert_eq!(one, other);
        let [one, other] = [&mut plain, &mut asked].map(|probe| probe.poll(probe.poll_budget()));
        assert_eq!(one, other);
        if let Some(report) = other {
            asked.model_worth_storing(&report, &mut gate);
        }
    }
    assert_eq!(bits(plain.gyro_model()), bits(asked.gyro_model()));
}

#[test]
fn a_model_is_restored_only_at_the_beginning_and_with_its_effects() {
    let (trace, mut config) = drilling(12.0, 8);
    let mut dice = Dice::new(53);
    let [plain, with_effects] = [dice.model(0, 0, 0), dice.model(2, 0, 0)];
    assert_eq!(Probe::new().restore(&plain), Err(NotRestored::NotAtTheBeginning));
    let mut begun = probe(&config, None);
    begun.push(&trace.samples[0]);
    assert_eq!(begun.restore(&plain), Err(NotRestored::NotAtTheBeginning));
    config.effects = false;
    let mut without = probe(&config, None);
    assert_eq!(without.restore(&with_effects), Err(NotRestored::EffectsSwitchedOff));
    assert!(without.effects().is_empty() && *without.gyro_model() == config.gyro);
    assert_eq!(without.restore(&plain), Ok(()));
    assert_eq!(without.restore(&plain), Err(NotRestored::NotAtTheBeginning), "one model only");
    assert_eq!(without.restart(Some(&plain)), Ok(()), "from the beginning");
    assert_eq!(limits().check(&with_effects), Ok(()));
}

/// A restart begins with the library that was set in flight: a model of the old one is refused before anything is lost.
#[test]
fn a_restart_with_a_model_of_the_library_before_leaves_the_probe_as_it_was() {
    let (trace, config) = drilling(12.0, 8);
    let mut model = *ModelHistory::of_factory(&config, &LIBRARY).latest();
    let mut found = FoundEffect { index: 0, ..FoundEffect::default() };
    (found.parameters[0], found.sigma[0]) = (0.004, 0.001);
    assert!(model.effects.add(found));
    let mut flown = probe(&config, None);
    for sample in &trace.samples {
        flown.push(sample);
    }
    flown.set_library(&LIBRARY[1..]);
    let samples = flown.counters().samples;
    let refused = Err(NotRestored::Implausible(Implausible::OtherLibrary));
    assert_eq!((flown.restart(Some(&model)), flown.counters().samples), (refused, samples));
    assert!(samples > 0 && flown.restart(None).is_ok() && flown.counters().samples == 0);
}

/// An effect says what is left of its sensor after the configured calibration and latency. With other ones it would be
/// taken out twice, so it does not fly; a model without effects does.
#[test]
fn effects_do_not_fly_with_another_calibration_or_latency() {
    let plain = Config::default();
    let place = LIBRARY.iter().position(|effect| effect.name() == "hard_iron").unwrap();
    let mut hard_iron = FoundEffect { index: place as u8, ..FoundEffect::default() };
    (hard_iron.parameters[0], hard_iron.sigma[0]) = (8.0, 0.5);
    let mut model = *ModelHistory::of_factory(&plain, &LIBRARY).latest();
    assert!(model.effects.add(hard_iron));
    let bare = StoredModel { effects: ActiveEffects::none(), ..model };
    let other = |change: &dyn Fn(&mut Config)| {
        let mut config = plain;
        change(&mut config);
        config
    };
    let turned = [[1.0, 0.001, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let others = [
        other(&|config| config.mag.offset = [8.0, 0.0, 0.0]),
        other(&|config| config.mag = VectorModel { matrix: turned, ..config.mag }),
        other(&|config| config.accel.offset = [0.0, 0.0, 0.1]),
        other(&|config| config.accel = VectorModel { matrix: turned, ..config.accel }),
        other(&|config| config.latency.mag_s = Some(0.004)),
        other(&|config| config.latency.gyro_s = Some(0.0)),
        other(&|config| config.latency.accel_s = Some(0.002)),
    ];
    assert_eq!(probe(&plain, None).restore(&model), Ok(()));
    for config in &others {
        let refused = Err(NotRestored::Implausible(Implausible::OtherLibrary));
        assert_eq!(probe(config, None).restore(&model), refused, "{config:?}");
        assert_eq!(probe(config, None).restore(&bare), Ok(()), "{config:?}");
    }
    // A setting that says nothing of the vector sensors leaves them.
    let earth = other(&|config| config.earth.dip_rad = Some(1.0));
    assert_eq!(probe(&earth, None).restore(&model), Ok(()));

    // A store that takes another configuration on stores that one's models, and restores no other.
    let mut store = ModelStore::<_, 3>::open(Chip::new(3, 2), Limits::new(&plain, &LIBRARY)).unwrap();
    prepare(&mut store);
    let first = store.store_model(&model).unwrap();
    store.begin_model(&model).unwrap();
    store.step().unwrap();
    let chosen = |store: &mut ModelStore<Chip, 3>| match store.restore(None).unwrap().outcome {
        Outcome::Chosen { number, .. } => Some(number),
        _ => None,
    };
    store.set_limits(&Limits::new(&others[0], &LIBRARY));
    assert_eq!((chosen(&mut store), store.verify()), (None, Ok(true)));
    assert!(store.store_model(&model).is_err(), "its effects are relative to what does not fly any more");
    let second = StoredModel { library: fingerprint(&LIBRARY, &others[0]), ..model };
    let second = store.store_model(&second).unwrap();
    assert_eq!((chosen(&mut store), store.verify()), (Some(second), Ok(true)));
    store.set_limits(&Limits::new(&plain, &LIBRARY));
    assert_eq!((chosen(&mut store), store.verify()), (Some(first), Ok(true)));

    // However often the room is made anew under one configuration, the other's model is still there.
    store.set_limits(&Limits::new(&others[0], &LIBRARY));
    let erased = store.erases();
    for counter in 1..=3_000 {
        if store.store_counter(counter).is_err() {
            prepare(&mut store);
            store.store_counter(counter).unwrap();
        }
    }
    assert!(store.erases().iter().zip(erased).all(|(now, before)| *now > before + 1), "{:?}", store.erases());
    assert_eq!((chosen(&mut store), store.verify()), (Some(second), Ok(true)));
    let flash = store.into_flash();
    let mut store = ModelStore::<_, 3>::open(flash, Limits::new(&plain, &LIBRARY)).unwrap();
    assert_eq!((chosen(&mut store), store.verify()), (Some(first), Ok(true)));
}

/// A model without effects is restored whatever it was stored under; effects found after it are of the present
/// configuration, and are stored as such.
#[test]
fn what_is_found_after_a_restored_model_has_the_present_fingerprint() {
    let config = Config::default();
    let old = StoredModel { library: 1, ..*ModelHistory::of_factory(&config, &LIBRARY).latest() };
    assert_eq!(probe(&config, None).restore(&old), Ok(()));
    let present = fingerprint(&LIBRARY, &config);
    assert_eq!(ModelHistory::new(&old, present, None).latest().library, present);
}
