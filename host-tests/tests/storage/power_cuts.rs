//! The power goes at every word and at every erasure of a long sequence, and at random again and again.

use super::models::{Dice, KIB, Small, Store, TEMPERATURES_C, open, prepare};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{NotDrilling, Outcome, Preparation, Progress, StorageError, StoredModel},
};
use mock_flash::{CUTS, Cut, MockError};

type SmallStore = Store<4, { 8 * KIB }>;

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
enum Action {
    Prepare,
    Model(usize, StoredModel),
    Counter(u64),
    Retire,
}

/// Records that have been promised to be there.
#[derive(Clone, Debug, Default)]
struct Promised {
    /// The newest of each temperature.
    models: [Option<StoredModel>; TEMPERATURES_C.len()],
    /// Temperature of the newest of all.
    newest: Option<usize>,
    counter: u64,
}

impl Promised {
    fn after(&self, action: &Action) -> Self {
        let mut after = self.clone();
        match action {
            Action::Prepare => {}
            Action::Model(band, model) => (after.models[*band], after.newest) = (Some(*model), Some(*band)),
            Action::Counter(counter) => after.counter = *counter,
            Action::Retire => (after.models, after.newest) = Default::default(),
        }
        after
    }

    /// Returns true if a store holds exactly this.
    fn is_kept_by(&self, store: &mut SmallStore) -> bool {
        let mut chosen = |t| match store.restore(t).unwrap().outcome {
            Outcome::Chosen { model, .. } => Some(model),
            _ => None,
        };
        let newest = self.newest.and_then(|band| self.models[band]);
        let models = self.models.iter().zip(TEMPERATURES_C).all(|(model, t)| {
            // Without one of its own a temperature gets its neighbour's.
            model.is_none() || chosen(Some(t)) == *model
        });
        models && chosen(None) == newest && store.read_counter() == self.counter
    }
}

fn run(store: &mut SmallStore, action: &Action) -> Result<(), StorageError<MockError>> {
    match action {
        Action::Prepare => loop {
            if let Preparation::Ready { bad } = store.prepare(NotDrilling::PowerUp)? {
                assert_eq!(bad, 0);
                return Ok(());
            }
        },
        Action::Model(_, model) => store.store_model(model).map(drop),
        Action::Counter(counter) => store.store_counter(*counter),
        Action::Retire => store.retire_models(),
    }
}

/// The same after the power has been away.
fn powered_up(store: SmallStore) -> SmallStore {
    let mut flash = store.into_flash();
    flash.power_up();
    open(flash)
}

/// Enough to fill the ring several times, with commands between and one roll-back.
fn script(dice: &mut Dice) -> Vec<Action> {
    let (mut script, mut t_us, mut counter) = (vec![Action::Prepare], 0, 0);
    for round in 0..8 {
        for _ in 0..24 {
            t_us += 1;
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
            script.push(Action::Model(band, dice.model(effects, band, t_us)));
            if dice.below(3) == 0 {
                counter += 1 + u64::from(dice.below(1000));
                script.push(Action::Counter(counter));
            }
        }
        if round == 2 {
            script.push(Action::Retire);
        }
        script.push(Action::Prepare);
    }
    script
}

#[test]
fn after_a_cut_at_every_word_and_every_erasure_the_last_complete_model_is_there() {
    let mut dice = Dice::new(7);
    let script = script(&mut dice);
    let mut store = open(Small::new(3, 1));
    let mut promised = Promised::default();
    let (mut cuts, mut torn_models, mut erasures) = (0_u64, 0_u64, 0_u64);
    for (number, action) in script.iter().enumerate() {
        let after = promised.after(action);
        let mut complete = store.clone();
        run(&mut complete, action).unwrap_or_else(|e| panic!("action {number}: {e:?}"));
        let operations = complete.flash_mut().operations() - store.flash_mut().operations();
        erasures += u64::from(matches!(action, Action::Prepare));
        for operation in 0..operations {
            for cut in CUTS {
                let mut cut_off = store.clone();
                cut_off.flash_mut().cut_in(operation, cut);
                let said = run(&mut cut_off, action);
                // Actions that write two copies, of which one is enough.
                let is_twofold = matches!(action, Action::Counter(_) | Action::Retire);
                assert!(is_twofold || said.is_err(), "action {number}: the power was away");
                let mut restarted = powered_up(cut_off);
                let is_old = promised.is_kept_by(&mut restarted);
                let is_new = !is_old && after.is_kept_by(&mut restarted);
                let at = format!("action {number} {action:?}, operation {operation} of {operations}, {cut:?}");
                assert!(is_old || is_new, "{at}");
                // An action that was said to be done is done.
                assert!(said.is_err() || is_new || matches!(action, Action::Prepare), "{at}");
                cuts += 1;
                torn_models += u64::from(cut == Cut::Torn && is_old);
                if dice.below(8) == 0 {
                    // It goes on from there: prepared, nothing is lost, and there is room again.
                    prepare(&mut restarted);
                    assert!(if is_old { &promised } else { &after }.is_kept_by(&mut restarted), "prepared: {at}");
                    let model = dice.model(MAX_ACTIVE, 0, 1 << 40);
                    restarted.store_model(&model).unwrap();
                    let next = if is_old { &promised } else { &after }.after(&Action::Model(0, model));
                    assert!(next.is_kept_by(&mut powered_up(restarted)), "stored: {at}");
                }
            }
        }
        (store, promised) = (complete, after);
        assert!(promised.is_kept_by(&mut store), "action {number}");
    }
    let flash = store.into_flash();
    println!(
        "{} actions, {cuts} cuts; {} words, erasures {:?}",
        script.len(),
        flash.words().iter().sum::<u64>(),
        flash.erases()
    );
    assert!(torn_models > 1000 && erasures == 9 && flash.erases().iter().all(|erases| *erases >= 3));
}

