//! Cuts of a long sequence of models, counters of commands, a retirement of all models, and what makes room for them.

use super::{
    Found, Left,
    drawn::{Dice, KIB, Small, Store, TEMPERATURES_C, open, prepare},
    everywhere,
};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{NotDrilling, Outcome, Preparation, StorageError, StoredModel},
};
use mock_flash::MockError;

/// Storage with the smallest sectors that there may be.
pub type SmallStore = Store<4, { 8 * KIB }>;

/// Kinds of action, in the order in which they are counted.
pub const KINDS: [&str; 4] = ["room is made", "a model is stored", "a counter is stored", "all models are retired"];

/// Action of the storage.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
pub enum Action {
    /// Makes room.
    Prepare,
    /// Stores a model of one of the temperatures.
    Model(usize, StoredModel),
    /// Stores a counter.
    Counter(u64),
    /// Retires all models.
    Retire,
}

impl Action {
    /// Its place among [`KINDS`].
    const fn kind(&self) -> usize {
        match self {
            Self::Prepare => 0,
            Self::Model(..) => 1,
            Self::Counter(_) => 2,
            Self::Retire => 3,
        }
    }
}

/// Records that have been promised to be there.
#[derive(Clone, Debug, Default)]
pub struct Promised {
    /// The newest of each temperature.
    models: [Option<StoredModel>; TEMPERATURES_C.len()],
    /// Temperature of the newest of all.
    newest: Option<usize>,
    /// The counter.
    pub counter: u64,
}

impl Promised {
    /// Promise once an action is done.
    #[must_use]
    pub fn after(&self, action: &Action) -> Self {
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
    pub fn is_kept_by(&self, store: &mut SmallStore) -> bool {
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

/// Carries out an action.
///
/// # Errors
/// The flash failed, or there is no room.
pub fn run(store: &mut SmallStore, action: &Action) -> Result<(), StorageError<MockError>> {
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
#[must_use]
pub fn powered_up(store: SmallStore) -> SmallStore {
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

/// Cuts a script of actions, of which all sectors are erased three times, everywhere; what is left by kind of action.
/// After one cut of eight the probe goes on: room is made, and a model stored.
#[must_use]
pub fn script_cut_everywhere() -> [Left; KINDS.len()] {
    let mut dice = Dice::new(7);
    let script = script(&mut dice);
    let mut store = open(Small::new(3, 1));
    let mut promised = Promised::default();
    let mut left = <[Left; KINDS.len()]>::default();
    for action in &script {
        let after = promised.after(action);
        let found = |cut_off| {
            let mut restarted = powered_up(cut_off);
            let (found, kept) = if promised.is_kept_by(&mut restarted) {
                (Found::Old, &promised)
            } else if after.is_kept_by(&mut restarted) {
                (Found::New, &after)
            } else {
                return Found::Neither;
            };
            let goes_on = dice.below(8) > 0 || goes_on(restarted, kept, &mut dice);
            if goes_on { found } else { Found::Neither }
        };
        // Whoever makes room promises nothing new.
        let act = |store: &mut SmallStore| run(store, action).is_ok() && !matches!(action, Action::Prepare);
        store = everywhere(&mut left[action.kind()], &store, SmallStore::flash_mut, act, found);
        promised = after;
        assert!(promised.is_kept_by(&mut store), "{action:?}");
    }
    assert!(store.erases().iter().all(|erases| *erases >= 3));
    left
}

/// Returns true if room is made without a loss, and the next model stored.
fn goes_on(mut store: SmallStore, kept: &Promised, dice: &mut Dice) -> bool {
    prepare(&mut store);
    if !kept.is_kept_by(&mut store) {
        return false;
    }
    let model = dice.model(MAX_ACTIVE, 0, 1 << 40);
    store.store_model(&model).is_ok() && kept.after(&Action::Model(0, model)).is_kept_by(&mut powered_up(store))
}
