//! Another program, over the emulator's serial line into the probe: tried, confirmed or rolled back, with the power cut
//! in the middle.

use super::live::{KEY, LiveProbe};
use blake2::{Blake2s256, Digest};
use meerkat_mwd::{
    Config, Sample,
    storage::{Image, ImageSlots, Slot, Start},
    telemetry::{Command, CommandRefusal, ImagePart, Message, Outcome, ProgramReport},
};
use mock_flash::MockFlash;
use mwd::target::{image, real_time::RealTime};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{fs, time::Instant};

/// Blocks of the two slots together, and their size.
const PAGES: usize = 32;
const BLOCK: usize = 64 * 1024;
type Region = MockFlash<4, BLOCK>;

/// Longer than any of it takes.
const RUN_S: usize = 7_200;

/// A program in two instructions, too small to be of use.
#[derive(Clone, Copy)]
enum Small {
    /// A branch to itself.
    Hangs,
    /// An undefined instruction.
    Faults,
    /// Nothing of it is a program.
    Noise,
}

/// Bytes of a small program, where programs of the MPS2 are linked (`src/bin/probe/mps2.x`).
fn small(kind: Small) -> Vec<u8> {
    const START: u32 = 0x1_0000;
    const VECTORS: u32 = 16;
    let mut bytes: Vec<u8> = (0..1_996_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let hang = START + 4 * VECTORS;
    let reset = match kind {
        Small::Hangs => hang,
        Small::Faults => hang + 2,
        Small::Noise => return bytes,
    };
    let handlers = (2..VECTORS).map(|_| hang | 1);
    let table = [0x2004_0000, reset | 1].into_iter().chain(handlers).flat_map(u32::to_le_bytes);
    // A branch to itself, and what the architecture keeps undefined (Armv7-M ARM, A7.7.12 and A7.7.194).
    let code = [0xE7FE_u16, 0xDE00].into_iter().flat_map(u16::to_le_bytes);
    bytes.iter_mut().zip(table.chain(code)).for_each(|(to, from)| *to = from);
    bytes
}

fn image(number: u32, bytes: &[u8]) -> Image {
    Image { number, length: bytes.len() as u32, digest: Blake2s256::digest(bytes).into() }
}

/// The two slots, and an image written beside the one that runs and not tried yet.
fn with(slots: &mut ImageSlots<Region>, running: Slot, number: u32, program: &[u8]) {
    let mut receiving = slots.begin(running, image(number, program)).unwrap();
    while !slots.erase_next(&mut receiving).unwrap() {}
    slots.write(&mut receiving, 0, program).unwrap();
    slots.finish(receiving).unwrap();
}

/// The flash of a probe that the factory gave one program, with number 1.
fn from_the_factory(program: &[u8]) -> ImageSlots<Region> {
    let mut slots = ImageSlots::new(Region::new(PAGES, 26)).unwrap();
    with(&mut slots, Slot::Second, 1, program);
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::First)));
    slots.confirm(Slot::First).unwrap();
    slots
}

/// Readings of a tool that stands still, with the noise that tells a live sensor from a dead one.
fn at_rest(count: usize) -> Vec<Sample> {
    let mut noise = Xoshiro128PlusPlus::seed_from_u64(26);
    let mut near = |value: f32, by: f32| value + by * (noise.next_u32() as f32 / u32::MAX as f32 - 0.5);
    let sample = |_| Sample {
        gyro_rad_s: [0.0; 3].map(|value| near(value, 0.003)),
        accel_m_s2: [4.0, 1.0, -8.9].map(|value| near(value, 0.03)),
        mag_ut: [20.0, 1.0, 45.0].map(|value| near(value, 0.3)),
        temperature_c: 60.0,
        ..Sample::default()
    };
    (0..count).map(sample).collect()
}

/// A probe that stands still, with its first program.
struct Updated {
    probe: LiveProbe,
    run: RealTime,
    samples: Vec<Sample>,
    program: Vec<u8>,
}

