//! Lines thinned to what a screen can show, and packed for a page.

use base64::{Engine, engine::general_purpose::STANDARD};

/// Stretches of time into which a long line is cut: ten to each pixel column of a wide screen, so that a line can be
/// zoomed ten times before it loses detail.
pub const STRETCHES: usize = 10_000;

/// Largest whole number that stands for a value; the least of 16 bits stands for none.
const FULL: f64 = 32_767.0;
const NONE: i16 = i16::MIN;

/// A point: time in seconds, value, deviation (0 if none).
pub type Point = [f64; 3];

/// Points of a line over `from_s` to `to_s`: as they are where there are at most two a stretch, else the least and
/// the largest of each stretch in their order, at a quarter and at three quarters of it. A stretch without a point is
/// left out; one whose points have no value has none. `is_even` tells whether no stretch is left out.
pub struct Thinned {
    /// The points.
    pub points: Vec<Point>,
    /// True if they stand at a quarter and at three quarters of each stretch.
    pub is_even: bool,
}

/// Thins a line to `stretches`.
#[must_use]
pub fn thinned(points: &[Point], [from_s, to_s]: [f64; 2], stretches: usize) -> Thinned {
    if points.len() <= 2 * stretches || to_s <= from_s {
        return Thinned { points: points.to_vec(), is_even: false };
    }
    let width_s = (to_s - from_s) / stretches as f64;
    let mut is_even = true;
    let mut kept = Vec::with_capacity(2 * stretches);
    let mut rest = points;
    for stretch in 0..stretches {
        let start_s = from_s + width_s * stretch as f64;
        let is_last = stretch + 1 == stretches;
        let count = if is_last { rest.len() } else { rest.partition_point(|point| point[0] < start_s + width_s) };
        let (inside, after) = rest.split_at(count);
        rest = after;
        if inside.is_empty() {
            is_even = false;
            continue;
        }
        let finite = || inside.iter().filter(|point| point[1].is_finite());
        let least = finite().min_by(|a, b| a[1].total_cmp(&b[1]));
        let largest = finite().max_by(|a, b| a[1].total_cmp(&b[1]));
        let pair = match (least, largest) {
            (Some(a), Some(b)) if a[0] <= b[0] => [*a, *b],
            (Some(a), Some(b)) => [*b, *a],
            _ => [[0.0, f64::NAN, 0.0]; 2],
        };
        for (at, point) in [0.25, 0.75].into_iter().zip(pair) {
            kept.push([start_s + at * width_s, point[1], point[2]]);
        }
    }
    Thinned { points: kept, is_even }
}

/// Values as 16-bit whole numbers in base64, with the least value and the step that they count in.
pub struct Packed {
    /// Value that the number 0 stands for.
    pub middle: f64,
    /// Step of one.
    pub step: f64,
    /// The numbers, little end first; -32768 is no value.
    pub base64: String,
}

/// Packs values; each is off by at most a 131,068th of their range.
#[must_use]
pub fn packed(values: impl Iterator<Item = f64> + Clone) -> Packed {
    let finite = values.clone().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let (middle, step) =
        if low > high { (0.0, 1.0) } else { (0.5 * (low + high), (0.5 * (high - low) / FULL).max(1e-30)) };
    let number = |x: f64| if x.is_finite() { ((x - middle) / step).round().clamp(-FULL, FULL) as i16 } else { NONE };
    let bytes: Vec<u8> = values.flat_map(|x| number(x).to_le_bytes()).collect();
    Packed { middle, step, base64: STANDARD.encode(bytes) }
}

/// Times after `from_s` as tenths of a millisecond in 32 bits, little end first, in base64.
#[must_use]
pub fn packed_times(points: &[Point], from_s: f64) -> String {
    let bytes: Vec<u8> =
        points.iter().flat_map(|[t_s, ..]| (((t_s - from_s) * 1e4).round() as i32).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_thinned_line_keeps_every_extreme_and_no_more_than_two_points_a_stretch() {
        let points: Vec<Point> = (0..100_000).map(|k| [f64::from(k), f64::from(k % 977), f64::from(k % 3)]).collect();
        let thin = thinned(&points, [0.0, 100_000.0], 500);
        assert!(thin.is_even && thin.points.len() == 1_000);
        for pair in thin.points.chunks(2) {
            let stretch = (pair[0][0] / 200.0).floor() * 200.0;
            let inside: Vec<f64> =
                points.iter().filter(|[t, ..]| (stretch..stretch + 200.0).contains(t)).map(|p| p[1]).collect();
            let wanted = [inside.iter().copied().reduce(f64::min), inside.iter().copied().reduce(f64::max)];
            let mut kept = [pair[0][1], pair[1][1]];
            kept.sort_by(f64::total_cmp);
            assert_eq!(kept.map(Some), wanted);
        }
        assert!(!thinned(&points[..900], [0.0, 900.0], 500).is_even);
    }

    #[test]
    fn what_is_missing_stays_missing() {
        let points: Vec<Point> =
            (0..10_000).map(|k| [f64::from(k), if k < 5_000 { 1.0 } else { f64::NAN }, 0.0]).collect();
        let thin = thinned(&points, [0.0, 10_000.0], 100);
        assert!(thin.points.iter().all(|[t, x, _]| x.is_finite() == (*t < 5_000.0)));
    }

    #[test]
    fn what_was_never_said_is_left_out() {
        let points: Vec<Point> = (0..10_000).filter(|k| k / 500 % 2 == 0).map(|k| [f64::from(k), 1.0, 0.0]).collect();
        let thin = thinned(&points, [0.0, 10_000.0], 100);
        assert!(!thin.is_even && thin.points.len() == 100 && thin.points.iter().all(|[_, x, _]| *x == 1.0));
    }

    #[test]
    fn packed_values_come_back_to_within_half_a_step() {
        let values = [-3.0, f64::NAN, 0.123, 77.7];
        let packed = packed(values.into_iter());
        let bytes = STANDARD.decode(&packed.base64).unwrap();
        for (bytes, value) in bytes.chunks(2).zip(values) {
            let number = i16::from_le_bytes([bytes[0], bytes[1]]);
            let back = if number == NONE { f64::NAN } else { packed.middle + packed.step * f64::from(number) };
            assert!(value.is_nan() && back.is_nan() || (back - value).abs() <= 0.51 * packed.step, "{value} {back}");
        }
    }
}
