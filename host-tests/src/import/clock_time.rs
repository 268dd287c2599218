//! Clock times in cells: `12:34:56.789`, alone or after a date, to seconds.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};

/// Seconds of a clock time: since midnight without a date, since 1970 with one.
#[must_use]
pub fn seconds(cell: &str) -> Option<f64> {
    // No clock time is shorter than 1:02:03, and none is without a colon.
    if cell.len() < 7 || !cell.contains(':') {
        return None;
    }
    let cell = cell.replace(',', ".");
    if let Ok(time) = DateTime::parse_from_rfc3339(&cell) {
        return Some(since_1970(time.naive_utc()));
    }
    let with_date = ["%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f", "%d.%m.%Y %H:%M:%S%.f"];
    if let Some(time) = with_date.iter().find_map(|format| NaiveDateTime::parse_from_str(&cell, format).ok()) {
        return Some(since_1970(time));
    }
    let time = NaiveTime::parse_from_str(&cell, "%H:%M:%S%.f").ok()?;
    Some(f64::from(time.num_seconds_from_midnight()) + f64::from(time.nanosecond()) * 1e-9)
}

fn since_1970(time: NaiveDateTime) -> f64 {
    let time = time.and_utc();
    time.timestamp() as f64 + f64::from(time.timestamp_subsec_nanos()) * 1e-9
}

/// Clock times of a day continue after midnight.
pub fn unfold_midnights(seconds: &mut [f64]) {
    const DAY_S: f64 = 86_400.0;
    let (mut added, mut last) = (0.0, f64::NAN);
    for time in seconds.iter_mut().filter(|time| time.is_finite()) {
        if *time + added < last - DAY_S / 2.0 {
            added += DAY_S;
        }
        *time += added;
        last = *time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_time_is_seconds_with_and_without_a_date() {
        assert_eq!(seconds("01:02:03.5"), Some(3_723.5));
        assert_eq!(seconds("01:02:03,5"), Some(3_723.5));
        assert_eq!(seconds("1970-01-02 00:00:01.25"), Some(86_401.25));
        assert_eq!(seconds("1970-01-01T02:00:00+01:00"), Some(3_600.0));
        assert_eq!(seconds("02.01.1970 00:00:01"), Some(86_401.0));
        assert_eq!(seconds("12.5"), None);
        assert_eq!(seconds("x:y:z:w"), None);
    }

    #[test]
    fn midnight_does_not_turn_time_back() {
        let mut times = [86_399.0, f64::NAN, 0.5, 2.0];
        unfold_midnights(&mut times);
        assert_eq!([times[0], times[2], times[3]], [86_399.0, 86_400.5, 86_402.0]);
    }
}
