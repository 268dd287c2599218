//! DS13012: identification, ranges, rates, FIFO, reset.

use super::{Random, wire::*};
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, ism330dhcx::I2C_ADDRESS},
};

const STANDARD_GRAVITY: f32 = 9.806_65;

fn truth(t_us: u64, random: &mut Random, rate: f32, force: f32) -> Sample {
    Sample {
        t_us,
        gyro_rad_s: random.vector(rate),
        accel_m_s2: random.vector(force),
        temperature_c: 25.0 + random.within(60.0),
        ..Sample::default()
    }
}

#[test]
fn it_says_who_it_is_on_both_buses_and_comes_up_powered_down() {
    let wired = Wired::ism330dhcx(Conversions::AtItsRate);
    assert_eq!(wired.byte(0x0F), 0x6B);
    assert_eq!(wired.read_i2c::<1>(I2C_ADDRESS, 0x0F), [0x6B]);
    assert_eq!(wired.read::<4>(0x10), [0, 0, 0x04, 0]);
    wired.write(0x0F, &[0]);
    assert_eq!(wired.byte(0x0F), 0x6B, "read only");
    wired.play(&Sample { t_us: 1_000_000, ..Sample::default() });
    assert_eq!(wired.byte(0x1E), 0, "nothing converts");
}

/// Table "Mechanical characteristics": FS_XL and FS_G with their sensitivities.
#[test]
fn a_word_is_within_half_an_lsb_in_every_range_and_saturates_beyond() {
    let mut random = Random::new(1);
    let accel = [(0b00, 0.061e-3), (0b01, 0.488e-3), (0b10, 0.122e-3), (0b11, 0.244e-3)];
    let gyro: [(u8, f32); 6] =
        [(0b0010, 4.375e-3), (0b0000, 8.75e-3), (0b0100, 17.5e-3), (0b1000, 35e-3), (0b1100, 70e-3), (0b0001, 140e-3)];
    for (accel_range, accel_g) in accel {
        for (gyro_range, gyro_dps) in gyro {
            let wired = Wired::ism330dhcx(Conversions::WithEverySample);
            wired.write(0x10, &[0x60 | accel_range << 2, 0x60 | gyro_range]);
            let (force, rate) = (accel_g * STANDARD_GRAVITY, gyro_dps.to_radians());
            for k in 1..100 {
                let sample = truth(k * 2_500, &mut random, 40_000.0 * rate, 40_000.0 * force);
                wired.play(&sample);
                assert_eq!(wired.byte(0x1E), 0b111);
                let read = wired.read::<14>(0x20);
                assert_eq!(wired.byte(0x1E), 0, "read is not new");
                let check = |word: i16, truth: f32, lsb: f32| {
                    let counts = f64::from(truth) / f64::from(lsb);
                    let expected = counts.clamp(-32_768.0, 32_767.0);
                    assert!((f64::from(word) - expected).abs() < 0.51, "{word} for {counts}");
                };
                (0..3).for_each(|axis| check(words(&read[2..8])[axis], sample.gyro_rad_s[axis], rate));
                (0..3).for_each(|axis| check(words(&read[8..14])[axis], sample.accel_m_s2[axis], force));
                check(i16::from_le_bytes([read[0], read[1]]), sample.temperature_c - 25.0, 1.0 / 256.0);
            }
        }
    }
}

/// Words that the FIFO hands out: tag, time slot, data. Parity is checked.
fn drain(wired: &Wired<meerkat_mwd::emulation::Ism330dhcx>, count: usize) -> Vec<(u8, u8, [i16; 3])> {
    (0..count)
        .map(|_| {
            let word = wired.read::<7>(0x78);
            assert_eq!(word[0].count_ones() % 2, 0, "parity of {:#04x}", word[0]);
            (word[0] >> 3, word[0] >> 1 & 3, words(&word[1..]))
        })
        .collect()
}

fn level(wired: &Wired<meerkat_mwd::emulation::Ism330dhcx>) -> (usize, u8) {
    let [low, high] = wired.read::<2>(0x3A);
    (usize::from(u16::from_le_bytes([low, high & 3])), high)
}

#[test]
fn the_fifo_gets_words_at_the_batch_rates() {
    let rates = [(4_u8, 104), (5, 208), (6, 416)];
    for (code, hz) in rates {
        let wired = Wired::ism330dhcx(Conversions::AtItsRate);
        // Gyro batched at its rate, accelerometer at half of it; continuous mode.
        wired.write(0x09, &[code << 4 | (code - 1), 0x06]);
        wired.write(0x10, &[code << 4, code << 4]);
        let (mut gyro, mut accel) = (0, 0);
        let mut random = Random::new(2);
        for k in 1..=200 {
            wired.play(&truth(k * 5_000, &mut random, 1.0, 1.0));
            let count = level(&wired).0;
            for (tag, ..) in drain(&wired, count) {
                gyro += usize::from(tag == 1);
                accel += usize::from(tag == 2);
            }
        }
        assert!(usize::abs_diff(gyro, hz) <= 1 && usize::abs_diff(accel, hz / 2) <= 1, "{hz} Hz: {gyro}, {accel}");
    }
}