#[test]
fn cut_at_random_thousands_of_times_it_loses_nothing_and_always_goes_on() {
    let (mut cuts, mut completed) = (0, 0);
    for seed in 0..6 {
        let mut dice = Dice::new(100 + seed);
        let mut store = open(Small::new(3, seed));
        prepare(&mut store);
        let (mut promised, mut t_us) = (Promised::default(), 0);
        for _ in 0..3000 {
            t_us += 1;
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let action = match dice.below(40) {
                0..20 => Action::Model(band, {
                    let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
                    dice.model(effects, band, t_us)
                }),
                20..28 => Action::Counter(promised.counter + 1 + u64::from(dice.below(5))),
                28 => Action::Retire,
                _ => Action::Prepare,
            };
            let after = promised.after(&action);
            // Mostly soon, so that preparing is cut off again and again.
            let soon = [4, 40, 400, 4000][dice.below(4) as usize];
            let cut = CUTS[dice.below(3) as usize];
            store.flash_mut().cut_in(u64::from(dice.below(soon)), cut);
            let said = run(&mut store, &action);
            if store.flash_mut().is_on() {
                match said {
                    Ok(()) => {
                        completed += 1;
                        promised = after;
                    }
                    Err(StorageError::Full) => {}
                    Err(e) => panic!("seed {seed}: {e:?}"),
                }
                store.flash_mut().power_up();
                assert!(promised.is_kept_by(&mut store), "seed {seed}, {action:?}");
                continue;
            }
            cuts += 1;
            store = powered_up(store);
            if !promised.is_kept_by(&mut store) {
                assert!(after.is_kept_by(&mut store), "seed {seed}, {action:?}");
                promised = after;
            }
        }
        prepare(&mut store);
        assert!(promised.is_kept_by(&mut store));
        assert_eq!(store.counts().abandoned, 0);
    }
    println!("{cuts} cuts, {completed} actions completed");
    assert!(cuts > 3000 && completed > 3000);
}

/// Between samples a model is written in pieces, and a command's counter may come between them.
#[test]
fn a_counter_that_comes_while_a_model_is_written_is_stored_and_so_is_the_model() {
    let mut dice = Dice::new(3);
    let model = dice.model(MAX_ACTIVE, 1, 1);
    let pieces_in_all = {
        let mut store = open(Small::new(3, 9));
        prepare(&mut store);
        store.begin_model(&model).unwrap();
        1 + std::iter::from_fn(|| (store.step() == Ok(Progress::More)).then_some(())).count()
    };
    assert!(pieces_in_all > 8);
    for pieces in 0..pieces_in_all {
        for cut_after_counter in [false, true] {
            let mut store = open(Small::new(3, 9));
            prepare(&mut store);
            store.begin_model(&model).unwrap();
            for _ in 0..pieces {
                assert_eq!(store.step(), Ok(Progress::More));
            }
            store.store_counter(5).unwrap();
            assert_eq!(store.begin_model(&model), Err(StorageError::Busy));
            if cut_after_counter {
                let mut restarted = powered_up(store);
                assert_eq!(restarted.read_counter(), 5);
                assert_eq!(restarted.restore(None).unwrap().outcome, Outcome::NothingStored);
                assert_eq!(restarted.scan_counts().damaged, u32::from(pieces > 0));
                continue;
            }
            while store.step() == Ok(Progress::More) {}
            let mut restarted = powered_up(store);
            assert_eq!(restarted.read_counter(), 5);
            let outcome = restarted.restore(None).unwrap().outcome;
            assert!(matches!(outcome, Outcome::Chosen { model: found, .. } if found == model));
        }
    }
}
