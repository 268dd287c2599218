//! Codes of sound sensors, and of those that jump, stand still or idle.

use super::*;

/// Log odds of one in 50.
const REPEATS: f32 = 3.9;

/// Codes of a sensor that swings by thousands, with some noise.
fn swinging(k: i32) -> [i32; 3] {
    let noise = k.wrapping_mul(7_919) % 7;
    let t = k as f32 * 0.03;
    [libm::sinf(t), libm::cosf(t), libm::sinf(2.0 * t + 1.0)].map(|x| (3_000.0 * x) as i32 + noise)
}

fn settled() -> Innovation {
    let mut innovation = Innovation::NEW;
    let believed = (0..200).filter(|k| innovation.believes(swinging(*k), 300.0, 30_000, REPEATS)).count();
    assert!(believed >= 195, "{believed}");
    innovation
}

#[test]
fn a_glitch_is_not_believed_and_a_new_level_is_soon() {
    let mut innovation = settled();
    let [x, y, z] = swinging(200);
    assert!(!innovation.believes([x, y ^ 1 << 12, z], 300.0, 30_000, REPEATS));
    assert!(innovation.believes(swinging(201), 300.0, 30_000, REPEATS));
    let raised = |k| swinging(k).map(|code| code + 9_000);
    let believed = [202, 203, 204, 205].map(|k| innovation.believes(raised(k), 300.0, 30_000, REPEATS));
    assert_eq!(believed, [false, true, true, true]);
}

#[test]
fn what_stands_still_in_motion_is_not_believed() {
    let mut innovation = settled();
    assert!(!innovation.believes(swinging(199), 300.0, 30_000, REPEATS), "all axes again");
    let mut innovation = settled();
    let dead: [bool; 3] = core::array::from_fn(|k| {
        let [x, _, z] = swinging(200 + k as i32);
        innovation.believes([x, 0, z], 300.0, 30_000, REPEATS)
    });
    assert_eq!(dead, [false; 3]);
    let mut railed = settled();
    let clipped = |k| {
        let [x, _, z] = swinging(k);
        [x, 30_000, z]
    };
    assert_eq!(
        (200..206).filter(|k| railed.believes(clipped(*k), 300.0, 30_000, REPEATS)).count(),
        5,
        "from the second on"
    );
}

/// Only the first byte of a word comes, and the line idles at one: x keeps its low byte, the others are -1.
#[test]
fn a_reading_that_ends_in_an_idle_line_is_never_believed() {
    for seed in 0..100 {
        let (mut innovation, mut state) = (Innovation::NEW, seed);
        let mut at_rest = || [-1_900.0, -630.0, -330.0].map(|mean| noisy(&mut state, mean, 6.0));
        assert!((0..100).filter(|_| innovation.believes(at_rest(), 520.0, 30_000, 6.9)).count() > 90);
        let idle = |[x, ..]: [i32; 3]| [x & 0xFF | -0x100, -1, -1];
        assert!((0..200).all(|_| !innovation.believes(idle(at_rest()), 520.0, 30_000, 6.9)), "seed {seed}");
        let late = (0..100).filter(|_| innovation.believes(at_rest(), 520.0, 30_000, 6.9)).count();
        assert!(late > 90, "{late}");
    }
}

/// Normal noise with this deviation about this mean, codes.
fn noisy(state: &mut u32, mean: f32, deviation: f32) -> i32 {
    let twelve = (0..12).fold(0.0, |sum, _| {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        sum + (*state >> 8) as f32 / 16_777_216.0
    });
    libm::roundf(mean + deviation * (twelve - 6.0)) as i32
}

/// Noise of data sheets at rest in codes: 0.6 and 1.3 of the ISM330DHCX's gyro and accelerometer, 1.1 of
/// the RM3100, 7 of the ICM-42688-P's gyro with its 20 bits, and more.
#[test]
fn a_sound_sensor_at_rest_loses_few_readings() {
    for (deviation, most) in
        [(0.3, 0.02), (0.6, 0.02), (1.1, 0.02), (1.3, 0.02), (7.0, 0.01), (30.0, 0.01), (300.0, 0.01)]
    {
        for mean in [0.0, 0.4, 20.0, 2_000.5] {
            let (mut innovation, mut state) = (Innovation::NEW, 7);
            let mut next = || core::array::from_fn(|_| noisy(&mut state, mean, deviation));
            let lost = (0..20_000).filter(|_| !innovation.believes(next(), 300.0, 30_000, REPEATS)).count();
            assert!((lost as f32) < most * 20_000.0, "{lost} of 20,000 at {mean} +- {deviation}");
        }
    }
}

#[test]
fn a_quiet_sensor_may_repeat_itself_and_one_that_never_moved_is_not_believed() {
    let mut quiet = Innovation::NEW;
    let codes = |k: i32| [k / 4 % 2, 5 + k / 6 % 2, -3 + k / 5 % 2];
    assert!((0..500).filter(|k| quiet.believes(codes(*k), 300.0, 30_000, REPEATS)).count() > 460);
    let mut dead = Innovation::NEW;
    assert!((0..500).all(|k| !dead.believes([k % 9, 0, k % 7], 300.0, 30_000, REPEATS)));
}
