//! Clock times in cells: `12:34:56.789`, alone or after a date, to seconds.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};

/// Clock time of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockTime {
    /// Seconds since midnight without a date, since 1970 with one.
    pub seconds: f64,
    /// True if a date stands before it.
    pub has_date: bool,
}

impl ClockTime {
    /// Reads a cell; `None` if it holds no clock time.
    #[must_use]
    pub fn of(cell: &str) -> Option<Self> {
        // No clock time is shorter than 1:02:03, and none is without a colon.
        if cell.len() < 7 || !cell.contains(':') {
            return None;
        }
        let cell = cell.replace(',', ".");
        if let Ok(time) = DateTime::parse_from_rfc3339(&cell) {
            return Some(Self::since_1970(time.naive_utc()));
        }
        let formats = ["%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f", "%d.%m.%Y %H:%M:%S%.f"];
        if let Some(time) = formats.iter().find_map(|format| NaiveDateTime::parse_from_str(&cell, format).ok()) {
            return Some(Self::since_1970(time));
        }
        let time = NaiveTime::parse_from_str(&cell, "%H:%M:%S%.f").ok()?;
        let seconds = f64::from(time.num_seconds_from_midnight()) + f64::from(time.nanosecond()) * 1e-9;
        Some(Self { seconds, has_date: false })
    }

    fn since_1970(time: NaiveDateTime) -> Self {
        let time = time.and_utc();
        let seconds = time.timestamp() as f64 + f64::from(time.timestamp_subsec_nanos()) * 1e-9;
        Self { seconds, has_date: true }
    }
}

/// Makes times of a day continue after midnight. Times with a date do so by themselves.
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
        let seconds = |cell| ClockTime::of(cell).map(|time| time.seconds);
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