/// Conversions between two samples of the truth are on the line between them.
#[test]
fn conversions_at_its_rate_follow_a_ramp() {
    let wired = Wired::ism330dhcx(Conversions::AtItsRate);
    wired.write(0x09, &[0x60, 0x06]);
    wired.write(0x11, &[0x60]);
    let period_s = 1.0 / 416.0;
    for k in 0..=100 {
        let rate = 0.1 * k as f32 * 0.005;
        wired.play(&Sample { t_us: k * 5_000, gyro_rad_s: [rate, -rate, 0.0], ..Sample::default() });
    }
    let (count, _) = level(&wired);
    for (index, (_, slot, word)) in drain(&wired, count).into_iter().enumerate() {
        let t_s = (index + 1) as f32 * period_s;
        let expected = 0.1 * t_s / 8.75e-3_f32.to_radians();
        assert!((f32::from(word[0]) - expected).abs() < 0.6, "{index}: {} for {expected}", word[0]);
        assert_eq!(word[1], -word[0]);
        assert_eq!(usize::from(slot), (index + 1) % 4);
    }
}

#[test]
fn the_watermark_and_the_overrun_show_and_the_oldest_words_go() {
    let wired = Wired::ism330dhcx(Conversions::WithEverySample);
    wired.write(0x07, &[6, 0, 0x60, 0x06]);
    wired.write(0x0D, &[0b1000]);
    wired.write(0x11, &[0x60]);
    let step = 8.75e-3_f32.to_radians();
    let play = |k: u64| {
        wired.play(&Sample { t_us: k * 2_500, gyro_rad_s: [k as f32 * step, 0.0, 0.0], ..Sample::default() });
    };
    for k in 1..=512 {
        play(k);
        let (words, status) = level(&wired);
        assert_eq!((words, status >> 7 == 1), (k as usize, k >= 6));
        assert_eq!(wired.part.borrow().interrupt(), k >= 6);
        assert_eq!(status >> 5 & 1 == 1, k == 512, "full");
        assert_eq!(status & 0b100_1000, 0, "no overrun yet");
    }
    (513..=520).for_each(play);
    let (words, status) = level(&wired);
    assert_eq!((words, status & 0b100_1000), (512, 0b100_1000));
    assert_eq!(level(&wired).1 & 0b1000, 0, "the latch falls when it is read");
    let values: Vec<i16> = drain(&wired, 512).into_iter().map(|(_, _, word)| word[0]).collect();
    assert_eq!(values, (9..=520).collect::<Vec<i16>>());
    assert_eq!(level(&wired), (0, 0));
    assert_eq!(wired.byte(0x78), 0, "an empty FIFO has no tag");
}

#[test]
fn a_burst_comes_round_from_word_to_word() {
    let wired = Wired::ism330dhcx(Conversions::WithEverySample);
    wired.write(0x09, &[0x66, 0x06]);
    wired.write(0x10, &[0x60, 0x60]);
    let mut random = Random::new(3);
    (1..=2).for_each(|k| wired.play(&truth(k * 2_500, &mut random, 1.0, 10.0)));
    let burst = wired.read::<28>(0x78);
    let tags: Vec<u8> = burst.chunks(7).map(|word| word[0] >> 3).collect();
    assert_eq!(tags, [1, 2, 1, 2]);
    let slots: Vec<u8> = burst.chunks(7).map(|word| word[0] >> 1 & 3).collect();
    assert_eq!((slots[0], slots[2]), (slots[1], slots[3]));
    assert_ne!(slots[0], slots[2]);
}

#[test]
fn a_reset_takes_its_time_and_leaves_the_defaults() {
    let wired = Wired::ism330dhcx(Conversions::WithEverySample);
    wired.write(0x10, &[0x60, 0x6C]);
    wired.write(0x0A, &[0x06]);
    wired.play(&Sample { t_us: 1_000, ..Sample::default() });
    wired.write(0x12, &[0x05]);
    assert_eq!(wired.byte(0x12) & 1, 1, "under way");
    wired.write(0x10, &[0x60]);
    wired.now_us.set(1_051);
    assert_eq!(wired.read::<3>(0x10), [0, 0, 0x04]);
    assert_eq!(level(&wired), (0, 0));
}

#[test]
fn the_timestamp_counts_25_us() {
    let wired = Wired::ism330dhcx(Conversions::WithEverySample);
    wired.now_us.set(7_000);
    assert_eq!(wired.read::<4>(0x40), [0; 4]);
    wired.write(0x19, &[0x20]);
    wired.now_us.set(2_007_000);
    assert_eq!(u32::from_le_bytes(wired.read::<4>(0x40)), 80_000);
    wired.write(0x42, &[0xAA]);
    assert_eq!(u32::from_le_bytes(wired.read::<4>(0x40)), 0);
}
