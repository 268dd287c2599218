//! The power goes before, in and after each word and each erasure of an action of the storage, and what a start finds
//! is compared with what was there before, and with what the action was to bring.

// Everything drawn and stored here is sound: that it cannot be stored would be a defect of this code.
#![allow(clippy::unwrap_used, clippy::missing_panics_doc)]

pub mod doses;
pub mod drawn;
pub mod factory_records;
pub mod images;
pub mod learnt;
pub mod models;
pub mod settings;

use mock_flash::{CUTS, Cut, MockFlash};

/// Finding of a start after a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// The state before the action.
    Old,
    /// The state that the action was to bring.
    New,
    /// Neither: something is lost.
    Neither,
}

/// Findings after the cuts of one kind of action.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Left {
    /// Actions in which the power was cut.
    pub actions: u64,
    /// Words and erasures of these actions.
    pub operations: u64,
    /// For each kind of cut, in the order of [`CUTS`].
    pub cuts: [Starts; CUTS.len()],
    /// First loss, in words.
    pub first: Option<String>,
}

/// Starts after a kind of cut, by what they found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Starts {
    /// Cuts that left the state before the action.
    pub old: u64,
    /// Cuts that left the state that the action was to bring.
    pub new: u64,
    /// Neither, or not what an action was to bring that was reported as done.
    pub lost: u64,
}

impl Starts {
    /// Adds others.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self { old: self.old + other.old, new: self.new + other.new, lost: self.lost + other.lost }
    }

    /// Number of them.
    #[must_use]
    pub const fn all(self) -> u64 {
        self.old + self.new + self.lost
    }
}

impl Left {
    /// Starts after cuts of all kinds.
    #[must_use]
    pub fn starts(&self) -> Starts {
        self.cuts.into_iter().fold(Starts::default(), Starts::and)
    }

    fn count(&mut self, cut: Cut, is_done: bool, found: Found, at: impl FnOnce() -> String) {
        let starts = &mut self.cuts[CUTS.iter().position(|other| *other == cut).unwrap_or(0)];
        match found {
            Found::New => starts.new += 1,
            Found::Old if !is_done => starts.old += 1,
            _ => {
                starts.lost += 1;
                self.first.get_or_insert_with(|| format!("{}: {found:?}, done: {is_done}", at()));
            }
        }
    }
}

/// Cuts the power at every word and every erasure of an action, and returns the state after the action without a cut.
/// `act` returns true if it reports that it is done; `found` powers up and looks.
pub fn everywhere<S: Clone, const WORD: usize, const SECTOR: usize>(
    left: &mut Left,
    start: &S,
    flash: fn(&mut S) -> &mut MockFlash<WORD, SECTOR>,
    act: impl Fn(&mut S) -> bool,
    mut found: impl FnMut(S) -> Found,
) -> S {
    let mut complete = start.clone();
    let before = flash(&mut complete).operations();
    act(&mut complete);
    let operations = flash(&mut complete).operations() - before;
    left.actions += 1;
    left.operations += operations;
    for operation in 0..operations {
        for cut in CUTS {
            let mut cut_off = start.clone();
            flash(&mut cut_off).cut_in(operation, cut);
            let is_done = act(&mut cut_off);
            left.count(cut, is_done, found(cut_off), || format!("operation {operation} of {operations}, {cut:?}"));
        }
    }
    complete
}

/// The flash itself.
pub(crate) const fn itself<const WORD: usize, const SECTOR: usize>(
    flash: &mut MockFlash<WORD, SECTOR>,
) -> &mut MockFlash<WORD, SECTOR> {
    flash
}
