//! Stored models end to end: a file is the flash, and power is cut while it is written.

use super::{
    drilling::{LIMIT, drilling, everything, missing_of},
    received::Received,
};
use crate::rig::emulator::toolchain;
use meerkat_mwd::{
    compensation::effects::LIBRARY,
    storage::{Limits, ModelStore, Outcome},
    telemetry::{Boot, ResetReason},
};
use mock_flash::MockFlash;
use mwd::target::{
    deadline::CommandError,
    error::EmulateError,
    firmware::{Board, Firmware, build_firmware},
    real_time::{RealTime, Stage},
    toolchain::Toolchain,
};
use std::{fs, path::Path};
use testbed::{flight, trace::Trace};

const FLASH_BYTES: usize = 3 * 16 * 1024;
/// Long enough for three windows of 25 s that agree.
const LONG_S: f64 = 110.0;

struct Probe {
    toolchain: Toolchain,
    firmware: Firmware,
    directory: tempfile::TempDir,
}

impl Probe {
    fn new() -> Option<Self> {
        let toolchain = toolchain()?;
        let firmware = build_firmware(&toolchain, Board::Emulated).unwrap();
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("flash.bin"), vec![0xFF; FLASH_BYTES]).unwrap();
        Some(Self { toolchain, firmware, directory })
    }

    fn path(&self) -> &Path {
        self.directory.path()
    }

    fn flash(&self) -> Vec<u8> {
        fs::read(self.path().join("flash.bin")).unwrap()
    }

    fn set_flash(&self, bytes: &[u8]) {
        fs::write(self.path().join("flash.bin"), bytes).unwrap();
    }

    /// Drills; `None` if the power was cut.
    fn drill(&self, duration_s: f64, seed: u64, how: RealTime) -> Option<(Received, u64)> {
        let (mut config, samples) = drilling(duration_s, seed);
        config.identification.window_s = 25.0;
        let run = RealTime { config, ..how };
        run.prepare_in(self.path(), &self.firmware, &samples).unwrap();
        match run.run_in(self.path(), &self.toolchain, LIMIT) {
            Ok(landed) => {
                assert_eq!(landed.count("storage_failures"), Some(0));
                Some((Received::of(&landed.serial), landed.count("models_stored").unwrap()))
            }
            Err(EmulateError::Run(CommandError::Failed { status, .. })) if status.code() == Some(3) => None,
            Err(error) => panic!("{error}"),
        }
    }

    /// Report of the start after power-up.
    fn boot(&self) -> Boot {
        let (received, _) = self.drill(2.0, 1, RealTime::default()).unwrap();
        received.boots[0]
    }
}

#[test]
fn a_stable_model_is_stored_and_flies_after_power_up_and_after_a_hang() {
    let Some(probe) = Probe::new() else { return };
    let (received, stored) = probe.drill(LONG_S, 1, RealTime::default()).unwrap();
    assert_eq!(received.boots[0].restored_model, None);
    assert_eq!(stored, 1, "{:?}", received.identifications);
    let number = probe.boot().restored_model;
    assert!(number.is_some());

    let hang = Some((Stage::Work, 200));
    let (received, _) = probe.drill(5.0, 1, RealTime { hang, ..RealTime::default() }).unwrap();
    let boots: Vec<_> = received.boots.iter().map(|boot| (boot.reset, boot.restored_model)).collect();
    assert_eq!(boots, [(ResetReason::PowerOn, number), (ResetReason::Watchdog, number)]);
}

