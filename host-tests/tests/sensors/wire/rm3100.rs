use std::{future::Future, pin::pin, task};

use embedded_hal_mock::eh1::{i2c, spi::Mock};
use meerkat_mwd::sensors::{Burst, Frame, Rm3100Rate, Rm3100Settings, StartError, asynchronous, blocking};

use super::{burst, mock, spi, start};

/// x 1, y -2, z 0x123456.
const RESULTS: [u8; 9] = [0x00, 0x00, 0x01, 0xFF, 0xFF, 0xFE, 0x12, 0x34, 0x56];
const CODES: [i32; 3] = [1, -2, 0x12_3456];

fn start_and_one_burst() -> Mock<u8> {
    mock(&[
        spi(&[&[0xB6]], &[0x22]),
        spi(&[&[0x01], &[0x00]], &[]),
        spi(&[&[0x04], &[0, 200, 0, 200, 0, 200]], &[]),
        spi(&[&[0x84]], &[0, 200, 0, 200, 0, 200]),
        spi(&[&[0x0B], &[0x94]], &[]),
        spi(&[&[0x8B]], &[0x94]),
        spi(&[&[0x01], &[0x79]], &[]),
        // Nothing new: one byte is asked for and no more. Bits 0 to 6 are indeterminate.
        spi(&[&[0xB4]], &[0x7F]),
        spi(&[&[0x8B]], &[0x94]),
        spi(&[&[0xB4]], &[0xFF]),
        spi(&[&[0xA4]], &RESULTS),
        spi(&[&[0xB4]], &[0x12]),
        spi(&[&[0x8B]], &[0x94]),
    ])
}

#[test]
fn over_spi() {
    let mut bus = start_and_one_burst();
    let mut part = blocking::Rm3100::new_spi(bus.clone(), Rm3100Settings::default());
    assert!(start(&mut part).is_empty());
    assert_eq!(burst(&mut part), Burst::default());
    assert_eq!(burst(&mut part).frames(), [Frame { codes: [Some(CODES)], temperature: None }]);
    bus.done();
}

/// Runs a future that never has to wait.
fn run<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut task::Context::from_waker(task::Waker::noop())) {
        task::Poll::Ready(output) => output,
        task::Poll::Pending => panic!("the mock never waits"),
    }
}

#[test]
fn over_spi_asynchronously_the_same_bytes() {
    use asynchronous::Part;
    let mut bus = start_and_one_burst();
    let mut part = asynchronous::Rm3100::new_spi(bus.clone(), Rm3100Settings::default());
    run(part.start(0)).unwrap();
    let mut burst = Burst::default();
    run(part.read(&mut burst)).unwrap();
    assert!(run(part.is_configured()).unwrap());
    run(part.read(&mut burst)).unwrap();
    assert!(run(part.is_configured()).unwrap());
    assert_eq!(burst.frames(), [Frame { codes: [Some(CODES)], temperature: None }]);
    bus.done();
}

#[test]
fn over_i2c() {
    use i2c::Transaction as T;
    let write = |bytes: &[u8]| {
        let (register, values) = bytes.split_at(1);
        vec![
            T::transaction_start(0x20),
            T::write(0x20, register.to_vec()),
            T::write(0x20, values.to_vec()),
            T::transaction_end(0x20),
        ]
    };
    let read = |register: u8, values: &[u8]| vec![T::write_read(0x20, vec![register], values.to_vec())];
    let transactions = [
        read(0x36, &[0x22]),
        write(&[0x01, 0x00]),
        write(&[0x04, 0, 100, 0, 100, 0, 100]),
        read(0x04, &[0, 100, 0, 100, 0, 100]),
        write(&[0x0B, 0x92]),
        read(0x0B, &[0x92]),
        write(&[0x01, 0x79]),
        read(0x34, &[0x80]),
        read(0x24, &RESULTS),
        read(0x34, &[0x00]),
        read(0x0B, &[0x92]),
    ];
    let mut bus = i2c::Mock::new(&transactions.concat());
    let settings = Rm3100Settings::new(100, Rm3100Rate::Hz600).unwrap();
    let mut part = blocking::Rm3100::new_i2c(bus.clone(), 0x20, settings);
    start(&mut part);
    assert_eq!(burst(&mut part).frames(), [Frame { codes: [Some(CODES)], temperature: None }]);
    bus.done();
}

