use embedded_hal_mock::eh1::spi::Transaction;
use meerkat_mwd::sensors::{Frame, blocking::Bmi088};

use super::{burst, exchange, mock, start};

#[test]
fn start_and_one_burst() {
    type Wire = Vec<Transaction<u8>>;
    let write = |register: u8, value: u8| -> Wire { exchange(&[register, value], &[0, 0]) };
    // The accelerometer puts a byte between.
    let accel_read = |register: u8, value: u8| -> Wire { exchange(&[register | 0x80, 0, 0], &[0, 0, value]) };
    let gyro_read = |register: u8, value: u8| -> Wire { exchange(&[register | 0x80, 0], &[0, value]) };
    let accel_vector = |register: u8, bytes: [u8; 6]| -> Wire {
        exchange(&[register | 0x80, 0, 0, 0, 0, 0, 0, 0], &[&[0, 0][..], &bytes].concat())
    };
    let gyro_vector = |register: u8, bytes: [u8; 6]| -> Wire {
        exchange(&[register | 0x80, 0, 0, 0, 0, 0, 0], &[&[0][..], &bytes].concat())
    };
    let mut accel = mock(&[
        accel_read(0x00, 0xFF),
        accel_read(0x00, 0x1E),
        write(0x7E, 0xB6),
        accel_read(0x00, 0x00),
        write(0x7C, 0x00),
        write(0x7D, 0x04),
        write(0x40, 0xA9),
        write(0x41, 0x03),
        accel_read(0x41, 0x03),
        accel_read(0x40, 0xA9),
        accel_read(0x7D, 0x04),
        // -1 in eleven bits is an eighth of a degree under 23.
        accel_vector(0x22, [0xFF, 0xE0, 0, 0, 0, 0]),
        accel_read(0x03, 0x80),
        accel_vector(0x12, [1, 0, 0xFE, 0xFF, 0x34, 0x12]),
        accel_read(0x40, 0xA9),
        accel_read(0x7D, 0x04),
    ]);
    let mut gyro = mock(&[
        gyro_read(0x00, 0x0F),
        write(0x14, 0xB6),
        write(0x0F, 0x00),
        write(0x10, 0x06),
        write(0x16, 0x01),
        write(0x18, 0x04),
        write(0x1E, 0x88),
        write(0x3D, 0x01),
        write(0x15, 0x40),
        write(0x3E, 0x80),
        gyro_read(0x3E, 0x80),
        gyro_read(0x0E, 0x82),
        gyro_vector(0x3F, [4, 0, 5, 0, 6, 0]),
        gyro_vector(0x3F, [7, 0, 8, 0, 0xF7, 0xFF]),
        // Takes the overrun back.
        write(0x3E, 0x80),
        gyro_read(0x3E, 0x80),
    ]);
    let mut part = Bmi088::new(accel.clone(), gyro.clone());
    assert_eq!(start(&mut part), [30_000, 5_000]);
    let burst = burst(&mut part);
    let frame = |gyro, accel| Frame { codes: [Some(gyro), accel], temperature: Some(-1) };
    assert_eq!(burst.frames(), [frame([4, 5, 6], None), frame([7, 8, -9], Some([1, -2, 0x1234]))]);
    assert!(burst.overrun);
    accel.done();
    gyro.done();
}
