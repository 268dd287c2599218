use super::models::Dice;
use crate::rig;
use meerkat_mwd::{
    Sample,
    compensation::{ActiveEffects, GyroModel},
    identification::{Decision, Refusal, WindowReport},
    storage::{BETWEEN_STORES_US, STABLE_WINDOWS, StabilityGate, StoredModel},
};

const SIGMA: f32 = 0.002;

fn report(decision: Decision, window: u64) -> WindowReport {
    WindowReport {
        t_start_us: window * 25_000_000,
        t_end_us: window * 25_000_000 + 50_000_000,
        t_effect_us: Some(window * 25_000_000 + 55_000_000),
        sigma: [SIGMA; 12],
        observable: [true; 12],
        rank: 12,
        ..rig::report::report(decision)
    }
}

const BLIND: Decision = Decision::Refused(Refusal::NotEnoughMotion { motion_s: 3.0, needed_s: 10.0 });
const DIVERGED: Decision = Decision::Refused(Refusal::Diverged { nis: 3.0 });

/// Plays windows to a gate; after which of them there was a model.
struct Play {
    gate: StabilityGate,
    window: u64,
}

impl Play {
    fn window(&mut self, decision: Decision, gyro: &GyroModel) -> Option<StoredModel> {
        self.window += 1;
        self.gate.window(&report(decision, self.window), gyro, &ActiveEffects::none(), 7)
    }
}

fn play(restored: Option<&StoredModel>) -> Play {
    Play { gate: StabilityGate::new(&GyroModel::IDENTITY, restored), window: 0 }
}

#[test]
fn it_takes_windows_in_succession_that_have_looked_and_left_it() {
    let gyro = Dice::new(61).model(0, 0, 0).gyro;
    let mut play = play(None);
    assert_eq!(STABLE_WINDOWS, 3);
    assert_eq!(play.window(Decision::Accepted, &gyro), None);
    assert_eq!(play.window(Decision::Accepted, &gyro), None);
    assert_eq!(play.window(BLIND, &gyro), None, "a window that cannot look says nothing");
    let model = play.window(Decision::Accepted, &gyro).unwrap();
    assert_eq!((model.gyro, model.sigma), (gyro, [SIGMA; 12]));
}

#[test]
fn a_divergence_and_a_change_begin_the_count_anew() {
    let gyro = Dice::new(62).model(0, 0, 0).gyro;
    let mut play = play(None);
    play.window(Decision::Accepted, &gyro);
    play.window(Decision::Accepted, &gyro);
    assert_eq!(play.window(DIVERGED, &gyro), None);
    assert_eq!([play.window(Decision::Accepted, &gyro), play.window(Decision::Accepted, &gyro)], [None; 2]);
    let mut moved = gyro;
    moved.p[1][2] += 3.5 * SIGMA;
    assert_eq!(play.window(Decision::Accepted, &moved), None);
    moved.p[1][2] += 2.5 * SIGMA;
    assert_eq!(play.window(Decision::Accepted, &moved), None, "within three deviations it is the same");
    assert!(play.window(Decision::Accepted, &moved).is_some());
}

#[test]
fn the_factorys_model_is_never_stored_nor_what_is_stored_already() {
    let gyro = Dice::new(63).model(0, 0, 0).gyro;
    let mut play_factory = play(None);
    assert!((0..9).all(|_| play_factory.window(Decision::Accepted, &GyroModel::IDENTITY).is_none()));
    let mut first = play(None);
    let mut found = None;
    for _ in 0..4 {
        found = first.window(Decision::Accepted, &gyro).or(found);
    }
    let mut later = play(found.as_ref());
    assert!((0..9).all(|_| later.window(Decision::Accepted, &gyro).is_none()), "it was restored");
    // Another temperature is news; the model of this session only half an hour after the one before.
    for t_us in 0..3 {
        later.gate.sample(&Sample { t_us, temperature_c: 80.0, ..Sample::default() });
    }
    let hot = later.window(Decision::Accepted, &gyro).unwrap();
    assert_eq!(hot.temperature_c, Some([80.0; 2]));
    later.gate.stored(&hot);
    let mut moved = gyro;
    moved.p[0][0] += 10.0 * SIGMA;
    let next = (0..200).find_map(|_| later.window(Decision::Accepted, &moved)).unwrap();
    let since = next.t_us - hot.t_us;
    assert!((BETWEEN_STORES_US..BETWEEN_STORES_US + 25_000_000).contains(&since));
    assert_eq!(next.temperature_c, None, "of this P none was read");
}
