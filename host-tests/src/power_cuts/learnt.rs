//! Cuts of a model that is stored with what the filter has learnt: both count together.

use super::{
    Found, Left,
    drawn::{Chip, Dice, KIB, Store, open, prepare},
    everywhere,
};
use meerkat_mwd::{
    Config, Probe,
    estimator::{LearntHead, NUMBERS, NotContinued},
    storage::{LearntProgress, Outcome, StorageError, StoredModel},
};
use mock_flash::MockError;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Scenario, simulate},
    study::one_window::scenario,
};

/// Storage with the sectors of the chip.
pub type ChipStore = Store<4, { 16 * KIB }>;

/// All numbers of a filter, as bits, and what belongs to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers {
    /// Bytes that stand before them.
    pub head: LearntHead,
    /// Their bits.
    pub bits: Vec<u32>,
}

impl Numbers {
    /// Those that a probe has learnt.
    #[must_use]
    pub fn of(probe: &Probe) -> Self {
        let learnt = probe.learnt().unwrap();
        Self { head: learnt.head, bits: (0..NUMBERS).map(|k| learnt.number(k).to_bits()).collect() }
    }

    /// Those that are stored with a model.
    pub fn stored_with(store: &mut ChipStore, number: u32) -> Option<Self> {
        let head = store.learnt_with(number).unwrap()?;
        let mut bits = vec![None; NUMBERS];
        assert!(store.read_learnt(number, &mut |k, x| bits[k] = Some(x.to_bits())).unwrap());
        Some(Self { head, bits: bits.into_iter().map(Option::unwrap).collect() })
    }

    /// Has a probe go on from them.
    ///
    /// # Errors
    /// It refuses.
    pub fn give(&self, probe: &mut Probe) -> Result<(), NotContinued> {
        probe.go_on(&self.head, |take| {
            self.bits.iter().enumerate().for_each(|(k, x)| take(k, f32::from_bits(*x)));
            true
        })
    }
}

/// A probe that has drilled for so long, with its filter between two updates.
#[must_use]
pub fn drilled(duration_s: f64, seed: u64) -> (Box<Probe>, Config) {
    let (trace, _) = simulate(&Scenario { duration_s, ..scenario("drilling_45deg").unwrap() }, seed);
    let config = of_trace(&trace);
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    for sample in &trace.samples {
        probe.push(sample);
        probe.poll(probe.poll_budget());
    }
    while probe.learnt().is_none() {
        probe.poll(1);
    }
    (probe, config)
}

/// Stores a model with what the probe has learnt; its number.
///
/// # Errors
/// The flash failed, or there is no room.
pub fn store_both(store: &mut ChipStore, probe: &Probe, model: &StoredModel) -> Result<u32, StorageError<MockError>> {
    store.begin_learnt()?;
    while store.step_learnt(probe.learnt())? != LearntProgress::Whole {}
    store.store_model(model)
}

/// The model that is chosen, and what had been learnt with it.
pub fn kept(store: &mut ChipStore) -> Option<(StoredModel, Option<Numbers>)> {
    match store.restore(None).unwrap().outcome {
        Outcome::Chosen { model, number, .. } => Some((model, Numbers::stored_with(store, number))),
        _ => None,
    }
}

/// Cuts the storing of a second pair everywhere. After one cut of forty room is made, and another pair stored.
#[must_use]
pub fn cut_everywhere() -> Left {
    let ((first, _), (second, _)) = (drilled(40.0, 3), drilled(50.0, 4));
    let [of_first, of_second] = [&first, &second].map(|probe| Some(Numbers::of(probe)));
    let mut dice = Dice::new(3);
    let [old, new] = [1, 2].map(|t_us| dice.model(1, 0, t_us));
    let mut store: ChipStore = open(Chip::new(3, 1));
    prepare(&mut store);
    store_both(&mut store, &first, &old).unwrap();
    let act = |store: &mut ChipStore| store_both(store, &second, &new).is_ok();
    let (old, of_new) = (Some((old, of_first)), Some((new, of_second)));
    let mut left = Left::default();
    let found = |cut_off: ChipStore| {
        let mut flash = cut_off.into_flash();
        flash.power_up();
        let mut restarted = open(flash);
        let found = kept(&mut restarted);
        if dice.below(40) == 0 {
            prepare(&mut restarted);
            let next = dice.model(1, 0, 3);
            let is_kept = kept(&mut restarted) == found && store_both(&mut restarted, &first, &next).is_ok();
            if !is_kept || kept(&mut restarted) != Some((next, old.as_ref().and_then(|(_, of_first)| of_first.clone())))
            {
                return Found::Neither;
            }
        }
        match found {
            found if found == of_new => Found::New,
            found if found == old => Found::Old,
            _ => Found::Neither,
        }
    };
    everywhere(&mut left, &store, ChipStore::flash_mut, act, found);
    left
}
