use embedded_hal_mock::eh1::spi::Mock;
use meerkat_mwd::sensors::{Frame, Lsm6dsv320xRange, blocking::Lsm6dsv320x};

use super::{burst, mock, spi, start};

/// The part has no parity in its tags: sensor in bits 7 to 3, time slot in 2 and 1.
fn word(sensor: u8, slot: u8, codes: [i16; 3]) -> Vec<u8> {
    [vec![sensor << 3 | slot << 1], codes.iter().flat_map(|code| code.to_le_bytes()).collect()].concat()
}

/// `high_g`: CTRL1_XL_HG; `settings`: CTRL1, CTRL2, CTRL3; `fifo`: FIFO_CTRL1 to 4 and COUNTER_BDR_REG1.
fn start_and_one_burst(high_g: u8, settings: [u8; 3], fifo: [u8; 5], accel_tag: u8) -> Mock<u8> {
    let [c1, c2, c3] = settings;
    let [f1, f2, f3, f4, f5] = fifo;
    mock(&[
        spi(&[&[0x8F]], &[0x73]),
        spi(&[&[0x12, 0x45]], &[]),
        spi(&[&[0x92]], &[0x44]),
        spi(&[&[0x0D, 0x08]], &[]),
        spi(&[&[0x15, 0x0C]], &[]),
        spi(&[&[0x95]], &[0x0C]),
        spi(&[&[0x17, 0x03]], &[]),
        spi(&[&[0x97]], &[0x03]),
        spi(&[&[0x4E, high_g]], &[]),
        spi(&[&[0xCE]], &[high_g]),
        spi(&[&[0x10, c1, c2, c3]], &[]),
        spi(&[&[0x07, f1, f2, f3, f4, f5]], &[]),
        spi(&[&[0x87]], &fifo),
        spi(&[&[0x90]], &settings),
        spi(&[&[0x9B]], &[2, 0x08]),
        spi(&[&[0xA0]], &[0x80, 0xFF]),
        spi(&[&[0xF8]], &[word(1, 2, [1, 2, 3]), word(accel_tag, 2, [-1, -2, -3])].concat()),
        spi(&[&[0x90]], &settings),
    ])
}

#[test]
fn start_and_one_burst_at_either_range() {
    // 240 Hz twice, both batched at 240 Hz; or gyro and high-g at 480 Hz, 320 g.
    let low = start_and_one_burst(0x04, [0x07, 0x07, 0x44], [2, 0, 0x77, 0x06, 0x00], 0x02);
    let high = start_and_one_burst(0x1C, [0x00, 0x08, 0x44], [2, 0, 0x80, 0x06, 0x08], 0x1D);
    for (mut bus, range) in [(low, Lsm6dsv320xRange::G16), (high, Lsm6dsv320xRange::G320)] {
        let mut part = Lsm6dsv320x::new_spi(bus.clone(), range, 1);
        assert_eq!(start(&mut part), [1_000]);
        let burst = burst(&mut part);
        assert!(burst.overrun);
        assert_eq!(burst.frames(), [Frame { codes: [Some([1, 2, 3]), Some([-1, -2, -3])], temperature: Some(-128) }]);
        bus.done();
    }
}
