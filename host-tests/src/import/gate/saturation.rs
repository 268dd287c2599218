//! Saturation: readings that stay at the end of a sensor's range.
//!
//! An end of the range is known by readings that equal an extreme to the last digit, as the estimator knows a gyro's
//! rail, wherever it lies: of one end of an axis, and of the largest size of all axes, whose range is one. Two things
//! repeat an extreme, too, and are told apart by tests of their chance: a smooth peak in coarse digits, and an axis
//! that stands still in them.

use statrs::distribution::{Binomial, DiscreteCDF};

use super::{
    super::{median::median, resolve::in_words, units::Quantity},
    Finding, Imported,
    sizes::{FIELD, GRAVITY},
};

/// Chance of a finding in a recording without saturation: one in a thousand, over three sensors with both ends of three
/// axes and all axes together.
const CHANCE: f64 = 1e-3 / 21.0;
/// Values next to an extreme that together occur at least as often as it does in a smooth peak: within `n` steps
/// of the digits below its top a parabola stays for a time that grows with the root of `n`, and that of 4 is 2.
const NEXT: usize = 3;
/// Share of readings that equal the one before, from which digits are so coarse that to come to a value anew says
/// nothing: most do not change.
const COARSE: f64 = 0.5;
/// Share of readings in saturation from which the recording is wrong.
const SHARE: f64 = 0.05;
/// Readings of about the largest size, and that size over the median, from which a sensor saturates whose digits
/// a calibration has moved.
const ABOUT: (usize, f64) = (10, 2.0);

pub(super) fn check(imported: &Imported, quantity: Quantity, there: &[[f64; 3]]) -> Option<Finding> {
    let (told, limit, count) = at_an_end(quantity, there).or_else(|| about_the_largest(quantity, there))?;
    let keys = imported.keys;
    let (key, known) = match quantity {
        Quantity::Gyro => ("gyro_full_scale_rad_s", keys.gyro_full_scale_rad_s),
        Quantity::Accel => ("accel_full_scale_m_s2", keys.accel_full_scale_m_s2),
        _ => ("mag_full_scale_ut", keys.mag_full_scale_ut),
    };
    Some(if count as f64 > SHARE * there.len() as f64 {
        Finding::wrong(told, "the full scale was too small for this motion; --force imports it".into())
    } else if known.is_some() {
        Finding::note(told)
    } else {
        let fix = format!("{key} = {limit:.4} in [keys], so that these samples count as clipped");
        Finding { fix: Some(fix), ..Finding::note(told) }
    })
}

/// Readings at an extreme of their axis, if they are too many for chance: what is told, the lowest end of the
/// range, and the number of samples.
fn at_an_end(quantity: Quantity, there: &[[f64; 3]]) -> Option<(String, f64, usize)> {
    // In a trace's digits: a mean of equal readings may differ in the last of a double's.
    let there: Vec<[f64; 3]> = there.iter().map(|row| row.map(|x| f64::from(x as f32))).collect();
    let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| there.iter().map(|row| row[axis]).collect());
    let repeating = repeating(&axes);
    let is_an_end = |readings: &[f64]| end_of_range(readings, repeating).filter(|end| *end > least_range(quantity));
    let sizes: Vec<f64> = there.iter().map(|row| row.iter().fold(0.0, |most, x| x.abs().max(most))).collect();
    let of_all = is_an_end(&sizes);
    let mut ends = Vec::new();
    for (axis, readings) in axes.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let turned: Vec<f64> = readings.iter().map(|x| sign * x).collect();
            let end = of_all.filter(|end| turned.contains(end)).or_else(|| is_an_end(&turned));
            ends.extend(end.map(|end| (axis, sign * end)));
        }
    }
    let lowest = ends.iter().map(|(_, end)| end.abs()).fold(f64::INFINITY, f64::min);
    let is_at_one = |row: &&[f64; 3]| ends.iter().any(|(axis, end)| row[*axis] == *end);
    let count = there.iter().filter(is_at_one).count();
    let places: Vec<String> = ends.iter().map(|(axis, end)| format!("{} {end:.4}", ["x", "y", "z"][*axis])).collect();
    let told = format!("the {} saturates: {count} samples stay at {}", in_words(quantity), places.join(", "));
    (!ends.is_empty()).then_some((told, lowest, count))
}

