//! The whole probe under attack, deterministically: one seed gives a day of drilling and stops with everything that
//! goes wrong in it, and what has to hold is looked at after every round of the program. What runs is the firmware's
//! own program over a [`Board`] of this machine.
//!
//! Most runs compress time: a day of drilling is three minutes of stretches of 5 to 16 s with stops of 4 to 8
//! s, surveys settle and average in 2 s, windows are 10 s long, and troubles come every few seconds. A quarter of these
//! runs is calm: ten minutes, windows of the length that flies, and a trouble in 45 s. [`fly_day`] flies whole days at
//! real proportions. Sectors of the flash have 8 KiB and are nearly full at the start. Every second run declares the
//! earth's field.
//!
//! [`Board`]: meerkat_mwd::application::Board

mod checks;
mod chip;
mod completed;
mod day;
mod host;
mod machine;
mod plan;
mod proportions;
mod tally;
mod truth;

pub use plan::{KINDS, Trouble};
pub use proportions::DAY_S;
pub use tally::{Tally, VIOLATIONS, Violation};

use checks::Round;
use chip::{Chip, ChipFlash, Death, Flash, SECTORS};
use completed::Completed;
use day::Day;
use host::{Host, KEY};
use machine::{Machine, PERIOD_US, WORDS};
use meerkat_mwd::{
    Config, Probe,
    application::{
        Acquisition, AcquisitionCounts, Application, Board, Burst, Commands, Line, Memory, SampleQueue, Settings,
        Statics,
    },
    compensation::effects::LIBRARY,
    config::Latency,
    emulation::{Conversions, ModelledParts, Recording, RecordingPlayer},
    storage::{Limits, ModelStore, NotDrilling, Preparation},
    survey::Surveyor,
    telemetry::{CounterStore, ResetReason, StreamConfig},
};
use proportions::{ATTACK, CALM, Proportions, WHOLE_DAY};
use std::{
    mem::MaybeUninit,
    panic::{AssertUnwindSafe, catch_unwind},
};
use testbed::simulate::Random;
use truth::{DIP_RAD, FIELD_UT, Truth};

/// Share of calm runs.
const CALM_RUNS: f64 = 0.25;
/// Time after which evidence of rest is none any more, and what is decided on it has been answered, seconds: a second
/// of the interlock, and a second for the answer.
const EVIDENCE_S: f64 = 2.0;
/// Time in which attitude has to be back after a start with sound sensors and without overload, microseconds.
const BACK_US: u64 = 3_000_000;
/// Bytes of this machine's stack that the program may take. Its frames are wider here than on the chip, whose limit is
/// 12 KiB (`tests/real_time` holds it there).
const STACK_BYTES: u64 = 24 * 1024;
/// Share of the times without power and without other damage in which the counter's latest copy is damaged.
const COUNTERS_DAMAGED: f64 = 0.2;
/// Length of a copy of the counter in flash, bytes.
const GRANULE: usize = 32;
/// Command counters that a sector takes.
const COUNTERS: u64 = 127;

/// Bytes of static memory that the program works on, as this machine lays them out: pipeline, line, commands, storage
/// and the queue of samples. It allocates nothing beside them.
#[must_use]
pub const fn static_bytes() -> usize {
    size_of::<Probe>()
        + size_of::<Surveyor>()
        + size_of::<Line>()
        + size_of::<Commands>()
        + size_of::<Memory<ChipFlash<'_>>>()
        + size_of::<SampleQueue>()
}

/// A run of one seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Counts.
    pub tally: Tally,
    /// Digest of every byte that the probe sent.
    pub digest: u64,
}

/// Flies a seed in compressed time.
///
/// # Errors
/// The probe cannot be started at all.
pub fn fly(seed: u64) -> anyhow::Result<Run> {
    caught(|| {
        let mut random = Random::new(seed);
        let proportions = if random.uniform() < CALM_RUNS { &CALM } else { &ATTACK };
        fly_to_the_end(seed, random, proportions, proportions.length_s)
    })
}

/// Flies the first so many seconds of a seed's day at real proportions.
///
/// # Errors
/// The probe cannot be started at all.
pub fn fly_day(seed: u64, length_s: f64) -> anyhow::Result<Run> {
    caught(|| fly_to_the_end(seed, Random::new(seed), &WHOLE_DAY, length_s.min(WHOLE_DAY.length_s)))
}

/// Counts a panic as a violation.
fn caught(fly: impl FnOnce() -> anyhow::Result<Run>) -> anyhow::Result<Run> {
    catch_unwind(AssertUnwindSafe(fly)).unwrap_or_else(|_| {
        let mut tally = Tally::default();
        tally.violated(Violation::Panic, String::new);
        Ok(Run { tally, digest: 0 })
    })
}

