//! The same faults from a bus that someone else wrote: `embedded-hal-mock`, which also checks every byte that the driver sends.

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use heapless::Vec;
use meerkat_mwd::sensors::{
    Condition, MagneticReading, Mounting, ReadError, Rm3100Settings, StartError, Trigger,
    blocking::{MagneticSource, Rm3100, Supervised},
};

const AT: u8 = 0x20;

/// The start of an RM3100 as its manual wants it: revision, idle, cycle counts, rate, and continuous mode last.
fn start() -> std::vec::Vec<Transaction> {
    let grouped = |bytes: &[u8]| {
        let [first, rest @ ..] = bytes else { panic!("nothing to write") };
        vec![
            Transaction::transaction_start(AT),
            Transaction::write(AT, vec![*first]),
            Transaction::write(AT, rest.to_vec()),
            Transaction::transaction_end(AT),
        ]
    };
    let read = |register: u8, bytes: &[u8]| vec![Transaction::write_read(AT, vec![register], bytes.to_vec())];
    [
        read(0x36, &[0x22]),
        grouped(&[0x01, 0]),
        grouped(&[0x04, 0, 200, 0, 200, 0, 200]),
        read(0x04, &[0, 200, 0, 200, 0, 200]),
        grouped(&[0x0B, 0x94]),
        read(0x0B, &[0x94]),
        grouped(&[0x01, 0x79]),
    ]
    .concat()
}

fn source(i2c: &Mock) -> Supervised<Rm3100<meerkat_mwd::sensors::blocking::I2cRegisters<Mock>>, 1> {
    let part = Rm3100::new_i2c(i2c.clone(), AT, Rm3100Settings::default());
    Supervised::new(part, Mounting::ALIGNED, Trigger::Polled)
}

#[test]
fn a_start_that_is_not_acknowledged_is_tried_again_after_a_pause() {
    for kind in [ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address), ErrorKind::ArbitrationLoss, ErrorKind::Bus] {
        let failed = vec![Transaction::write_read(AT, vec![0x36], vec![0]).with_error(kind)];
        let mut i2c = Mock::new(&[failed, start()].concat());
        let mut source = source(&i2c);
        let mut out = Vec::<MagneticReading, 8>::new();
        assert_eq!(source.read(1_000, &mut out), Err(ReadError::Start(StartError::Bus(kind))));
        assert_eq!(source.read(10_999, &mut out), Ok(Condition::Pausing), "the bus is left alone");
        assert_eq!(source.read(11_000, &mut out), Ok(Condition::Starting));
        assert_eq!(source.counters().bus_errors, 1);
        i2c.done();
    }
}

#[test]
fn another_part_at_the_address_is_not_written_to() {
    let mut i2c = Mock::new(&[Transaction::write_read(AT, vec![0x36], vec![0x33])]);
    let mut source = source(&i2c);
    let mut out = Vec::<MagneticReading, 8>::new();
    let wrong = StartError::WrongIdentity { expected: 0x22, found: 0x33 };
    assert_eq!(source.read(0, &mut out), Err(ReadError::Start(wrong)));
    assert_eq!(source.counters().wrong_identity, 1);
    i2c.done();
}
