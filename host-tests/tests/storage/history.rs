//! Models that a command can accept or roll back to.

use super::models::{Dice, Small, Store, open, prepare};
use crate::rig;
use meerkat_mwd::{
    Config,
    compensation::{GyroModel, effects::LIBRARY},
    identification::{Decision, Refusal, WindowReport},
    storage::{ModelHistory, Outcome, StoreReason, StoredModel},
};
use mock_flash::CUTS;

/// A roll-back stores the model before anew and retires the others; wherever the power goes, one of the two
/// flies, and once it is said to be done, the one before.
#[test]
fn a_cut_in_a_roll_back_leaves_one_of_the_two_models() {
    let mut dice = Dice::new(61);
    let mut store = open(Small::new(3, 1));
    prepare(&mut store);
    // Models of different temperatures, so that both are kept.
    let [before, flying] = [dice.model(2, 0, 1), dice.model(3, 2, 2)];
    store.store_model(&before).unwrap();
    let number = store.store_model(&flying).unwrap();
    assert_eq!(store.model_before(number), Ok(Some(before)));
    assert_eq!(store.model_before(number + 1), Ok(Some(flying)));
    assert_eq!(store.verify(), Ok(true));
    let roll_back = |store: &mut Store<4, { 8 * 1024 }>| {
        let model = StoredModel { reason: StoreReason::Command, ..before };
        let number = store.store_model(&model).map_err(drop)?;
        store.retire_models_before(number).map_err(drop)
    };
    let mut complete = store.clone();
    roll_back(&mut complete).unwrap();
    let operations = complete.flash_mut().operations() - store.flash_mut().operations();
    let mut seen = [0; 2];
    for operation in 0..=operations {
        for cut in CUTS {
            let mut cut_off = store.clone();
            cut_off.flash_mut().cut_in(operation, cut);
            let said = roll_back(&mut cut_off);
            let mut flash = cut_off.into_flash();
            flash.power_up();
            let mut restarted = open(flash);
            let Outcome::Chosen { model, .. } = restarted.restore(None).unwrap().outcome else { panic!("none flies") };
            assert!(model.gyro == before.gyro || model.gyro == flying.gyro);
            assert!(said.is_err() || model.gyro == before.gyro, "operation {operation}, {cut:?}");
            seen[usize::from(model.gyro == before.gyro)] += 1;
            // Where it is done nothing of the others is left.
            if said.is_ok() {
                let after = restarted.restore(flying.temperature_c.map(|[low, _]| low)).unwrap().outcome;
                assert!(matches!(after, Outcome::Chosen { model, .. } if model.gyro == before.gyro));
                assert_eq!(restarted.model_before(number + 1), Ok(None));
            }
        }
    }
    println!("{operations} words: {seen:?} times what flew and what flew before");
    assert!(seen.iter().all(|seen| *seen > 10));
}

fn report(t_end_us: u64, decision: Decision, fitted: GyroModel) -> WindowReport {
    WindowReport {
        t_end_us,
        t_effect_us: Some(t_end_us),
        fitted,
        bias_only: fitted,
        flown: fitted,
        sigma: [0.001; 12],
        observable: [true; 12],
        rank: 12,
        ..rig::report::report(decision)
    }
}

#[test]
fn the_latest_window_that_could_look_is_proposed_while_its_effects_fly() {
    let mut dice = Dice::new(62);
    let config = Config::default();
    let factory = config.gyro;
    let [first, second] = [dice.model(0, 0, 0), dice.model(2, 0, 0)];
    let none = first.effects;
    let mut history = ModelHistory::of_factory(&config, &LIBRARY);
    assert_eq!((history.proposed(0, &none), history.previous()), (None, None));

    // The factory's model flies on, and a fit was refused; then a window that could not look.
    let diverged = Decision::Refused(Refusal::Diverged { nis: 2.0 });
    history.window(&report(10, diverged, first.gyro), &factory, &none, Some([20.0, 30.0]));
    let still = Decision::Refused(Refusal::NotEnoughMotion { motion_s: 0.0, needed_s: 10.0 });
    history.window(&report(20, still, factory), &factory, &none, Some([20.0, 30.0]));
    assert_eq!((history.proposed(20, &none), history.previous()), (None, None));
    let proposed = history.proposed(10, &none).unwrap();
    assert_eq!((proposed.gyro, proposed.reason, proposed.t_us), (first.gyro, StoreReason::Command, 10));
    assert_eq!((proposed.sigma, proposed.temperature_c), ([0.001; 12], Some([20.0, 30.0])));
    assert_eq!(history.proposed(10, &second.effects), None, "it was fitted beside other effects");

    // A model is accepted, and its bias follows the temperature: one step back is the factory's.
    history.window(&report(30, Decision::Accepted, first.gyro), &first.gyro, &none, None);
    let warmer = GyroModel { b_rad_s: [0.001; 3], ..first.gyro };
    history.window(&report(40, still, warmer), &warmer, &none, None);
    assert_eq!(history.previous().map(|model| model.gyro), Some(factory));
    assert_eq!(history.proposed(30, &none).map(|model| model.gyro), Some(first.gyro));
    assert_eq!(history.latest().gyro, warmer);
    // An effect is found: what flew without it is one step back, and the fit beside other effects is no
    // longer proposed.
    history.window(&report(50, still, warmer), &warmer, &second.effects, None);
    assert_eq!(history.previous().map(|model| (model.gyro, model.effects)), Some((warmer, none)));
    assert_eq!(history.proposed(30, &second.effects), None);
}
