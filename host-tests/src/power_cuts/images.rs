//! Cuts of an update of the program: its erasures, its parts, its trial and its confirmation.

use super::{Found, Left, drawn::Dice, everywhere, itself};
use blake2::{Blake2s256, Digest};
use meerkat_mwd::storage::{Image, ImageSlots, Receiving, Slot, Start, StorageError};
use mock_flash::{MockError, MockFlash};

/// Flash with room for two programs.
pub type Region = MockFlash<4, 1_024>;
/// Bytes of a frame's worth of image.
pub const CHUNK: usize = 256;

/// The slots of a region.
#[must_use]
pub fn slots(region: Region) -> ImageSlots<Region> {
    ImageSlots::new(region).unwrap()
}

/// Announcement of an image.
#[must_use]
pub fn image(number: u32, bytes: &[u8]) -> Image {
    let digest = Blake2s256::digest(bytes).as_slice().try_into().unwrap();
    Image { number, length: bytes.len() as u32, digest }
}

/// Two programs that differ in nearly every byte and in length.
#[must_use]
pub fn programs() -> [Vec<u8>; 2] {
    let mut dice = Dice::new(26);
    [1_500, 1_333].map(|length| (0..length).map(|_| dice.below(256) as u8).collect())
}

/// Erases what has to be, and takes all parts.
///
/// # Errors
/// The flash failed.
pub fn received(
    slots: &mut ImageSlots<Region>,
    receiving: &mut Receiving,
    bytes: &[u8],
) -> Result<(), StorageError<MockError>> {
    while !slots.erase_next(receiving)? {}
    for chunk in bytes.chunks(CHUNK) {
        slots.write(receiving, receiving.received(), chunk)?;
    }
    Ok(())
}

/// An update from its first erasure to its mark.
///
/// # Errors
/// The flash failed.
pub fn update(
    slots: &mut ImageSlots<Region>,
    running: Slot,
    number: u32,
    bytes: &[u8],
) -> Result<(), StorageError<MockError>> {
    let mut receiving = slots.begin(running, image(number, bytes))?;
    received(slots, &mut receiving, bytes)?;
    slots.finish(receiving)
}

/// A probe with the first program, as the factory leaves it.
#[must_use]
pub fn from_the_factory() -> Region {
    let mut slots = slots(Region::new(4, 3));
    update(&mut slots, Slot::Second, 1, &programs()[0]).unwrap();
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::First)));
    slots.confirm(Slot::First).unwrap();
    slots.into_flash()
}

/// The program that a start takes, if it is one of the two, and whole to the byte.
pub fn started(slots: &mut ImageSlots<Region>) -> Option<(Start, usize)> {
    let start = slots.choose()?;
    let from = slots.address(start.slot()) as usize;
    let there = slots.flash_mut().bytes_mut().get(from..)?;
    let program = programs().iter().position(|program| there.starts_with(program))?;
    Some((start, program))
}

/// Cuts an update everywhere. A start after a cut takes one of the two programs; a trial that was cut off is not
/// repeated; and the update can be done again.
#[must_use]
pub fn cut_everywhere() -> Left {
    let mut left = Left::default();
    let act = |region: &mut Region| {
        let [_, new] = programs();
        let mut slots = slots(region.clone());
        let is_done = update(&mut slots, Slot::First, 2, &new).is_ok()
            && slots.choose() == Some(Start::Trial(Slot::Second))
            && slots.confirm(Slot::Second).is_ok();
        *region = slots.into_flash();
        is_done
    };
    let found = |mut region: Region| {
        region.power_up();
        after_a_cut(&mut slots(region)).unwrap_or(Found::Neither)
    };
    everywhere(&mut left, &from_the_factory(), itself, act, found);
    left
}

/// `None` if a start takes no whole program, repeats a trial, or the update cannot be done again.
fn after_a_cut(slots: &mut ImageSlots<Region>) -> Option<Found> {
    let (first, program) = started(slots)?;
    // Nothing confirms it: from the second start on it is what was confirmed, and stays it.
    let (second, settled) = started(slots)?;
    let stays = matches!(second, Start::Confirmed(_)) && started(slots)? == (second, settled);
    let is_rolled_back = !matches!(first, Start::Trial(_)) || (program, settled) == (1, 0);
    if settled == 0 {
        update(slots, second.slot(), 3, &programs()[1]).ok()?;
        if started(slots)? != (Start::Trial(Slot::Second), 1) {
            return None;
        }
        slots.confirm(Slot::Second).ok()?;
    }
    let is_done = started(slots)? == (Start::Confirmed(Slot::Second), 1);
    (stays && is_rolled_back && is_done).then_some([Found::Old, Found::New][program])
}