#[test]
fn a_result_that_came_during_the_reading_is_dropped() {
    let mut bus = mock(&[
        spi(&[&[0xB4]], &[0x80]),
        spi(&[&[0xA4]], &RESULTS),
        spi(&[&[0xB4]], &[0x80]),
        spi(&[&[0x8B]], &[0x94]),
    ]);
    let mut part = blocking::Rm3100::new_spi(bus.clone(), Rm3100Settings::default());
    let burst = burst(&mut part);
    assert!(burst.frames().is_empty());
    assert_eq!(burst.corrupt, 1);
    bus.done();
}

#[test]
fn another_part_and_settings_that_are_not_taken_are_told() {
    use blocking::Part;
    let mut bus = mock(&[spi(&[&[0xB6]], &[0xFF])]);
    let mut part = blocking::Rm3100::new_spi(bus.clone(), Rm3100Settings::default());
    assert_eq!(part.start(0), Err(StartError::WrongIdentity { expected: 0x22, found: 0xFF }));
    bus.done();
    let mut bus = mock(&[
        spi(&[&[0xB6]], &[0x22]),
        spi(&[&[0x01], &[0x00]], &[]),
        spi(&[&[0x04], &[0, 200, 0, 200, 0, 200]], &[]),
        spi(&[&[0x84]], &[0, 200, 0, 200, 0, 72]),
    ]);
    let mut part = blocking::Rm3100::new_spi(bus.clone(), Rm3100Settings::default());
    assert_eq!(part.start(0), Err(StartError::NotTaken { register: 0x04 }));
    bus.done();
}

/// User manual, table 3-1: gain, noise and single-axis rate at three cycle counts.
#[test]
fn its_data_are_the_data_sheets() {
    for (cycle_count, codes_per_ut, noise_nt, axis_hz) in
        [(50, 20.0, 30.0, 1600.0), (100, 38.0, 20.0, 850.0), (200, 75.0, 15.0, 440.0)]
    {
        let settings = Rm3100Settings::new(cycle_count, Rm3100Rate::Hz600).unwrap();
        approx::assert_relative_eq!(settings.codes_per_ut(), codes_per_ut, max_relative = 0.01);
        approx::assert_relative_eq!(settings.noise_ut() * 1e3, noise_nt, max_relative = 0.07);
        approx::assert_relative_eq!(1e6 / settings.axis_us() as f32, axis_hz, max_relative = 0.01);
    }
    assert!(
        Rm3100Settings::new(29, Rm3100Rate::Hz600).is_err() && Rm3100Settings::new(401, Rm3100Rate::Hz600).is_err()
    );
}

/// Three turns end with the data-ready, and each axis reads the mean over its own.
#[test]
fn its_axes_are_late_by_turns() {
    use blocking::Part;
    let settings = Rm3100Settings::new(200, Rm3100Rate::Hz600).unwrap();
    let mut bus = mock(&[]);
    let data = blocking::Rm3100::new_spi(bus.clone(), settings).data();
    bus.done();
    let [x, y, z] = data.sensors[0].latency_s;
    let turn_s = settings.axis_us() as f32 * 1e-6;
    approx::assert_relative_eq!(x - y, turn_s, max_relative = 1e-4);
    approx::assert_relative_eq!(y - z, turn_s, max_relative = 1e-4);
    approx::assert_relative_eq!(2.0 * z, turn_s, max_relative = 1e-4);
    // The first turn cannot have begun before the last result.
    assert!(x + 0.5 * turn_s <= data.period_us as f32 * 1.001e-6);
    assert_eq!(data.period_us, 3 * settings.axis_us(), "600 Hz are too fast for 200 cycles");
}