#[test]
fn a_filter_that_goes_on_after_power_up_gives_what_it_gives_on_the_host() {
    let Some(probe) = Probe::new() else { return };
    let (_, stored) = probe.drill(LONG_S, 1, RealTime::default()).unwrap();
    assert_eq!(stored, 1);
    let mut flash = MockFlash::<4, { 16 * 1024 }>::new(3, 0);
    flash.bytes_mut().copy_from_slice(&probe.flash());

    let (mut config, samples) = drilling(40.0, 2);
    config.identification.window_s = 25.0;
    let mut store = ModelStore::<_, 3>::open(flash, Limits::new(&config, &LIBRARY)).unwrap();
    let Outcome::Chosen { model, number, .. } = store.restore(None).unwrap().outcome else { panic!("no model") };
    let head = store.learnt_with(number).unwrap().expect("what the filter had learnt");
    assert!(head.motion_s > 50.0, "{head:?}");
    let begun = |goes_on| {
        let mut begun = flight::started(&config, None, Some(&model)).unwrap();
        if goes_on {
            let read = |take: &mut dyn FnMut(usize, f32)| store.clone().read_learnt(number, take).unwrap();
            assert_eq!(begun.go_on(&head, read), Ok(()));
        }
        begun
    };
    let run = RealTime { config, stream: everything(), recording: true, ..RealTime::default() };
    let through = run.through_sensors(&samples);
    let through = Trace { samples: through, ..Trace::default() };
    let host = |goes_on| flight::fly_on(begun(goes_on), &through, |_| ()).outputs;
    let (received, _) =
        probe.drill(40.0, 2, RealTime { stream: everything(), recording: true, ..RealTime::default() }).unwrap();
    assert!(received.is_whole() && received.outputs.len() > 7_900);
    assert_eq!(received.boots[0].goes_on_after_s, Some(head.motion_s));
    assert!(missing_of(&host(true), &received.outputs) <= 10);
    assert!(host(true) != host(false), "it makes no difference");
}

#[test]
fn a_power_cut_while_the_flash_is_prepared_costs_nothing() {
    let Some(probe) = Probe::new() else { return };
    for cut in 0..12 {
        probe.set_flash(&[0xFF; FLASH_BYTES]);
        let how = RealTime { power_cut_after: Some(cut), ..RealTime::default() };
        let was_cut = probe.drill(2.0, 1, how).is_none();
        // It starts, and says that there is no model.
        assert_eq!(probe.boot().restored_model, None, "cut after {cut}");
        assert!(was_cut || cut > 3, "nothing was written");
    }
}

/// A model and what was learnt with it take more words than this.
const HEAD_WORDS: u32 = LEARNT_WORDS + 32;
/// Words of what the filter has learnt, which come first: four parts of 640 bytes and one of 576.
const LEARNT_WORDS: u32 = (4 * 640 + 576) / 4;

/// Cuts the power at each of these words of a second model, and checks what flies then.
fn cut_the_second_model(words: impl Iterator<Item = u32>) {
    let Some(probe) = Probe::new() else { return };
    let (_, stored) = probe.drill(LONG_S, 1, RealTime::default()).unwrap();
    assert_eq!(stored, 1);
    let (first, number) = (probe.flash(), probe.boot().restored_model.unwrap());
    let mut outcomes = Vec::new();
    for cut in words {
        probe.set_flash(&first);
        let how = RealTime { power_cut_after: Some(cut), ..RealTime::default() };
        let was_cut = probe.drill(LONG_S, 3, how).is_none();
        let flies = probe.boot().restored_model;
        outcomes.push((cut, was_cut, flies));
    }
    println!("model {number} first; words before the cut, whether it came, what flies then: {outcomes:?}");
    // Either the first or the whole second model flies; from the word that completes it, the second.
    let second = |flies: &Option<u32>| {
        if *flies == Some(number) { Some(false) } else { (*flies == Some(number + 1)).then_some(true) }
    };
    let seconds: Vec<bool> = outcomes.iter().map(|(.., flies)| second(flies).unwrap()).collect();
    assert!(seconds.is_sorted() && !seconds[0], "{outcomes:?}");
    assert!(outcomes.iter().all(|(cut, was_cut, flies)| *cut >= HEAD_WORDS || *was_cut && *flies == Some(number)));
    assert!(
        outcomes.iter().any(|(_, was_cut, flies)| !was_cut && *flies == Some(number + 1)),
        "never whole: {outcomes:?}"
    );
}

#[test]
fn a_power_cut_while_a_model_is_written_leaves_the_one_before() {
    cut_the_second_model([0, 17, 400, LEARNT_WORDS, LEARNT_WORDS + 17, 4_000].into_iter());
}

#[test]
#[ignore = "every word of a model: a quarter of an hour"]
fn a_power_cut_at_every_word_of_a_model_leaves_the_one_before() {
    cut_the_second_model((LEARNT_WORDS..LEARNT_WORDS + 48).chain([4_000]));
}
