use super::*;

#[test]
fn every_tag_byte_has_even_parity() {
    for tag in [Tag::Gyro, Tag::Accelerometer, Tag::Temperature, Tag::Timestamp] {
        assert!((0..4).all(|slot| tag_byte(tag, slot).count_ones().is_multiple_of(2)));
    }
    // Gyroscope in time slot 0: tag 1 in the five upper bits.
    assert_eq!(tag_byte(Tag::Gyro, 0), 0b0000_1001);
}

#[test]
fn words_come_out_in_order_and_the_oldest_goes_when_there_is_no_room() {
    let mut fifo = Fifo::<3>::empty();
    for value in 0..5 {
        fifo.push(Tag::Gyro, [value; 6], 3, false);
    }
    assert!(fifo.overrun_latched && fifo.is_full());
    let values: [u8; 4] = core::array::from_fn(|_| (0..7).fold(0, |_, byte| fifo.read(byte)));
    assert_eq!(values, [2, 3, 4, 0]);
    let mut stopped = Fifo::<3>::empty();
    (0..5).for_each(|value| stopped.push(Tag::Gyro, [value; 6], 3, true));
    assert_eq!(core::array::from_fn::<u8, 3, _>(|_| (0..7).fold(0, |_, byte| stopped.read(byte))), [0, 1, 2]);
}
