//! The store on an external NOR flash: the driver `w25q32jv` over SPI, and the part as its data sheet describes it
//! (Winbond W25Q32JV, sections 8.1 and 8.2): pages of 256 bytes that wrap, sectors of 4 KiB, a write enable before each
//! change.

use super::models::{Dice, KIB, limits};
use embedded_hal::{
    digital::{self, OutputPin},
    spi::{self, Operation, SpiDevice},
};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use meerkat_mwd::storage::{
    ModelStore, NotDrilling, Outcome, PolledError, PolledFlash, Preparation, StorageError, StoredModel,
};
use std::{cell::RefCell, convert::Infallible, future::poll_fn, rc::Rc, task::Poll};
use w25q32jv::{Error, W25q32jv};

const PAGE: usize = 256;
const SECTOR: usize = 4 * KIB;
/// The part of the flash that is modelled; the store takes 48 KiB from the start.
const BYTES: usize = 64 * KIB;

/// The part on its bus. After a power cut nothing answers.
#[derive(Clone)]
struct Part {
    bytes: Vec<u8>,
    write_enabled: bool,
    /// Changes until the power goes; that one is torn.
    left: Option<u32>,
    is_on: bool,
    dice: u32,
    changes: u32,
    erases: u32,
}

/// Nothing answers: the bus reads as the part without power, and its driver reports so.
#[derive(Debug, PartialEq)]
struct NoAnswer;

impl spi::Error for NoAnswer {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

/// The wires to it: the part is looked at from outside, too.
#[derive(Clone)]
struct Bus(Rc<RefCell<Part>>);

impl spi::ErrorType for Bus {
    type Error = NoAnswer;
}

impl Part {
    fn new() -> Self {
        Self { bytes: vec![0x5A; BYTES], write_enabled: false, left: None, is_on: true, dice: 9, changes: 0, erases: 0 }
    }

    fn random(&mut self) -> u8 {
        self.dice = self.dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.dice >> 24) as u8
    }

    /// One change of the memory; true if the power goes while it is made.
    fn changes(&mut self) -> bool {
        assert!(self.write_enabled, "a change without a write enable does nothing");
        self.write_enabled = false;
        self.changes += 1;
        self.left = self.left.map(|left| left.saturating_sub(1));
        self.is_on = self.left != Some(0);
        !self.is_on
    }

    fn program(&mut self, address: usize, data: &[u8]) {
        let torn = self.changes();
        let page = address / PAGE * PAGE;
        for (k, byte) in data.iter().enumerate() {
            // A torn program leaves some bits as they were.
            let mask = if torn { self.random() } else { 0 };
            // Beyond the end of a page the part wraps to its start.
            self.bytes[page + (address + k) % PAGE] &= byte | mask;
        }
    }

    fn erase(&mut self, address: usize) {
        let torn = self.changes();
        self.erases += 1;
        let from = address / SECTOR * SECTOR;
        for at in from..from + SECTOR {
            self.bytes[at] = if torn { self.bytes[at] | self.random() } else { 0xFF };
        }
    }
}

impl SpiDevice for Bus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), NoAnswer> {
        self.0.borrow_mut().transaction(operations)
    }
}

impl Part {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), NoAnswer> {
        if !self.is_on {
            return Err(NoAnswer);
        }
        let address = |bytes: &[u8]| bytes.iter().fold(0, |all, byte| all << 8 | usize::from(*byte));
        match operations {
            [Operation::Write([0x06])] => self.write_enabled = true,
            [Operation::Write([0x20, at @ ..])] if at.len() == 3 => self.erase(address(at)),
            [Operation::TransferInPlace([command @ 0x05, status])] => {
                (*command, *status) = (0xFF, u8::from(self.write_enabled) << 1);
            }
            [Operation::Write([0x03, at @ ..]), Operation::Read(into)] => {
                into.copy_from_slice(&self.bytes[address(at)..][..into.len()]);
            }
            [Operation::Write([0x02, at @ ..]), Operation::Write(data)] => self.program(address(at), data),
            other => panic!("no command of the part: {other:?}"),
        }
        if self.is_on { Ok(()) } else { Err(NoAnswer) }
    }
}

/// HOLD and WP, which are tied.
#[derive(Clone)]
struct Tied;

impl digital::ErrorType for Tied {
    type Error = Infallible;
}

impl OutputPin for Tied {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// The driver, which the store takes. Its own `NorFlash::erase` panics if the bus fails; `erase_sector` does not.
struct Nor(W25q32jv<Bus, Tied, Tied>);

impl ErrorType for Nor {
    type Error = Error<NoAnswer, Infallible>;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        (from / SECTOR as u32..to / SECTOR as u32).try_for_each(|sector| self.0.erase_sector(sector))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write_blocking(offset, bytes)
    }
}

/// The wires, asynchronous: each transfer is under way once before it is done, as one by a DMA.
struct AsyncBus(Bus);

impl spi::ErrorType for AsyncBus {
    type Error = NoAnswer;
}

impl embedded_hal_async::spi::SpiDevice for AsyncBus {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), NoAnswer> {
        let mut under_way = false;
        poll_fn(|_| if std::mem::replace(&mut under_way, true) { Poll::Ready(()) } else { Poll::Pending }).await;
        self.0.transaction(operations)
    }
}

/// The same driver's asynchronous side, with the same care for `erase`.
struct AsyncNor(W25q32jv<AsyncBus, Tied, Tied>);

impl ErrorType for AsyncNor {
    type Error = Error<NoAnswer, Infallible>;
}

