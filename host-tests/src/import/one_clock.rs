//! Sensors of different rates on one clock: the gyro's.
//!
//! The gyro is integrated, so that its readings stay where they are. The accelerometer is integrated, too:
//! it gets a value at each of the gyro's times, on the line between the readings before and after, or the
//! mean of its readings around if it is faster. A field is a measurement, and counting one twice would make
//! it surer than it is: each reading of a slower magnetometer counts once, moved along the line to the
//! gyro's nearest time, and the times between stay empty. Nothing is interpolated across a gap.

use super::series::Series;

/// A sensor is faster than the gyro from here on: its readings are averaged.
const FASTER: f64 = 1.5;

/// Way in which a sensor came on the gyro's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// Its rows are the gyro's.
    SameRows,
    /// On the line between two readings.
    Interpolated,
    /// Mean of the readings around.
    Averaged,
    /// Each reading once, at the nearest time.
    EachOnce,
    /// Its readings at times that are the gyro's, too.
    SharedTimes,
}

impl How {
    /// In words.
    #[must_use]
    pub const fn told(self) -> &'static str {
        match self {
            Self::SameRows => "on the gyro's rows",
            Self::Interpolated => "interpolated between its readings at the gyro's times",
            Self::Averaged => "averaged around the gyro's times",
            Self::EachOnce => "each reading once, at the gyro's nearest time",
            Self::SharedTimes => "where its time is one of the gyro's",
        }
    }
}

/// Values of `sensor` at the gyro's times, NaN where there is none; `is_measured_once` for a sensor whose
/// readings count once each.
#[must_use]
pub fn on_clock(gyro: &Series, sensor: &Series, is_measured_once: bool) -> (Vec<[f64; 4]>, How) {
    if gyro.t_us == sensor.t_us {
        return (sensor.rows.clone(), How::SameRows);
    }
    let there: Vec<(i64, [f64; 4])> =
        sensor.t_us.iter().copied().zip(sensor.rows.iter().copied()).filter(|(_, row)| row[0].is_finite()).collect();
    let (period, gyro_period) = (sensor.period_us().max(1), gyro.period_us().max(1));
    if period as f64 * FASTER < gyro_period as f64 {
        return (averaged(&gyro.t_us, &there, gyro_period), How::Averaged);
    }
    let mut rows: Vec<[f64; 4]> = Vec::with_capacity(gyro.t_us.len());
    let mut next = 0;
    for &t_us in &gyro.t_us {
        while there.get(next).is_some_and(|(time, _)| *time < t_us) {
            next += 1;
        }
        rows.push(between(there.get(next.wrapping_sub(1)), there.get(next), t_us, period));
    }
    if !is_measured_once || period as f64 <= FASTER * gyro_period as f64 {
        return (rows, How::Interpolated);
    }
    let mut kept = vec![[f64::NAN; 4]; rows.len()];
    for (time, _) in &there {
        let after = gyro.t_us.partition_point(|t_us| t_us < time);
        let distance = |index: usize| gyro.t_us.get(index).map_or(i64::MAX, |t_us| (t_us - time).abs());
        let nearest = if after > 0 && distance(after - 1) <= distance(after) { after - 1 } else { after };
        if distance(nearest) <= gyro_period
            && let (Some(place), Some(row)) = (kept.get_mut(nearest), rows.get(nearest))
        {
            *place = *row;
        }
    }
    (kept, How::EachOnce)
}

/// Values of `sensor` at the times that it shares with the gyro, NaN at the others, and how many of its readings those
/// are: nothing is interpolated.
#[must_use]
pub fn at_shared_times(gyro: &Series, sensor: &Series) -> (Vec<[f64; 4]>, How, usize) {
    if gyro.t_us == sensor.t_us {
        return (sensor.rows.clone(), How::SameRows, sensor.rows.len());
    }
    let mut rows = vec![[f64::NAN; 4]; gyro.t_us.len()];
    let mut shared = 0;
    for (time, row) in sensor.t_us.iter().zip(&sensor.rows) {
        if let Some(place) = gyro.t_us.binary_search(time).ok().and_then(|at| rows.get_mut(at)) {
            *place = *row;
            shared += 1;
        }
    }
    (rows, How::SharedTimes, shared)
}

/// The value at a time between two readings that are no gap apart; at most a period beyond one, that one.
fn between(before: Option<&(i64, [f64; 4])>, after: Option<&(i64, [f64; 4])>, t_us: i64, period: i64) -> [f64; 4] {
    match (before, after) {
        (_, Some((time, row))) if *time == t_us => *row,
        (Some((t0, a)), Some((t1, b))) if t1 - t0 <= 3 * period => {
            let share = (t_us - t0) as f64 / (t1 - t0) as f64;
            std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]))
        }
        _ => [f64::NAN; 4],
    }
}

fn averaged(times: &[i64], readings: &[(i64, [f64; 4])], period: i64) -> Vec<[f64; 4]> {
    let around = |&t_us: &i64| {
        let from = readings.partition_point(|(time, _)| 2 * time < 2 * t_us - period);
        let to = readings.partition_point(|(time, _)| 2 * time < 2 * t_us + period);
        let some = &readings[from..to];
        std::array::from_fn(|axis| some.iter().map(|(_, row)| row[axis]).sum::<f64>() / some.len() as f64)
    };
    times.iter().map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(period_us: i64, count: i64, from_us: i64) -> Series {
        let t_us: Vec<i64> = (0..count).map(|index| from_us + index * period_us).collect();
        let rows = t_us.iter().map(|&t| [t as f64 * 1e-6, 1.0, 2.0, 0.0]).collect();
        Series { t_us, rows, clock: (period_us.to_string(), String::new()), ..Series::default() }
    }

    #[test]
    fn a_ramp_stays_the_same_ramp_at_every_rate() {
        let gyro = ramp(5_000, 200, 100_000);
        for (period, once, how) in [
            (12_000, false, How::Interpolated),
            (1_000, false, How::Averaged),
            (20_000, true, How::EachOnce),
            (5_000, true, How::Interpolated),
        ] {
            let (rows, told) = on_clock(&gyro, &ramp(period, 1_200_000 / period, 0), once);
            assert_eq!(told, how);
            let there: Vec<_> = gyro.t_us.iter().zip(&rows).filter(|(_, row)| row[0].is_finite()).collect();
            for &(&t_us, row) in &there {
                assert!((row[0] - t_us as f64 * 1e-6).abs() < 6e-4, "{how:?} {t_us} {row:?}");
            }
            // One value a reading, or one at every time.
            let expected = if how == How::EachOnce { 50 } else { 200 };
            assert!(there.len().abs_diff(expected) <= 1, "{how:?}: {}", there.len());
        }
    }

    #[test]
    fn nothing_is_interpolated_across_a_gap_nor_beyond_the_ends() {
        let gyro = ramp(5_000, 400, 0);
        let mut accel = ramp(10_000, 150, 50_000);
        accel.t_us.drain(50..60);
        accel.rows.drain(50..60);
        let (rows, _) = on_clock(&gyro, &accel, false);
        let empty = |from: usize, to: usize| rows[from..to].iter().all(|row| row[0].is_nan());
        assert!(empty(0, 10) && empty(109, 130) && empty(309, 400));
        assert!(rows[130..309].iter().all(|row| row[0].is_finite()));
    }
}
