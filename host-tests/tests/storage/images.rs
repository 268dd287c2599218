//! An update of the program: the power goes at every word and every erasure of it, and one whole image is started.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use meerkat_mwd::{
    application::{ProgramUpdate, Updater},
    storage::{Image, ImageSlots, Slot, Start, StorageError},
    telemetry::{CommandRefusal, ImagePart},
};
use mock_flash::MockError;
use mwd::power_cuts::images::{
    CHUNK, Region, cut_everywhere, from_the_factory, image, programs, received, slots, started, update,
};

#[test]
fn an_update_is_tried_once_and_stays_if_it_is_confirmed() {
    let mut slots = slots(from_the_factory());
    assert_eq!(started(&mut slots), Some((Start::Confirmed(Slot::First), 0)));
    update(&mut slots, Slot::First, 2, &programs()[1]).unwrap();
    assert_eq!(started(&mut slots), Some((Start::Trial(Slot::Second), 1)));
    slots.confirm(Slot::Second).unwrap();
    slots.confirm(Slot::Second).unwrap();
    assert_eq!(started(&mut slots), Some((Start::Confirmed(Slot::Second), 1)));
    // The program that ran before is still there if the new one rots.
    let rotten = slots.address(Slot::Second) as usize + 700;
    slots.flash_mut().bytes_mut()[rotten] ^= 4;
    assert_eq!(started(&mut slots), Some((Start::Confirmed(Slot::First), 0)));
}

#[test]
fn an_update_that_is_not_confirmed_is_rolled_back_and_can_be_sent_again() {
    let mut slots = slots(from_the_factory());
    for number in 2..5 {
        update(&mut slots, Slot::First, number, &programs()[1]).unwrap();
        assert_eq!(started(&mut slots), Some((Start::Trial(Slot::Second), 1)));
        for _ in 0..3 {
            assert_eq!(started(&mut slots), Some((Start::Confirmed(Slot::First), 0)), "its watchdog bit");
        }
    }
    let old = slots.begin(Slot::First, image(4, &programs()[1])).map(drop);
    assert_eq!(old, Err(StorageError::CounterGoesBack { stored: 4 }));
}

/// A third image cannot replace the one that is confirmed while the second is on trial: if that one hung, nothing would
/// be left to start.
#[test]
fn while_an_image_is_on_trial_the_confirmed_one_stays() {
    let mut slots = slots(from_the_factory());
    let [old, new] = programs();
    update(&mut slots, Slot::First, 2, &new).unwrap();
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::Second)));
    assert_eq!(slots.begin(Slot::Second, image(3, &old)).map(drop), Err(StorageError::Busy));
    let lower = slots.begin(Slot::Second, image(2, &old)).map(drop);
    assert_eq!(lower, Err(StorageError::CounterGoesBack { stored: 2 }), "no wait helps that");
    slots.confirm(Slot::Second).unwrap();
    assert_eq!(update(&mut slots, Slot::Second, 3, &old), Ok(()));
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::First)));
}

/// The same by the receiver of a program: what a probe on trial is receiving is not dropped by an announcement that is
/// refused, and a flash that does not take a part is told as that.
#[test]
fn a_refused_announcement_drops_nothing() {
    let mut slots = slots(from_the_factory());
    let [old, new] = programs();
    update(&mut slots, Slot::First, 2, &new).unwrap();
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::Second)));
    let mut updater = Updater::new(slots, Slot::Second);
    assert_eq!(updater.begin(&image(3, &old)), Err(CommandRefusal::Busy));
    assert!(updater.confirm());
    assert_eq!(updater.begin(&image(3, &old)), Ok(()));
    assert_eq!(updater.part(&ImagePart { offset: 0, bytes: &old[..CHUNK] }), Err(CommandRefusal::Busy), "not erased");
    (0..64).for_each(|_| updater.erase_next());
    assert_eq!(updater.part(&ImagePart { offset: 0, bytes: &old[..CHUNK] }), Ok(()));
    assert_eq!(updater.begin(&image(3, &[])), Err(CommandRefusal::ImageSize));
    assert_eq!(updater.report().received, Some(CHUNK as u32));
    let nothing = updater.part(&ImagePart { offset: CHUNK as u32, bytes: &[] });
    assert_eq!(nothing, Err(CommandRefusal::NotTheNext { expected: CHUNK as u32 }), "no bytes are no progress");
}