/// Size that a range holds for certain: an axis that stands still has an extreme, too, and there it is gravity or
/// the earth's field.
const fn least_range(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Accel => *GRAVITY.end(),
        Quantity::Mag => *FIELD.end(),
        _ => 0.0,
    }
}

/// Share of readings that equal the one before, of those that are at no extreme of their axis.
fn repeating(axes: &[Vec<f64>; 3]) -> f64 {
    let (mut same, mut all) = (0.0, 0.0);
    for readings in axes {
        let least = readings.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = readings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_inside = |x: f64| least < x && x < largest;
        for pair in readings.windows(2).filter(|pair| pair.iter().all(|x| is_inside(*x))) {
            same += f64::from(u8::from(pair[0] == pair[1]));
            all += 1.0;
        }
    }
    // The mean after so many trials where before them every share was as likely (Laplace's rule of succession).
    (same + 1.0) / (all + 2.0)
}

/// The largest of these readings, if it is the end of a range.
fn end_of_range(readings: &[f64], repeating: f64) -> Option<f64> {
    let mut sorted = readings.to_vec();
    sorted.sort_unstable_by(|one, other| other.total_cmp(one));
    let mut values = sorted.chunk_by(|one, other| one == other);
    let at_it = values.next()?;
    let end = *at_it.first()?;
    let next: Vec<&[f64]> = values.take(NEXT).collect();
    // An axis that never changes is dead.
    let least = *next.last()?.first()?;
    let among = next.iter().map(|value| value.len()).sum::<usize>();
    let stays = readings.windows(2).filter(|pair| pair[0] == end && pair[1] == end).count();
    // Number of times that the readings come to the extreme, or to one of the values next to it.
    let comes = |is_it: &dyn Fn(f64) -> bool| {
        let first = usize::from(readings.first().is_some_and(|x| is_it(*x)));
        first + readings.windows(2).filter(|pair| pair[0] != pair[1] && is_it(pair[1])).count()
    };
    let (to_it, to_next) = (comes(&|x| x == end), comes(&|x| least <= x && x < end));
    let is_no_peak = chance_of(at_it.len(), at_it.len() + among, 0.5) < CHANCE;
    let is_no_rest = chance_of(stays, at_it.len(), repeating) < CHANCE
        || (repeating < COARSE && chance_of(to_it, to_it + to_next, 0.5) < CHANCE);
    (is_no_peak && is_no_rest).then_some(end)
}

/// Chance of at least `count` of `all`, each of which has the chance `each`.
fn chance_of(count: usize, all: usize, each: f64) -> f64 {
    let Some(below) = count.checked_sub(1) else { return 1.0 };
    // The chance is a share: it cannot fail.
    Binomial::new(each, all as u64).map_or(1.0, |binomial| binomial.sf(below as u64))
}

/// Readings that stay within a thousandth of the largest, far from what is usual.
fn about_the_largest(quantity: Quantity, there: &[[f64; 3]]) -> Option<(String, f64, usize)> {
    let largest = |row: &[f64; 3]| row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let limit = there.iter().map(largest).fold(0.0, f64::max);
    // A reading that saturates stays at the end of its range for more than one sample.
    let is_there = |row: &[f64; 3]| largest(row) >= 0.999 * limit;
    let count = there.windows(2).filter(|pair| is_there(&pair[0]) && is_there(&pair[1])).count();
    let typical = median(there.iter().map(largest)).unwrap_or(f64::NAN);
    let told = format!("the {} saturates at {limit:.4} in {count} samples", in_words(quantity));
    (count >= ABOUT.0 && limit >= ABOUT.1 * typical).then_some((told, limit, count))
}
