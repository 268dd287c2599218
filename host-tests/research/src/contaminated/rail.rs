use super::readings::Readings;

/// Samples that must share the largest reading of their axis, to the last bit, for it to be a full scale:
/// else the largest reading of a noisy gyro occurs once, or a few times if its resolution is coarse.
const FEWEST: usize = 10;

/// Marks samples in which an axis of the gyro is at a full scale that nothing states.
pub(super) fn at_gyro_rail(readings: &Readings) -> Vec<bool> {
    let mut at_rail = vec![false; readings.samples.len()];
    for axis in 0..3 {
        let largest = readings.samples.iter().map(|s| s.raw[axis].abs()).fold(0.0, f64::max);
        let meets = readings.samples.iter().map(|s| s.raw[axis].abs() >= largest);
        if meets.clone().filter(|meets| *meets).count() >= FEWEST {
            for (at_rail, meets) in at_rail.iter_mut().zip(meets) {
                *at_rail |= meets;
            }
        }
    }
    at_rail
}