impl Updated {
    fn new() -> Option<Self> {
        let probe = LiveProbe::updatable()?;
        let program = image::Image::parse(probe.elf()).unwrap().loaded().unwrap();
        fs::write(probe.at("probe.key"), KEY.map(|byte| format!("{byte:02x}")).concat()).unwrap();
        // Between the samples, which are few, the emulator takes the line's bytes.
        let config = Config { sample_period_us: 20_000, ..Config::default() };
        let run = RealTime { by_loader: true, key: Some(KEY), config, ..RealTime::default() };
        let samples = at_rest(RUN_S * 1_000_000 / run.config.sample_period_us as usize);
        Some(Self { probe, run, samples, program })
    }

    /// The program as good as before, and other bytes behind its end.
    fn successor(&self) -> Vec<u8> {
        [&self.program[..], &[26; 36]].concat()
    }

    fn write(&self, slots: ImageSlots<Region>) {
        fs::write(self.probe.at("images.bin"), slots.into_flash().bytes_mut()).unwrap();
    }

    /// Powers up; after so many words and pages of the images' flash the power goes.
    fn power_up(&mut self, cut_after: Option<u32>) {
        let cut = self.probe.at("cut.bin");
        match cut_after {
            Some(words) => fs::write(cut, words.to_le_bytes()).unwrap(),
            None => drop(fs::remove_file(cut)),
        }
        self.probe.power_up(&self.run, &self.samples);
    }

    /// Sends a program by `mwd update`; returns its exit status and what it said.
    fn update(&self, number: u32, program: &[u8]) -> (i32, String) {
        let file = self.probe.at("new.bin");
        fs::write(&file, program).unwrap();
        let (number, key) = (number.to_string(), self.probe.at("probe.key"));
        let started = Instant::now();
        let all = ["update", "--deadline", "300", "--image", &file, "--number", &number, "--key", &key];
        let (status, said) = self.probe.mwd(&all);
        println!("{status} after {:.1} s: {}", started.elapsed().as_secs_f32(), said.trim().replace('\n', "; "));
        (status, said)
    }

    /// Report of the probe on the program that it runs.
    fn runs(&self) -> ProgramReport {
        self.probe.host().until("its program", |message| match message {
            Message::Program(report) => Some(*report),
            _ => None,
        })
    }
}

/// Report of a probe that runs a confirmed program.
const fn settled(number: u32, other: Option<u32>) -> ProgramReport {
    ProgramReport { number, confirmed: true, other, received: None }
}

#[test]
fn a_program_sent_over_the_line_is_tried_confirmed_and_stays() {
    let Some(mut updated) = Updated::new() else { return };
    updated.write(from_the_factory(&updated.program));
    updated.power_up(None);
    assert_eq!(updated.runs(), settled(1, None));
    // Nobody without the key gets as far as to send a byte.
    let begin = Command::BeginUpdate { number: 2, length: 100, digest: [7; 32] };
    let refused = updated.probe.host().plain(&begin);
    assert_eq!(refused, Outcome::Refused(CommandRefusal::NotAuthenticated));
    let (status, said) = updated.update(2, &updated.successor());
    assert!(status == 0 && said.contains("has confirmed itself"), "{said}");
    assert_eq!(updated.runs(), settled(2, Some(1)));
    updated.power_up(None);
    assert_eq!(updated.runs(), settled(2, Some(1)), "after a loss of power, too");
    let (status, said) = updated.update(1, &updated.program);
    assert!(status == 2 && said.contains("takes none with a lower number"), "{said}");
}

#[test]
fn a_program_that_does_not_feed_the_watchdog_is_rolled_back() {
    let Some(mut updated) = Updated::new() else { return };
    updated.write(from_the_factory(&updated.program));
    updated.power_up(None);
    for (number, kind) in [(2, Small::Hangs), (3, Small::Faults), (4, Small::Noise)] {
        let (status, said) = updated.update(number, &small(kind));
        assert!(status == 2 && said.contains("went back to 1"), "{said}");
        assert_eq!(updated.runs(), settled(1, Some(number)));
    }
    updated.power_up(None);
    assert_eq!(updated.runs(), settled(1, Some(4)), "after a loss of power, too");
}

