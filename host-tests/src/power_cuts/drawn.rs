//! Models of probes that could be, at random.

use meerkat_mwd::{
    Config,
    compensation::{ActiveEffects, FoundEffect, GyroModel, effects::LIBRARY},
    storage::{Limits, ModelStore, NotDrilling, Preparation, StoreReason, StoredModel, fingerprint},
};
use mock_flash::MockFlash;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Bytes of a kibibyte.
pub const KIB: usize = 1024;
/// The sectors of the chip.
pub type Chip = MockFlash<4, { 16 * KIB }>;
/// The smallest sectors that the store takes.
pub type Small = MockFlash<4, { 8 * KIB }>;

/// Temperatures whose models are all kept, degrees Celsius.
pub const TEMPERATURES_C: [f32; 4] = [15.0, 55.0, 95.0, 135.0];

/// Generator of models and numbers.
pub struct Dice(pub Xoshiro128PlusPlus);

impl Dice {
    /// Seeds it.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    /// From zero, less than `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0.next_u32() % n
    }

    /// From -size to size.
    pub fn within(&mut self, size: f32) -> f32 {
        (self.0.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0) * size
    }

    /// A model that may fly, with `effects` effects, of the temperatures around `TEMPERATURES_C[band]`. Its
    /// time is `t_us`.
    pub fn model(&mut self, effects: usize, band: usize, t_us: u64) -> StoredModel {
        let mut gyro = GyroModel::IDENTITY;
        for (i, p) in gyro.p.iter_mut().flatten().enumerate() {
            *p += self.within(if i % 4 == 0 { 0.1 } else { 0.05 });
        }
        gyro.b_rad_s = [(); 3].map(|()| self.within(0.03));
        let first = self.below(LIBRARY.len() as u32) as usize;
        let mut active = ActiveEffects::none();
        for k in 0..effects {
            let index = (first + k) % LIBRARY.len();
            let mut found = FoundEffect { index: index as u8, ..FoundEffect::default() };
            let values = found.parameters.iter_mut().zip(&mut found.sigma);
            for ((value, sigma), parameter) in values.zip(LIBRARY[index].parameters()) {
                let size = self.within(parameter.largest);
                *value = if parameter.signed { size } else { size.abs() };
                *sigma = self.within(parameter.usual).abs();
            }
            assert!(active.add(found));
        }
        let middle = TEMPERATURES_C[band] + self.within(2.0);
        let half = self.within(2.0).abs();
        StoredModel {
            gyro,
            sigma: [(); 12].map(|()| self.within(0.01).abs()),
            effects: active,
            library: fingerprint(&LIBRARY, &Config::default()),
            temperature_c: Some([middle - half, middle + half]),
            t_us,
            reason: StoreReason::Stable { windows: self.below(200) as u8 },
        }
    }
}

/// Limits of what may fly.
#[must_use]
pub fn limits() -> Limits {
    Limits::new(&Config::default(), &LIBRARY)
}

/// Storage in three sectors.
pub type Store<const WORD: usize, const SECTOR: usize> = ModelStore<MockFlash<WORD, SECTOR>, 3>;

/// Opens it as after power-up.
#[must_use]
pub fn open<const WORD: usize, const SECTOR: usize>(flash: MockFlash<WORD, SECTOR>) -> Store<WORD, SECTOR> {
    ModelStore::open(flash, limits()).unwrap()
}

/// Prepares it; how often it erased.
pub fn prepare<const WORD: usize, const SECTOR: usize>(store: &mut Store<WORD, SECTOR>) -> u32 {
    let mut erased = 0;
    while store.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {
        erased += 1;
        assert!(erased < 12, "it does not come to an end");
    }
    erased
}
