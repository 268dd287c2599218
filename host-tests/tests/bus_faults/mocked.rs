//! The same faults from an independent bus, `embedded-hal-mock`, which also checks every byte that the driver
//! sends.
//!
//! The exchange between driver and register model, with an error at one transaction, is recorded and replayed
//! by the mock; on the mock the driver must do the same. Only the mock's I2C bus can fail.

use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use meerkat_mwd::{
    Sample,
    emulation::{
        BusFault, Conversions, FaultyBus, Injection, Ism330dhcx as Ism330dhcxModel, OnI2c, Rm3100 as Rm3100Model,
        Schedule, ism330dhcx, rm3100,
    },
    sensors::{
        Condition, Counters, InertialReading, MagneticReading, Mounting, ReadError, Rm3100Settings, StartError,
        Trigger,
        blocking::{InertialSource, Ism330dhcx, MagneticSource, Rm3100, Supervised},
    },
};
use mwd::bus_faults::Motion;
use std::cell::{Cell, RefCell};

/// Long enough for both to start, settle, fail and come back, microseconds.
const RUN_US: u64 = 160_000;
/// Transactions at which the bus fails: all of the start, and some tens of readings.
const TRANSACTIONS: u32 = 80;

/// One transaction: what was written, what was read, and the error if there was one.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    written: Vec<u8>,
    read: Vec<u8>,
    error: Option<ErrorKind>,
}

/// A bus that records requests and answers.
struct Noted<'a, B> {
    bus: B,
    said: &'a RefCell<Vec<Said>>,
}

impl<B: ErrorType> ErrorType for Noted<'_, B> {
    type Error = B::Error;
}

impl<B: I2c> I2c for Noted<'_, B> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), B::Error> {
        let result = self.bus.transaction(address, operations);
        let (mut written, mut read) = (Vec::new(), Vec::new());
        for operation in operations {
            match operation {
                Operation::Write(bytes) => written.extend_from_slice(bytes),
                Operation::Read(bytes) => read.extend_from_slice(bytes),
            }
        }
        let error = result.as_ref().err().map(Error::kind);
        self.said.borrow_mut().push(Said { written, read, error });
        result
    }
}

/// A bus that joins consecutive writes into one message, as the mock needs to let it fail.
struct OneMessage(Mock);

impl ErrorType for OneMessage {
    type Error = ErrorKind;
}

impl I2c for OneMessage {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let mut written = Vec::new();
        for operation in operations {
            match operation {
                Operation::Write(bytes) => written.extend_from_slice(bytes),
                Operation::Read(bytes) => return self.0.write_read(address, &written, bytes),
            }
        }
        self.0.write(address, &written)
    }
}

fn expectations(address: u8, said: &[Said]) -> Vec<Transaction> {
    said.iter()
        .map(|said| {
            let transaction = match said.read.is_empty() {
                true => Transaction::write(address, said.written.clone()),
                false => Transaction::write_read(address, said.written.clone(), said.read.clone()),
            };
            said.error.map_or(transaction.clone(), |error| transaction.with_error(error))
        })
        .collect()
}

/// Result of a source: its readings, its condition at each call, its counters.
type Told<R> = (Vec<R>, Vec<Option<Condition>>, Counters);

fn inertial<B: I2c>(bus: B, mut pass: impl FnMut(u64)) -> Told<InertialReading> {
    let part = Ism330dhcx::new_i2c(bus, ism330dhcx::I2C_ADDRESS, 1);
    let mut source = Supervised::new(part, Mounting::ALIGNED);
    let (mut readings, mut conditions) = (Vec::new(), Vec::new());
    for now_us in (0..RUN_US).step_by(1_000) {
        pass(now_us);
        let mut out = heapless::Vec::<InertialReading, 16>::new();
        conditions.push(source.read(now_us, Trigger::Polled, &mut out).ok());
        readings.extend(out);
    }
    (readings, conditions, *source.counters())
}