/// Changes of the flash in an update by a small program: erased pages, words of the image, of its mark and of the
/// trial's.
struct Steps {
    pages: u32,
    words: u32,
}

impl Steps {
    const MARK: u32 = 16;
    const TRIAL: u32 = 8;

    fn marks(&self) -> u32 {
        self.pages + self.words
    }
}

/// Cuts the power in the given changes of an update, each time of a fresh probe. Afterwards the first program runs,
/// whole; and the same update, sent again, ends as if nothing had happened.
fn cut(chosen: impl Fn(&Steps) -> Vec<u32>) {
    let Some(mut updated) = Updated::new() else { return };
    let program = small(Small::Hangs);
    let steps = Steps { pages: PAGES as u32 / 2, words: program.len().div_ceil(32) as u32 * 8 };
    for step in chosen(&steps) {
        updated.write(from_the_factory(&updated.program));
        updated.power_up(Some(step));
        let (status, said) = updated.update(2, &program);
        assert_eq!(status, 3, "{step}: the line ends: {said}");
        assert_eq!(updated.probe.ended(), Some(3), "{step}: the power was cut");
        updated.power_up(None);
        let runs = updated.runs();
        assert!(runs.number == 1 && runs.confirmed, "{step}: {runs:?}");
        let (status, said) = updated.update(2, &program);
        assert!(status == 2 && said.contains("went back to 1"), "{step}: {said}");
        assert_eq!(updated.runs(), settled(1, Some(2)), "{step}: it is there, whole, and was tried");
    }
}

/// Cuts the power in the given words of the trial's mark and the confirmation's. Afterwards the old program runs or the
/// new one, whole, and a trial is not repeated.
fn cut_in_trial(words: impl Iterator<Item = u32>) {
    let Some(mut updated) = Updated::new() else { return };
    for word in words {
        let mut slots = from_the_factory(&updated.program);
        with(&mut slots, Slot::First, 2, &updated.successor());
        updated.write(slots);
        updated.power_up(Some(word));
        // It says nothing of interest until the power goes.
        let mut host = updated.probe.host();
        while host.is_there() {}
        assert_eq!(updated.probe.ended(), Some(3), "{word}: the power was cut");
        updated.power_up(None);
        let first = updated.runs();
        updated.power_up(None);
        let second = updated.runs();
        println!("word {word}: {first:?}, then {second:?}");
        assert!(first == settled(1, Some(2)) || first.number == 2, "{word}: {first:?}");
        let stays = first.number == 1 || first.confirmed;
        let expected = if stays { first.number } else { 1 };
        assert_eq!(second.number, expected, "{word}: {first:?}");
        assert!(second.confirmed, "{word}: {second:?}");
    }
}

#[test]
#[ignore = "each cut sends the whole program twice: minutes"]
fn an_update_that_loses_power_is_repeated() {
    // A page, a word of the image, of its mark, of the trial's.
    cut(|steps| vec![5, steps.pages + steps.words / 2, steps.marks() + 9, steps.marks() + Steps::MARK + 3]);
}

#[test]
fn a_trial_that_loses_power_is_not_repeated() {
    cut_in_trial([3, Steps::TRIAL + 5].into_iter());
}

#[test]
#[ignore = "each cut takes some seconds"]
fn an_update_that_loses_power_at_any_step_is_repeated() {
    // Each page, one word in each part of the image, each word of the marks.
    cut(|steps| {
        let parts = (3..steps.words).step_by(ImagePart::BYTES / 4).map(|word| steps.pages + word);
        let marks = steps.marks()..steps.marks() + Steps::MARK + Steps::TRIAL;
        (0..steps.pages).chain(parts).chain(marks).collect()
    });
    cut_in_trial(0..2 * Steps::TRIAL);
}