/// Flash that says that it has programmed a word, and has not.
struct Deaf(Region);

impl ErrorType for Deaf {
    type Error = MockError;
}

impl ReadNorFlash for Deaf {
    const READ_SIZE: usize = <Region as ReadNorFlash>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for Deaf {
    const WRITE_SIZE: usize = <Region as NorFlash>::WRITE_SIZE;
    const ERASE_SIZE: usize = <Region as NorFlash>::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        self.0.erase(from, to)
    }

    fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), MockError> {
        Ok(())
    }
}

#[test]
fn a_flash_that_does_not_take_a_part_is_told_as_that() {
    let slots = ImageSlots::new(Deaf(from_the_factory())).unwrap();
    let [_, new] = programs();
    let mut updater = Updater::new(slots, Slot::First);
    assert_eq!(updater.begin(&image(2, &new)), Ok(()));
    (0..64).for_each(|_| updater.erase_next());
    let refused = updater.part(&ImagePart { offset: 0, bytes: &new[..CHUNK] });
    assert_eq!(refused, Err(CommandRefusal::StorageFailed));
}

#[test]
fn what_is_not_the_image_that_was_announced_is_not_started() {
    let mut slots = slots(from_the_factory());
    let [old, new] = programs();
    let longest = slots.longest();
    for length in [0, longest + 1] {
        assert_eq!(slots.begin(Slot::First, Image { length, ..image(2, &new) }).map(drop), Err(StorageError::Full));
    }
    // Other bytes, too few, and in another order.
    let mut receiving = slots.begin(Slot::First, Image { length: new.len() as u32, ..image(2, &old) }).unwrap();
    assert_eq!(
        slots.write(&mut receiving, 0, &new[..CHUNK]),
        Err(StorageError::NotTheNext { expected: 0 }),
        "not erased"
    );
    received(&mut slots, &mut receiving, &new).unwrap();
    assert_eq!(slots.finish(receiving), Err(StorageError::NotVerified));
    let mut receiving = slots.begin(Slot::First, image(2, &new)).unwrap();
    while !slots.erase_next(&mut receiving).unwrap() {}
    slots.write(&mut receiving, 0, &new[..CHUNK]).unwrap();
    for offset in [0, 2 * CHUNK as u32] {
        let refused = slots.write(&mut receiving, offset, &new[..CHUNK]);
        assert_eq!(refused, Err(StorageError::NotTheNext { expected: CHUNK as u32 }));
    }
    assert!(slots.finish(receiving).is_err());
    assert_eq!(started(&mut slots), Some((Start::Confirmed(Slot::First), 0)));
    assert_eq!(slots.confirm(Slot::Second), Err(StorageError::NotVerified));
}

/// After any cut a start takes the old program or the new one, whole; a trial that was cut off is not repeated; and the
/// update can be done again.
#[test]
fn a_cut_at_every_word_and_every_erasure_leaves_a_whole_image() {
    let left = cut_everywhere();
    println!("{} words and erasures: {:?}", left.operations, left.starts());
    assert_eq!((left.starts().lost, &left.first), (0, &None));
    assert!(left.starts().old > 0 && left.starts().new > 0);
}

/// The first image of a new probe, before anything was confirmed.
#[test]
fn an_image_without_another_is_started_even_if_it_was_never_confirmed() {
    let mut slots = slots(Region::new(4, 9));
    assert_eq!(slots.choose(), None);
    update(&mut slots, Slot::Second, 1, &programs()[0]).unwrap();
    assert_eq!(slots.choose(), Some(Start::Trial(Slot::First)));
    assert_eq!(slots.choose(), Some(Start::LastResort(Slot::First)));
}