impl embedded_storage_async::nor_flash::ReadNorFlash for AsyncNor {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read_async(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl embedded_storage_async::nor_flash::NorFlash for AsyncNor {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        for sector in from / SECTOR as u32..to / SECTOR as u32 {
            self.0.erase_sector_async(sector).await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write_async(offset, bytes).await
    }
}

type Store = ModelStore<Nor, 3>;

/// The store as after power-up, and its bus.
fn open(part: &Part) -> (Store, Bus) {
    let bus = Bus(Rc::new(RefCell::new(Part { is_on: true, write_enabled: false, left: None, ..part.clone() })));
    let driver = W25q32jv::new(bus.clone(), Tied, Tied).unwrap();
    let mut store = ModelStore::open(Nor(driver), limits()).unwrap();
    while store.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {}
    (store, bus)
}

fn newest(store: &mut Store) -> Option<StoredModel> {
    match store.restore(None).unwrap().outcome {
        Outcome::Chosen { model, .. } => Some(model),
        _ => None,
    }
}

/// A model, and a counter before it, as a command leaves them; erases what it has to where the room has ended.
fn store_both(store: &mut Store, model: &StoredModel, counter: u64) -> bool {
    let made_room = |store: &mut Store| {
        while matches!(store.prepare(NotDrilling::Command), Ok(Preparation::More)) {}
    };
    if matches!(store.store_counter(counter), Err(StorageError::Full)) {
        made_room(store);
        let _ = store.store_counter(counter);
    }
    if matches!(store.store_model(model), Err(StorageError::Full)) {
        made_room(store);
        return store.store_model(model).is_ok();
    }
    store.read_counter() == counter
}

#[test]
fn a_power_cut_at_any_change_of_an_external_flash_leaves_one_model_or_the_other() {
    let mut dice = Dice::new(26);
    let (mut store, bus) = open(&Part::new());
    let (mut cuts, mut erasures) = (0, 0);
    let mut before = dice.model(1, 0, 0);
    assert!(store_both(&mut store, &before, 1));
    // Some rounds through all pages; cut at every change of one model in eleven, and of all that erase.
    for t_us in 1..700_u64 {
        let start = bus.0.borrow().clone();
        let after = dice.model(1, 0, t_us);
        assert!(store_both(&mut store, &after, t_us + 1));
        let changes = bus.0.borrow().changes - start.changes;
        let erases = bus.0.borrow().erases > start.erases;
        erasures += u32::from(erases);
        if erases || t_us % 11 == 0 {
            for cut in 1..=changes {
                let (mut other, wires) = open(&start);
                wires.0.borrow_mut().left = Some(cut);
                store_both(&mut other, &after, t_us + 1);
                let (mut other, _) = open(&wires.0.borrow().clone());
                let counter = other.read_counter();
                assert!(counter == t_us || counter == t_us + 1, "{counter:?} after {t_us}, cut {cut}");
                let found = newest(&mut other);
                assert!(found == Some(before) || found == Some(after), "{t_us}, cut {cut}: {found:?}");
                cuts += 1;
            }
        }
        before = after;
    }
    println!("{cuts} cuts, {erasures} models that had to erase");
    assert!(erasures >= 3 && cuts > 500);
}

/// The asynchronous driver leaves in the part, to the byte, what the blocking one does, and a store finds it again; a
/// flash that is not ready in time is an error and nothing worse.
#[test]
fn an_asynchronous_flash_holds_what_a_blocking_one_does() {
    let wires = || Bus(Rc::new(RefCell::new(Part::new())));
    let driver = |bus: &Bus| W25q32jv::new(AsyncBus(bus.clone()), Tied, Tied).unwrap();
    let (bus, other) = (wires(), wires());
    let mut polled = ModelStore::<_, 3>::open(PolledFlash::new(AsyncNor(driver(&bus)), 100), limits()).unwrap();
    let mut blocking =
        ModelStore::<_, 3>::open(Nor(W25q32jv::new(other.clone(), Tied, Tied).unwrap()), limits()).unwrap();
    while polled.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {}
    while blocking.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {}
    let mut dice = Dice::new(27);
    for t_us in 1..300_u64 {
        let model = dice.model(1, 0, t_us);
        for counter in [t_us] {
            if matches!(polled.store_counter(counter), Err(StorageError::Full)) {
                while polled.prepare(NotDrilling::Command).unwrap() == Preparation::More {}
                polled.store_counter(counter).unwrap();
            }
            if matches!(blocking.store_counter(counter), Err(StorageError::Full)) {
                while blocking.prepare(NotDrilling::Command).unwrap() == Preparation::More {}
                blocking.store_counter(counter).unwrap();
            }
        }
        assert_eq!(polled.store_model(&model).is_ok(), blocking.store_model(&model).is_ok(), "{t_us}");
        assert!(bus.0.borrow().bytes == other.0.borrow().bytes, "{t_us}");
    }
    assert!(bus.0.borrow().erases > 12, "it went round");
    let found = |part: &Bus| {
        let mut store = open(&part.0.borrow().clone()).0;
        (newest(&mut store), store.read_counter())
    };
    assert_eq!(found(&bus), found(&other));
    assert!(found(&bus).0.is_some());

    let mut hasty = PolledFlash::new(AsyncNor(driver(&bus)), 1);
    let mut byte = [0];
    assert!(matches!(ReadNorFlash::read(&mut hasty, 0, &mut byte), Err(PolledError::NotReady)));
}
