//! Starts with sectors to be erased, at the worst of the flash's data sheet.

#[path = "../../../src/bin/probe/stm32f405/watchdog_time.rs"]
mod watchdog_time;

use super::{
    models::Dice,
    stm32f405_flash::{Shared, driver::ModelFlash},
};
use meerkat_mwd::{
    Config, Probe, Sample,
    application::Memory,
    compensation::{MAX_ACTIVE, effects::LIBRARY},
    storage::{LearntProgress, Limits, ModelStore, NotDrilling, Preparation},
    survey::VibrationDose,
};
use std::mem::MaybeUninit;
use watchdog_time::{PREPARATION_MS, SHORTEST_MS};

type Store = ModelStore<ModelFlash<Shared>, 3>;

/// Models that are kept, each of another temperature.
const TEMPERATURES: u64 = 8;

fn open(flash: &Shared) -> Store {
    ModelStore::open(ModelFlash(flash.clone()), Limits::new(&Config::default(), &LIBRARY)).unwrap()
}

/// Starts as the board does. Returns the longest time between two feeds of the watchdog, microseconds, with the times
/// before the first and after the last.
fn start(flash: &Shared) -> u64 {
    let now_us = || flash.0.borrow().now_us;
    let (mut fed_us, mut longest_us) = (now_us(), 0);
    let mut feed = || {
        longest_us = longest_us.max(now_us() - fed_us);
        fed_us = now_us();
    };
    let mut place = MaybeUninit::uninit();
    assert!(Memory::start(&mut place, ModelFlash(flash.clone()), &Config::default(), &mut feed).is_ok());
    feed();
    longest_us
}

/// A probe whose filter has learnt something.
fn learnt() -> Box<Probe> {
    let config = Config::default();
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    for k in 1.. {
        let t_us = k * u64::from(config.sample_period_us);
        let turned = t_us as f32 * 1e-6;
        let (sine, cosine) = libm::sincosf(turned);
        let sample = Sample {
            t_us,
            gyro_rad_s: [0.0, 0.0, -1.0],
            accel_m_s2: [5.0 * cosine, 5.0 * sine, -8.4],
            mag_ut: [20.0 * cosine, 20.0 * sine, 40.0],
            ..Sample::default()
        };
        probe.push(&sample);
        probe.poll(probe.poll_budget());
        if t_us > 60_000_000 && probe.learnt().is_some() {
            break;
        }
    }
    probe
}

/// Stores all that is kept, as long as it can be, and then counters, until no room is left: all that counts stands in
/// the sector that is erased first.
fn fill(flash: &Shared, probe: &Probe, seed: u64) {
    let (mut dice, mut store) = (Dice::new(seed), open(flash));
    let mut model = |store: &mut Store, band: u64| {
        let low = 10.0 + 15.0 * band as f32;
        let mut model = dice.model(MAX_ACTIVE, 0, seed);
        model.temperature_c = Some([low, low + 2.0]);
        // A model that finds no room is not kept.
        let _ = store.store_model(&model);
    };
    // In each round another amount of it stands elsewhere.
    (0..seed % 40).for_each(|k| model(&mut store, k % TEMPERATURES));
    (1..TEMPERATURES).for_each(|band| model(&mut store, band));
    if store.begin_learnt().is_ok() {
        while !matches!(store.step_learnt(probe.learnt()), Ok(LearntProgress::Whole) | Err(_)) {}
    }
    model(&mut store, 0);
    if store.begin_dose(&VibrationDose::default()).is_ok() {
        while store.is_writing() {
            store.step().unwrap();
        }
    }
    let mut counter = store.read_counter();
    while store.store_counter(counter + 1).is_ok() {
        counter += 1;
    }
}

/// The first start, and starts after every kind of filling: no call outlasts its budget, and so none the fastest
/// watchdog, which is longer (`watchdog_time`). The driver erases and programs 32 bits at a time: an erasure by bytes
/// alone may take longer.
#[test]
fn no_start_outlasts_the_fastest_watchdog_on_the_slowest_flash() {
    let flash = Shared::new();
    let mut longest_us = start(&flash);
    let mut erasures = vec![flash.0.borrow().erased_by.len()];
    let probe = learnt();
    for seed in 0..60 {
        fill(&flash, &probe, seed);
        let before = flash.0.borrow().erased_by.len();
        longest_us = longest_us.max(start(&flash));
        erasures.push(flash.0.borrow().erased_by.len() - before);
    }
    let seen = flash.0.borrow();
    println!(
        "{} erasures in {} starts, {} words; at most {longest_us} us between two feeds; budget {PREPARATION_MS} ms, \
         fastest watchdog {SHORTEST_MS} ms",
        seen.erased_by.len(),
        erasures.len(),
        seen.programmed_by.len()
    );
    assert!(erasures.iter().all(|erased| *erased >= 1), "a start erased nothing: {erasures:?}");
    assert!(seen.erased_by.iter().chain(&seen.programmed_by).all(|bits| *bits == 32));
    assert!(longest_us <= u64::from(PREPARATION_MS) * 1_000, "{longest_us} us");
}

/// The same where a command asks for it: each call erases one sector at most.
#[test]
fn no_call_on_a_command_outlasts_the_fastest_watchdog() {
    let flash = Shared::new();
    start(&flash);
    fill(&flash, &learnt(), 1);
    let mut store = open(&flash);
    loop {
        let before_us = flash.0.borrow().now_us;
        let more = store.prepare(NotDrilling::Command).unwrap();
        let took_us = flash.0.borrow().now_us - before_us;
        assert!(took_us <= u64::from(PREPARATION_MS) * 1_000, "{took_us} us");
        if more != Preparation::More {
            return;
        }
    }
}
