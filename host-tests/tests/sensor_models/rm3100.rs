//! PNI 1017252: revision, gain, rates, order of the axes, and what ends the continuous mode.

use super::{Random, wire::*};
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, Rm3100, rm3100::I2C_ADDRESS},
};

/// All axes, data ready after all of them, started.
const CONTINUOUS: u8 = 0x79;

fn counts(wired: &Wired<Rm3100>) -> [i32; 3] {
    let bytes = wired.read::<9>(0x24);
    [0, 3, 6].map(|at| i32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0]) >> 8)
}

fn is_ready(wired: &Wired<Rm3100>) -> bool {
    let ready = wired.byte(0x34) & 0x80 != 0;
    assert_eq!(wired.part.borrow().interrupt(), ready);
    ready
}

#[test]
fn it_says_its_revision_on_both_buses_and_comes_up_idle() {
    let wired = Wired::rm3100(Conversions::AtItsRate);
    assert_eq!(wired.byte(0x36), 0x22);
    assert_eq!(wired.read_i2c::<1>(I2C_ADDRESS, 0x36), [0x22]);
    assert_eq!(wired.read::<6>(0x04), [0, 200, 0, 200, 0, 200]);
    assert_eq!(wired.byte(0x0B), 0x96);
    wired.play(&Sample { t_us: 1_000_000, ..Sample::default() });
    assert!(!is_ready(&wired));
}

/// Table 3-1: 20, 38 and 75 counts per microtesla at 50, 100 and 200 cycles, range 800 microtesla.
#[test]
fn a_count_is_within_half_of_the_field_and_held_at_the_range() {
    let mut random = Random::new(1);
    for (cycles, gain) in [(50_u8, 20.0_f32), (100, 38.0), (200, 75.0)] {
        let wired = Wired::rm3100(Conversions::WithEverySample);
        wired.write(0x04, &[0, cycles, 0, cycles, 0, cycles]);
        wired.write(0x01, &[CONTINUOUS]);
        for k in 1..200 {
            let field = random.vector(if k % 10 == 0 { 1_500.0 } else { 80.0 });
            wired.play(&Sample { t_us: k * 5_000, mag_ut: field, ..Sample::default() });
            assert!(is_ready(&wired));
            for (count, field) in counts(&wired).into_iter().zip(field) {
                let expected = (f64::from(field).clamp(-800.0, 800.0) * f64::from(gain)) as f32;
                assert!((count as f32 - expected).abs() < 0.52, "{count} for {expected}");
            }
            assert!(!is_ready(&wired), "read is not new");
        }
    }
}

/// Table 5-4, and the note that the cycle count limits it: 440 Hz of one axis at 200 cycles are 147 Hz of
/// three.
#[test]
fn readings_come_at_the_update_rate_or_as_fast_as_the_axes_allow() {
    for (tmrc, cycles, hz) in [(0x96_u8, 200_u8, 37.0), (0x95, 200, 75.0), (0x93, 200, 147.0), (0x93, 50, 300.0)] {
        let wired = Wired::rm3100(Conversions::AtItsRate);
        wired.write(0x04, &[0, cycles, 0, cycles, 0, cycles]);
        wired.write(0x0B, &[tmrc]);
        wired.write(0x01, &[CONTINUOUS]);
        let mut readings = 0;
        for k in 1..=4_000 {
            wired.play(&Sample { t_us: k * 500, ..Sample::default() });
            if is_ready(&wired) {
                readings += 1;
                counts(&wired);
            }
        }
        let rate = f64::from(readings) / 2.0;
        assert!((rate / hz - 1.0).abs() < 0.02, "{rate} Hz, {hz} asked for");
    }
}

/// Section 5.2: the axes are measured one after the other, each for its own time.
#[test]
fn later_axes_see_a_later_field() {
    let wired = Wired::rm3100(Conversions::AtItsRate);
    wired.write(0x01, &[CONTINUOUS]);
    let mut seen = None;
    for k in 0..=10 {
        // 1 microtesla a millisecond on every axis.
        wired.play(&Sample { t_us: k * 1_000, mag_ut: [k as f32; 3], ..Sample::default() });
        if is_ready(&wired) {
            seen = Some(counts(&wired).map(|count| count as f32 / 75.0));
        }
    }
    let axis_ms = 1e3 / 440.0;
    let [x, y, z] = seen.unwrap();
    assert!((x - 0.5 * axis_ms).abs() < 0.03, "{x}");
    assert!((y - x - axis_ms).abs() < 0.03 && (z - y - axis_ms).abs() < 0.03, "{x} {y} {z}");
}

#[test]
fn reading_cmm_or_writing_tmrc_ends_the_continuous_mode() {
    for ends in [
        |wired: &Wired<Rm3100>| assert_eq!(wired.byte(0x01), CONTINUOUS),
        |wired: &Wired<Rm3100>| {
            wired.write(0x0B, &[0x95]);
        },
    ] {
        let wired = Wired::rm3100(Conversions::AtItsRate);
        wired.write(0x01, &[CONTINUOUS]);
        wired.play(&Sample { t_us: 1_000, ..Sample::default() });
        ends(&wired);
        wired.play(&Sample { t_us: 1_000_000, ..Sample::default() });
        assert!(!is_ready(&wired));
        assert_eq!(wired.byte(0x01) & 1, 0);
    }
}

#[test]
fn a_single_measurement_is_one() {
    let wired = Wired::rm3100(Conversions::AtItsRate);
    wired.play(&Sample { mag_ut: [10.0, 20.0, -30.0], ..Sample::default() });
    wired.write(0x00, &[0x70]);
    wired.play(&Sample { t_us: 6_000, mag_ut: [10.0, 20.0, -30.0], ..Sample::default() });
    assert!(!is_ready(&wired));
    wired.play(&Sample { t_us: 7_000, mag_ut: [10.0, 20.0, -30.0], ..Sample::default() });
    assert!(is_ready(&wired));
    assert_eq!(counts(&wired), [750, 1_500, -2_250]);
    wired.play(&Sample { t_us: 1_000_000, ..Sample::default() });
    assert!(!is_ready(&wired));
}
