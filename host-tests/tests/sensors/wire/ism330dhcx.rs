use meerkat_mwd::sensors::{Burst, Frame, StartError, blocking::Ism330dhcx, blocking::Part};

use super::{burst, mock, spi, start};

/// A word of the FIFO: sensor, time slot, even parity.
fn word(sensor: u8, slot: u8, codes: [i16; 3]) -> Vec<u8> {
    let tag = sensor << 3 | (slot & 3) << 1;
    let tag = tag | (tag.count_ones() % 2) as u8;
    [vec![tag], codes.iter().flat_map(|code| code.to_le_bytes()).collect()].concat()
}

const GYRO: u8 = 1;
const ACCEL: u8 = 2;

#[test]
fn start_and_bursts() {
    let status = |words: u16, flags: u8| spi(&[&[0xBA]], &[words as u8, (words >> 8) as u8 | flags]);
    let settings = || spi(&[&[0x90]], &[0x54, 0x5C, 0x44]);
    let first = [word(GYRO, 0, [1, -2, 3]), word(ACCEL, 0, [-4, 5, -6])].concat();
    // The accelerometer's word of slot 2 is not out yet.
    let second = [word(GYRO, 1, [7, 8, 9]), word(ACCEL, 1, [10, 11, 12]), word(GYRO, 2, [13, 14, 15])].concat();
    let third = word(ACCEL, 2, [16, 17, 18]);
    let mut bus = mock(&[
        spi(&[&[0x8F]], &[0x6B]),
        spi(&[&[0x12, 0x05]], &[]),
        spi(&[&[0x92]], &[0x04]),
        spi(&[&[0x18, 0xE2]], &[]),
        spi(&[&[0x0D, 0x08]], &[]),
        // 208 Hz, 16 g; 208 Hz, 2000 dps; block data update, address increment.
        spi(&[&[0x10, 0x54, 0x5C, 0x44]], &[]),
        // Watermark of 4 frames, that is 8 words; both batched at 208 Hz; continuous.
        spi(&[&[0x07, 8, 0x00, 0x55, 0x06]], &[]),
        spi(&[&[0x87]], &[8, 0x00, 0x55, 0x06]),
        settings(),
        status(2, 0),
        spi(&[&[0xA0]], &[0x00, 0x01]),
        spi(&[&[0xF8]], &first),
        settings(),
        status(3, 1 << 3),
        spi(&[&[0xF8]], &second),
        settings(),
        status(1, 0),
        spi(&[&[0xF8]], &third),
        settings(),
        status(0, 0),
        settings(),
    ]);
    let mut part = Ism330dhcx::new_spi(bus.clone(), 4);
    assert_eq!(start(&mut part), [1_000]);
    let frame = |gyro, accel| Frame { codes: [Some(gyro), Some(accel)], temperature: Some(256) };
    assert_eq!(burst(&mut part).frames(), [frame([1, -2, 3], [-4, 5, -6])]);
    let overrun = burst(&mut part);
    assert_eq!(overrun.frames(), [frame([7, 8, 9], [10, 11, 12])]);
    assert!(overrun.overrun);
    assert_eq!(burst(&mut part).frames(), [frame([13, 14, 15], [16, 17, 18])]);
    assert_eq!(burst(&mut part), Burst::default());
    bus.done();
}

/// A word whose parity is wrong, or with a sensor that was not asked for: its place is kept, without it.
#[test]
fn spoilt_words_keep_their_place() {
    let mut flipped = word(ACCEL, 0, [1, 1, 1]);
    flipped[0] ^= 1 << 4;
    let words = [word(GYRO, 0, [1, 2, 3]), flipped, vec![0xFF; 7], word(ACCEL, 1, [4, 5, 6])].concat();
    let mut bus = mock(&[
        spi(&[&[0xBA]], &[4, 0]),
        spi(&[&[0xA0]], &[0x00, 0x00]),
        spi(&[&[0xF8]], &words),
        spi(&[&[0x90]], &[0x54, 0x5C, 0x44]),
    ]);
    let burst = burst(&mut Ism330dhcx::new_spi(bus.clone(), 1));
    assert_eq!(
        burst.frames().iter().map(|frame| frame.codes).collect::<Vec<_>>(),
        [[Some([1, 2, 3]), None], [None, Some([4, 5, 6])]]
    );
    assert_eq!(burst.corrupt, 2);
    bus.done();
}

/// The gyro's word of a slot was overwritten: the frames behind are not shifted into each other.
#[test]
fn a_lost_word_does_not_mix_times() {
    let words = [word(ACCEL, 3, [1, 1, 1]), word(GYRO, 0, [2, 2, 2]), word(ACCEL, 0, [3, 3, 3])].concat();
    let mut bus = mock(&[
        spi(&[&[0xBA]], &[3, 0]),
        spi(&[&[0xA0]], &[0x00, 0x00]),
        spi(&[&[0xF8]], &words),
        spi(&[&[0x90]], &[0x54, 0x5C, 0x44]),
    ]);
    let burst = burst(&mut Ism330dhcx::new_spi(bus.clone(), 1));
    assert_eq!(
        burst.frames().iter().map(|frame| frame.codes).collect::<Vec<_>>(),
        [[None, Some([1, 1, 1])], [Some([2, 2, 2]), Some([3, 3, 3])]]
    );
    bus.done();
}

#[test]
fn another_part_and_one_that_does_not_come_out_of_its_reset_are_told() {
    let mut bus = mock(&[spi(&[&[0x8F]], &[0x6C]), spi(&[&[0x92]], &[0x05])]);
    let mut part = Ism330dhcx::new_spi(bus.clone(), 1);
    assert_eq!(part.start(0), Err(StartError::WrongIdentity { expected: 0x6B, found: 0x6C }));
    assert_eq!(part.start(1), Err(StartError::Busy));
    bus.done();
}