fn fly_to_the_end(
    seed: u64,
    mut random: Random,
    proportions: &'static Proportions,
    length_s: f64,
) -> anyhow::Result<Run> {
    let (settings, length_us) = (settings(proportions, seed.is_multiple_of(2)), (length_s * 1e6) as u64);
    let truth = Truth::new(random.split(), PERIOD_US as u32, proportions);
    let plan = plan::draw(&mut random, proportions, &truth.begins_s());
    let counter = random.between(1.0, 2.0 * COUNTERS as f64) as u64;
    let mut flash = used_flash(seed, counter, &settings.config)?;
    if random.uniform() < 0.5 {
        flash.correct_errors();
    }
    let chip = Chip::new(flash);
    let host = Host::new(random.split(), &settings, proportions.first_sequence, counter);
    let mut day = Day {
        proportions,
        random,
        // So that what else is drawn does not move.
        aimed: Random::new(!seed),
        truth,
        host,
        tally: Tally::default(),
        plan: plan.into(),
        struck: Vec::new(),
        bytes_per_s: settings.stream.bytes_per_s,
        watchdog_resets: 0,
        flown: Vec::new(),
        completed: Completed::default(),
        surveys: Vec::new(),
        digest: 0xcbf2_9ce4_8422_2325,
        back_us: [None; 2],
    };
    let mut reason = ResetReason::PowerOn;
    while chip.now_us.get() < length_us {
        let death = power_up(&chip, &mut day, (&settings, length_us), reason)?;
        day.tally.checked(Violation::Panic);
        reason = match death {
            Death::PowerCut => {
                without_power(&chip, &mut day);
                ResetReason::PowerOn
            }
            Death::Watchdog => {
                day.watchdog_resets += 1;
                ResetReason::Watchdog
            }
        };
    }
    let erasures = chip.flash.borrow().erases().iter().max().copied();
    day.tally.erasures = u64::from(erasures.unwrap_or(0));
    day.tally.frames = day.host.frames();
    Ok(Run { tally: day.tally, digest: day.digest })
}

fn settings(proportions: &Proportions, declares_its_field: bool) -> Settings {
    let mut config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    config.latency = Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) };
    if declares_its_field {
        (config.earth.magnetic_field_ut, config.earth.dip_rad) = (Some(FIELD_UT as f32), Some(DIP_RAD as f32));
    }
    if proportions.short_windows {
        (config.identification.window_s, config.identification.step_s) = (10.0, 5.0);
    }
    if proportions.short_surveys {
        (config.survey.settle_s, config.survey.average_s) = (1.0, 1.0);
    }
    let stream = StreamConfig { attitude_every: 10, ..StreamConfig::default() };
    Settings { config, stream, recording: false, key: Some(KEY) }
}

/// A flash in which so many commands were counted.
fn used_flash(seed: u64, counter: u64, config: &Config) -> anyhow::Result<Flash> {
    let failed = |error| anyhow::anyhow!("the flash cannot be made ready: {error:?}");
    let flash = Flash::new(SECTORS, seed);
    let mut store = ModelStore::<_, SECTORS>::open(flash, Limits::new(config, &LIBRARY)).map_err(failed)?;
    while store.prepare(NotDrilling::PowerUp).map_err(failed)? == Preparation::More {}
    for counter in 1..=counter {
        store.store_counter(counter).map_err(failed)?;
    }
    Ok(store.into_flash())
}

