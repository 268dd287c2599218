//! Words of a FIFO, sound and cut off.

use super::*;

/// A word with a tag of even parity, and its axes, low byte first.
fn word(sensor: u8, codes: [i16; 3]) -> [u8; WORD] {
    let tag = sensor << 3;
    let [[a, b], [c, d], [e, f]] = codes.map(i16::to_le_bytes);
    [tag | (tag.count_ones() % 2) as u8, a, b, c, d, e, f]
}

fn taken(bytes: &[u8]) -> Burst<2> {
    let mut burst = Burst::default();
    StFifo::new(1, 2, true).take(bytes, 0, &mut burst);
    burst
}

#[test]
fn no_word_is_believed_in_which_the_line_begins_to_idle() {
    let (gyro, accel) = ([20, -300, 5], [100, 200, 16_384]);
    let sound = [word(1, gyro), word(2, accel)].concat();
    assert_eq!(taken(&sound).frames()[0].codes, [Some(gyro.map(i32::from)), Some(accel.map(i32::from))]);
    for whole in 0..=sound.len() {
        let mut bytes = sound.clone();
        bytes[whole..].fill(IDLE);
        let burst = taken(&bytes);
        let read = burst.frames()[0].codes;
        assert_eq!(read[0], (whole >= WORD).then_some(gyro.map(i32::from)), "{whole} bytes are the part's");
        assert!(burst.corrupt > 0 || whole > WORD, "{whole}");
    }
    // A small negative code ends in the same byte, and is believed where the line goes on.
    let negative = [word(1, [20, -300, -5]), word(2, accel)].concat();
    assert_eq!(taken(&negative).frames()[0].codes[0], Some([20, -300, -5]));
}
