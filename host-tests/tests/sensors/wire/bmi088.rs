use embedded_hal_mock::eh1::spi::Transaction;
use meerkat_mwd::sensors::{
    Frame,
    blocking::{Bmi088, Part},
};

use super::{burst, exchange, mock, refused, start};

type Wire = Vec<Transaction<u8>>;

fn write(register: u8, value: u8) -> Wire {
    exchange(&[register, value], &[0, 0])
}

/// The accelerometer puts a byte between.
fn accel_read(register: u8, value: u8) -> Wire {
    exchange(&[register | 0x80, 0, 0], &[0, 0, value])
}

fn gyro_read(register: u8, value: u8) -> Wire {
    exchange(&[register | 0x80, 0], &[0, value])
}

fn accel_vector(register: u8, bytes: [u8; 6]) -> Wire {
    exchange(&[register | 0x80, 0, 0, 0, 0, 0, 0, 0], &[&[0, 0][..], &bytes].concat())
}

fn gyro_vector(register: u8, bytes: [u8; 6]) -> Wire {
    exchange(&[register | 0x80, 0, 0, 0, 0, 0, 0], &[&[0][..], &bytes].concat())
}

/// Values that the part reads back after its start.
#[derive(Clone, Copy)]
struct ReadBack {
    accel_range: u8,
    power: u8,
    gyro_range: u8,
    bandwidth: u8,
}

/// Bit 7 of the bandwidth reads as one.
const SOUND: ReadBack = ReadBack { accel_range: 0x03, power: 0, gyro_range: 0, bandwidth: 0x86 };

fn accel_start(back: ReadBack) -> Vec<Wire> {
    vec![
        accel_read(0x00, 0xFF),
        accel_read(0x00, 0x1E),
        write(0x7E, 0xB6),
        accel_read(0x00, 0x00),
        write(0x7C, 0x00),
        write(0x7D, 0x04),
        write(0x40, 0xA9),
        write(0x41, 0x03),
        accel_read(0x41, back.accel_range),
    ]
}

fn accel_settings(back: ReadBack) -> Vec<Wire> {
    vec![accel_read(0x40, 0xA9), accel_read(0x7C, back.power), accel_read(0x7D, 0x04)]
}

fn gyro_start(back: ReadBack) -> Vec<Wire> {
    vec![
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
        gyro_read(0x0F, back.gyro_range),
        gyro_read(0x10, back.bandwidth),
    ]
}

#[test]
fn start_and_one_burst() {
    let mut accel = mock(
        &[
            accel_start(SOUND),
            accel_settings(SOUND),
            vec![
                // -1 in eleven bits is an eighth of a degree under 23.
                accel_vector(0x22, [0xFF, 0xE0, 0, 0, 0, 0]),
                accel_read(0x03, 0x80),
                accel_vector(0x12, [1, 0, 0xFE, 0xFF, 0x34, 0x12]),
            ],
            accel_settings(SOUND),
        ]
        .concat(),
    );
    let mut gyro = mock(
        &[
            gyro_start(SOUND),
            vec![
                gyro_read(0x3E, 0x80),
                gyro_read(0x0E, 0x82),
                gyro_vector(0x3F, [4, 0, 5, 0, 6, 0]),
                gyro_vector(0x3F, [7, 0, 8, 0, 0xF7, 0xFF]),
                // Takes the overrun back.
                write(0x3E, 0x80),
                gyro_read(0x3E, 0x80),
            ],
        ]
        .concat(),
    );
    let mut part = Bmi088::new(accel.clone(), gyro.clone());
    assert_eq!(start(&mut part), [30_000, 450, 5_000]);
    let burst = burst(&mut part);
    let frame = |gyro, accel| Frame { codes: [Some(gyro), accel], temperature: Some(-1) };
    assert_eq!(burst.frames(), [frame([4, 5, 6], None), frame([7, 8, -9], Some([1, -2, 0x1234]))]);
    assert!(burst.overrun);
    accel.done();
    gyro.done();
}

/// The part's flag stands until the FIFO is empty.
#[test]
fn an_overrun_is_told_once() {
    let frames = |number| vec![gyro_vector(0x3F, [4, 0, 5, 0, 6, 0]); number];
    let mut accel = mock(
        &[
            vec![accel_vector(0x22, [0; 6])],
            accel_settings(SOUND),
            accel_settings(SOUND),
            vec![accel_read(0x03, 0x00)],
            accel_settings(SOUND),
            vec![accel_read(0x03, 0x00)],
            accel_settings(SOUND),
        ]
        .concat(),
    );
    let mut gyro = mock(
        &[
            vec![gyro_read(0x0E, 0x80 | 20)],
            frames(8),
            vec![gyro_read(0x3E, 0x80), gyro_read(0x0E, 0x80 | 12)],
            frames(8),
            vec![gyro_read(0x3E, 0x80), gyro_read(0x0E, 0x80 | 4)],
            frames(4),
            vec![write(0x3E, 0x80), gyro_read(0x3E, 0x80), gyro_read(0x0E, 0x80 | 1)],
            frames(1),
            vec![write(0x3E, 0x80), gyro_read(0x3E, 0x80)],
        ]
        .concat(),
    );
    let mut part = Bmi088::new(accel.clone(), gyro.clone());
    let told: Vec<(u16, bool)> = (0..4).map(|_| burst(&mut part)).map(|burst| (burst.left, burst.overrun)).collect();
    assert_eq!(told, [(12, true), (4, false), (0, false), (0, true)]);
    accel.done();
    gyro.done();
}

/// A wrong range of the gyro would scale every rate wrongly.
#[test]
fn a_setting_that_was_not_taken_is_no_start() {
    let refused_at = |accel: &[Wire], gyro: &[Wire]| {
        let (mut accel, mut gyro) = (mock(accel), mock(gyro));
        let register = refused(&mut Bmi088::new(accel.clone(), gyro.clone()));
        accel.done();
        gyro.done();
        register
    };
    let gyro = gyro_start(SOUND);
    let wrong = ReadBack { gyro_range: 0x04, ..SOUND };
    assert_eq!(refused_at(&accel_start(SOUND), &gyro_start(wrong)[..gyro.len() - 1]), 0x0F);
    let wrong = ReadBack { bandwidth: 0x80, ..SOUND };
    assert_eq!(refused_at(&accel_start(SOUND), &gyro_start(wrong)), 0x10);
    let wrong = ReadBack { accel_range: 0x01, ..SOUND };
    assert_eq!(refused_at(&accel_start(wrong), &gyro[..gyro.len() - 2]), 0x41);
    // Suspended: it answers, and measures nothing.
    let wrong = ReadBack { power: 0x03, ..SOUND };
    refused_at(&[accel_start(SOUND), accel_settings(wrong)[..2].to_vec()].concat(), &gyro);
}

/// A low-pass of 80 Hz, and half a period for the frame whose time the gyro's interrupt sets.
#[test]
fn the_accelerometers_latency_has_the_wait_for_the_gyros_frame() {
    let (mut accel, mut gyro) = (mock(&[]), mock(&[]));
    let [gyro_s, accel_s] =
        Bmi088::new(accel.clone(), gyro.clone()).data().sensors.map(|sensor| sensor.mean_latency_s());
    assert!((gyro_s - 3.517e-3).abs() < 1e-6, "{gyro_s}");
    assert!((accel_s - 5.313e-3).abs() < 1e-6, "{accel_s}");
    accel.done();
    gyro.done();
}
