//! Cuts of a command that is stored because it sets what holds after a start.

use super::{
    Found, Left,
    doses::blank,
    drawn::{Dice, Small, open, prepare},
    everywhere, itself,
    models::SmallStore,
};
use meerkat_mwd::{
    Config,
    compensation::VectorModel,
    config::{FullScale, Latency},
    storage::StoredCommand,
};
use rand_core::Rng;

/// Commands that are stored.
pub const BOTH: [StoredCommand; 2] = [StoredCommand::Configure, StoredCommand::ConfigureSurvey];

/// Bytes of any length that a command may have.
pub fn drawn(dice: &mut Dice) -> Vec<u8> {
    let length = 1 + dice.below(560);
    (0..length).map(|_| dice.0.next_u32() as u8).collect()
}

/// The stored bytes of both.
pub fn read(store: &mut SmallStore) -> [Option<Vec<u8>>; 2] {
    BOTH.map(|command| store.read_command(command).map(|(_, bytes)| bytes.to_vec()))
}

/// A configuration that leaves nothing out.
#[must_use]
pub fn longest_configuration() -> Config {
    let vector =
        VectorModel { matrix: [[1.5, 0.25, 0.0], [0.0, 1.25, 0.0], [0.5, 0.0, 2.0]], offset: [0.5, -0.25, 0.125] };
    let mut config = Config {
        accel: vector,
        mag: vector,
        full_scale: FullScale { gyro_rad_s: Some(8.0), accel_m_s2: Some(64.0), mag_ut: Some(512.0) },
        latency: Latency { gyro_s: Some(0.25), accel_s: Some(0.5), mag_s: Some(0.125) },
        ..Config::default()
    };
    config.earth.latitude_rad = Some(0.5);
    config.earth.declination_rad = Some(0.25);
    config
}

/// Cuts a first command, the second one, and the 31st, everywhere. After each cut room is made.
#[must_use]
pub fn cut_everywhere() -> Left {
    let (mut left, mut dice) = (Left::default(), Dice::new(10));
    for before in [0, 1, 30] {
        let (mut store, mut old) = (blank(), None);
        for _ in 0..before {
            let bytes = drawn(&mut dice);
            if store.store_command(BOTH[0], &bytes).is_err() {
                prepare(&mut store);
                store.store_command(BOTH[0], &bytes).unwrap();
            }
            old = Some(bytes);
        }
        prepare(&mut store);
        let new = drawn(&mut dice);
        let act = |flash: &mut Small| {
            let mut store = open(flash.clone());
            let is_kept = store.store_command(BOTH[0], &new).is_ok();
            *flash = store.into_flash();
            is_kept
        };
        let found = |mut flash: Small| {
            flash.power_up();
            let mut store = open(flash);
            let [read_first, _] = read(&mut store);
            prepare(&mut store);
            let [after, _] = read(&mut store);
            match read_first {
                _ if after != read_first && after != old => Found::Neither,
                Some(bytes) if bytes == new => Found::New,
                bytes if bytes == old => Found::Old,
                _ => Found::Neither,
            }
        };
        everywhere(&mut left, &store.into_flash(), itself, act, found);
    }
    left
}
