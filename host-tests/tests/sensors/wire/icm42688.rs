use std::{cell::Cell, rc::Rc};

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::spi::{Mock, Transaction};
use meerkat_mwd::sensors::{
    Burst, Frame,
    blocking::{Icm42688, Part},
};

use super::{burst, mock, refused, spi, start};

type Wire = Vec<Transaction<u8>>;

/// Packet 4: header; x, y, z of the accelerometer, then of the gyro, two bytes each; temperature; time; the
/// low four bits, accelerometer's first.
fn packet(header: u8, accel: [i32; 3], gyro: [i32; 3], temperature: i16) -> Vec<u8> {
    let upper = |code: i32| ((code >> 4) as i16).to_be_bytes();
    let low = |k: usize| ((accel[k] & 15) << 4 | gyro[k] & 15) as u8;
    let mut bytes = vec![header];
    bytes.extend(accel.into_iter().chain(gyro).flat_map(upper));
    bytes.extend(temperature.to_be_bytes());
    bytes.extend([0, 0, low(0), low(1), low(2)]);
    bytes
}

/// Up to the settings that are read back: order of the bytes, clock, and the FIFO's packets.
fn first_writes() -> Vec<Wire> {
    vec![
        spi(&[&[0x76], &[0]], &[]),
        spi(&[&[0xF5]], &[0x47]),
        spi(&[&[0x11], &[0x01]], &[]),
        spi(&[&[0x14], &[0x03]], &[]),
        spi(&[&[0x64], &[0x00, 0x04]], &[]),
        spi(&[&[0x4C], &[0x73]], &[]),
        spi(&[&[0x4D], &[0x51]], &[]),
        spi(&[&[0x4F], &[0x07]], &[]),
        spi(&[&[0x50], &[0x07]], &[]),
        spi(&[&[0x5F], &[0x77, 0x01, 0x00]], &[]),
    ]
}

fn settings() -> Wire {
    spi(&[&[0xCE]], &[0x0F, 0x07, 0x07])
}

#[test]
fn start_and_bursts() {
    let (accel, gyro) = ([1, -2, 400_000], [-524_200, 17, 3]);
    let sound = packet(0x78, accel, gyro, -132);
    let empty = vec![0xFF; 20];
    let invalid = packet(0x78, accel, [-524_288, 0, 0], 0);
    let mut bus = mock(
        &[
            first_writes(),
            vec![
                spi(&[&[0xCC]], &[0x73, 0x51]),
                spi(&[&[0xDF]], &[0x77, 0x01, 0x00]),
                spi(&[&[0x4E], &[0x0F]], &[]),
                spi(&[&[0x16], &[0x40]], &[]),
                spi(&[&[0x4B], &[0x02]], &[]),
                settings(),
                // One packet was expected, and there are three.
                spi(&[&[0xAD]], &[vec![0x04, 0, 3], sound.clone()].concat()),
                settings(),
                spi(&[&[0xAD]], &[vec![0x02, 0, 1], invalid, empty].concat()),
                settings(),
            ],
        ]
        .concat(),
    );
    let mut part = Icm42688::new(bus.clone());
    assert_eq!(start(&mut part), [1_000, 200]);
    let first = burst(&mut part);
    assert_eq!(first.frames(), [Frame { codes: [Some(gyro), Some(accel)], temperature: Some(-132) }]);
    assert_eq!((first.left, first.overrun), (2, false));
    let second = burst(&mut part);
    assert_eq!(second.frames(), [Frame { codes: [None, Some(accel)], temperature: Some(0) }]);
    assert!(second.overrun);
    bus.done();
}

#[test]
fn a_setting_that_was_not_taken_is_no_start() {
    let refused_at = |read_back: &[Wire]| {
        let mut bus = mock(&[first_writes(), read_back.to_vec()].concat());
        let register = refused(&mut Icm42688::new(bus.clone()));
        bus.done();
        register
    };
    assert_eq!(refused_at(&[spi(&[&[0xCC]], &[0x30, 0x51])]), 0x4C);
    assert_eq!(refused_at(&[spi(&[&[0xCC]], &[0x73, 0x91])]), 0x4C);
    let interface = spi(&[&[0xCC]], &[0x73, 0x51]);
    for packets in [[0x00, 0x01, 0x00], [0x77, 0x00, 0x00], [0x77, 0x01, 0x01]] {
        assert_eq!(refused_at(&[interface.clone(), spi(&[&[0xDF]], &packets)]), 0x5F);
    }
}

/// A bus whose next transaction fails if `fails` is set.
struct Failing {
    bus: Mock<u8>,
    fails: Rc<Cell<bool>>,
}

impl ErrorType for Failing {
    type Error = ErrorKind;
}

impl SpiDevice for Failing {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        if self.fails.take() { Err(ErrorKind::Other) } else { SpiDevice::transaction(&mut self.bus, operations) }
    }
}

/// Read off its packets' boundary the FIFO would give wrong packets until the next start.
#[test]
fn after_a_spoilt_packet_or_a_failed_burst_the_fifo_is_flushed() {
    let sound = || packet(0x78, [1, 2, 3], [4, 5, 6], 0);
    let one = |packet: Vec<u8>| spi(&[&[0xAD]], &[vec![0x00, 0, 1], packet].concat());
    let none = || spi(&[&[0xAD]], &[vec![0x00, 0, 0], vec![0xFF; 20]].concat());
    let flush = || spi(&[&[0x4B], &[0x02]], &[]);
    let mut bus = mock(&[
        // A packet of another kind, of two that are read.
        spi(&[&[0xAD]], &[vec![0x00, 0, 3], sound()].concat()),
        settings(),
        spi(&[&[0xAD]], &[vec![0x00, 0, 2], packet(0x68, [1, 2, 3], [4, 5, 6], 0), sound()].concat()),
        settings(),
        flush(),
        none(),
        settings(),
        one(sound()),
        settings(),
        // The burst fails, and the flush after it, too.
        flush(),
        one(sound()),
        settings(),
        one(sound()),
        settings(),
    ]);
    let fails = Rc::new(Cell::new(false));
    let mut part = Icm42688::new(Failing { bus: bus.clone(), fails: fails.clone() });
    let told = |part: &mut Icm42688<Failing>| {
        let burst = burst(part);
        (burst.frames().len(), burst.corrupt, burst.overrun)
    };
    assert_eq!([(); 4].map(|()| told(&mut part)), [(1, 0, false), (2, 1, false), (0, 0, true), (1, 0, false)]);
    for _ in 0..2 {
        fails.set(true);
        assert!(part.read(&mut Burst::default()).is_err());
    }
    assert_eq!([(); 2].map(|()| told(&mut part)), [(1, 0, true), (1, 0, false)]);
    bus.done();
}