/// The probe from a start to its end.
fn power_up(
    chip: &Chip,
    day: &mut Day,
    (settings, length_us): (&Settings, u64),
    reason: ResetReason,
) -> anyhow::Result<Death> {
    chip.start();
    day.tally.starts += 1;
    day.back_us = [None; 2];
    let drilling = day.truth.drilling_for_s() > 0.0;
    let parts = ModelledParts::<WORDS>::new(Conversions::WithEverySample);
    let recording = Recording { inertial_us: PERIOD_US as u32, magnetic_us: PERIOD_US as u32 };
    let player = RecordingPlayer::new(&parts, recording);
    let counts = AcquisitionCounts::new();
    let mut queue = SampleQueue::new();
    let (producer, waiting) = queue.split();
    let mut place = MaybeUninit::uninit();
    let mut memory = Memory::start(&mut place, ChipFlash(chip), &settings.config, || chip.feed()).ok();
    if !chip.is_dead() {
        day.tally.checked(Violation::StorageRefused);
        match memory.as_mut().map(|memory| memory.read()) {
            Some(Ok(counter)) => day.host.counter_is(counter, &mut day.tally),
            _ => day.tally.violated(Violation::StorageRefused, String::new),
        }
    }
    let before = Round { erased: chip.erased_us.borrow().len(), ..Round::default() };
    let acquisition = (Acquisition::new(producer, &counts), waiting, &counts);
    let machine = Machine::new(chip, day, (&parts, player), acquisition, reason, checks::heard);
    let (mut probe, mut surveyor, mut burst) = (Box::new(Probe::new()), Surveyor::new(), Box::new(Burst::new()));
    let (mut line, mut commands) = (Line::new(), Commands::new());
    let statics = Statics {
        probe: &mut probe,
        surveyor: &mut surveyor,
        burst: &mut burst,
        line: &mut line,
        commands: &mut commands,
        memory,
    };
    let mut application = Application::start(machine, statics, settings)?;
    checks::configured(&mut application);
    chip.call_from_here();
    let death = live(&mut application, before, length_us);
    let results_lost = application.statics().line.results_lost();
    let machine = application.board();
    let acquisition = machine.acquisition();
    let (samples, lost) = (acquisition.acquired(), acquisition.queue_full());
    let hangs = machine.hangs();
    let sound = machine.unsound_us.is_none() && !machine.line_stood_still();
    let ran_us = chip.now_us.get() - chip.started_us.get();
    let tally = &mut day.tally;
    tally.now_us = chip.now_us.get();
    tally.longest_us = tally.longest_us.max(ran_us);
    tally.samples += u64::from(samples);
    tally.lost += u64::from(lost);
    tally.results_lost += u64::from(results_lost);
    tally.stack = tally.stack.max(chip.stack_bytes());
    tally.checked(Violation::Ram);
    if chip.stack_bytes() > STACK_BYTES {
        tally.violated(Violation::Ram, || format!("{} bytes of stack", chip.stack_bytes()));
    }
    tally.checked(Violation::WatchdogReset);
    if death == Death::Watchdog && !hangs {
        tally.violated(Violation::WatchdogReset, || "no stage hung".to_owned());
    }
    let after_s = |at_us: u64| (at_us - chip.started_us.get()) as f64 * 1e-6;
    if sound {
        let [any, unflagged] = day.back_us.map(|at_us| at_us.map(after_s));
        tally.back_s[usize::from(drilling)].extend(any);
        tally.back_s[2].extend(unflagged);
        let until_back_us = chip.started_us.get()..chip.started_us.get() + BACK_US;
        let is_delaying = |(at_us, it): &(u64, Trouble)| {
            matches!(it, Trouble::Overload(..) | Trouble::LineStall(_)) && until_back_us.contains(at_us)
        };
        if ran_us > BACK_US && !hangs && !day.struck.iter().any(is_delaying) {
            tally.checked(Violation::Silent);
            if any.is_none_or(|after_s| after_s > BACK_US as f64 * 1e-6) {
                tally.violated(Violation::Silent, || format!("started at {} us", chip.started_us.get()));
            }
        }
    }
    Ok(death)
}

/// The program's loop, until its end or that of the day.
fn live<'c>(application: &mut Application<'_, Machine<'c, '_>>, mut round: Round, length_us: u64) -> Death {
    loop {
        application.turn();
        checks::after_round(application, &mut round);
        let chip = application.board().chip;
        if let Some(death) = chip.death.get() {
            return death;
        }
        if chip.now_us.get() >= length_us {
            return Death::PowerCut;
        }
    }
}

/// The tool goes on while the probe has no power, and the flash may suffer: one damage from start to start.
fn without_power(chip: &Chip, day: &mut Day) {
    day.watchdog_resets = 0;
    let [low, high] = day.proportions.unpowered_s.map(|s| s * 1e6 / PERIOD_US as f64);
    let periods = day.random.between(low, high) as u64;
    for _ in 0..periods {
        day.truth.step();
    }
    chip.now_us.set(chip.now_us.get() + periods * PERIOD_US);
    let mut flash = chip.flash.borrow_mut();
    let was_in_flash = !flash.is_on();
    let draw = day.random.uniform();
    let trouble = if was_in_flash && !flash.is_readable(flash.last_touched()) {
        Some(Trouble::UnreadableTorn)
    } else if was_in_flash && draw < 0.5 {
        let (at, bit) = (flash.last_touched() + day.random.between(0.0, 4.0) as usize, day.random.between(0.0, 8.0));
        flash.make_marginal(at, bit as u8);
        Some(Trouble::MarginalBit)
    } else if !was_in_flash && draw < 0.5 {
        // Near what was written last, for most of the rest is erased.
        let back = day.random.between(0.0, 300.0) as usize;
        let at = flash.last_touched().saturating_sub(back);
        damage(&mut flash, at, &mut day.random);
        Some(if flash.corrects() { Trouble::UnreadableRotten } else { Trouble::BitRot })
    } else if !was_in_flash
        && day.aimed.uniform() < COUNTERS_DAMAGED
        && let Some(at) = chip.counter_at.get()
    {
        damage(&mut flash, at + day.aimed.index(GRANULE), &mut day.aimed);
        Some(Trouble::CounterRotten)
    } else {
        None
    };
    if let Some(trouble) = trouble {
        if trouble != Trouble::CounterRotten {
            day.host.flash_is_spoilt();
        }
        day.tally.troubles[trouble.kind()] += 1;
    }
}

/// A word of the flash cannot be read any more, where error correction gives up on it; else one of its bits changes.
fn damage(flash: &mut Flash, at: usize, random: &mut Random) {
    if flash.corrects() {
        flash.make_unreadable(at);
    } else {
        flash.bytes_mut()[at] ^= 1 << random.between(0.0, 8.0) as u8;
    }
}