fn magnetic<B: I2c>(bus: B, mut pass: impl FnMut(u64)) -> Told<MagneticReading> {
    let part = Rm3100::new_i2c(bus, rm3100::I2C_ADDRESS, Rm3100Settings::default());
    let mut source = Supervised::new(part, Mounting::ALIGNED);
    let (mut readings, mut conditions) = (Vec::new(), Vec::new());
    for now_us in (0..RUN_US).step_by(1_000) {
        pass(now_us);
        let mut out = heapless::Vec::<MagneticReading, 16>::new();
        conditions.push(source.read(now_us, Trigger::Polled, &mut out).ok());
        readings.extend(out);
    }
    (readings, conditions, *source.counters())
}

/// Plays a model with an error at a transaction, then the mock with the recorded exchange; both must give the
/// same.
macro_rules! at_every_transaction {
    ($model:expr, $address:expr, $source:ident, $least:expr) => {{
        let motion = Motion::new(RUN_US, 5);
        for fault in [BusFault::Nack, BusFault::ArbitrationLoss, BusFault::Locked] {
            for at_transaction in 0..TRANSACTIONS {
                let (model, now) = (RefCell::new($model), Cell::new(0));
                let wire = Cell::new(Schedule::of(Injection { fault, at_transaction, lasting_us: 0 }));
                let said = RefCell::new(Vec::new());
                let bus = FaultyBus::new(OnI2c::new(&model, &now, $address), &now, &wire);
                let truth: fn(&Motion, u64) -> Sample = |motion, now_us| motion.seen[(now_us / 1_000) as usize];
                let played = $source(Noted { bus, said: &said }, |now_us| {
                    now.set(now_us);
                    model.borrow_mut().play(&truth(&motion, now_us));
                });
                let said = said.into_inner();
                assert_eq!(said.iter().filter(|said| said.error.is_some()).count(), 1);
                let mut mock = Mock::new(&expectations($address, &said));
                let mocked = $source(OneMessage(mock.clone()), |_| {});
                mock.done();
                assert_eq!(mocked, played, "{fault:?} at {at_transaction}");
                let (readings, conditions, counters) = mocked;
                assert_eq!(counters.bus_errors, 1, "{fault:?} at {at_transaction}");
                assert_eq!(conditions.last(), Some(&Some(Condition::Running)));
                assert!(readings.len() >= $least, "{fault:?} at {at_transaction}: {}", readings.len());
            }
        }
    }};
}

#[test]
fn the_mock_fails_each_transaction_with_the_gyro_and_accelerometer_and_it_comes_back() {
    at_every_transaction!(Ism330dhcxModel::<32>::new(Conversions::AtItsRate), ism330dhcx::I2C_ADDRESS, inertial, 10);
}

#[test]
fn the_mock_fails_each_transaction_with_the_magnetometer_and_it_comes_back() {
    at_every_transaction!(Rm3100Model::new(Conversions::AtItsRate), rm3100::I2C_ADDRESS, magnetic, 15);
}

#[test]
fn a_start_that_is_not_acknowledged_is_tried_again_after_a_pause() {
    let kind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
    let mut i2c = Mock::new(&[Transaction::write_read(rm3100::I2C_ADDRESS, vec![0x36], vec![0]).with_error(kind)]);
    let part = Rm3100::new_i2c(i2c.clone(), rm3100::I2C_ADDRESS, Rm3100Settings::default());
    let mut source = Supervised::new(part, Mounting::ALIGNED);
    let mut out = heapless::Vec::<MagneticReading, 8>::new();
    assert_eq!(source.read(1_000, Trigger::Polled, &mut out), Err(ReadError::Start(StartError::Bus(kind))));
    assert_eq!(source.read(10_999, Trigger::Polled, &mut out), Ok(Condition::Pausing), "the bus is left alone");
    i2c.done();
}

#[test]
fn another_part_at_the_address_is_not_written_to() {
    let mut i2c = Mock::new(&[Transaction::write_read(rm3100::I2C_ADDRESS, vec![0x36], vec![0x33])]);
    let part = Rm3100::new_i2c(i2c.clone(), rm3100::I2C_ADDRESS, Rm3100Settings::default());
    let mut source = Supervised::new(part, Mounting::ALIGNED);
    let mut out = heapless::Vec::<MagneticReading, 8>::new();
    let wrong = StartError::WrongIdentity { expected: 0x22, found: 0x33 };
    assert_eq!(source.read(0, Trigger::Polled, &mut out), Err(ReadError::Start(wrong)));
    assert_eq!(source.counters().wrong_identity, 1);
    i2c.done();
}
