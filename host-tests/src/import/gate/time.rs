//! Rate, gaps, repeated and late rows, and the time that the sensors have in common.

use super::{
    super::{
        resolve::{in_words, name},
        units::Quantity,
    },
    Finding, Imported,
};

/// Rates that the pipeline takes, Hz (`Config::sample_period_us`).
const RATE_HZ: std::ops::RangeInclusive<f64> = 20.0..=10_000.0;
/// Share of dropped rows from which the clock itself is wrong.
const DROPPED: f64 = 0.05;
/// Share of the time that gaps may take.
const IN_GAPS: f64 = 0.2;
/// Least share of the gyro's time that a sensor with time stamps of its own covers. Units of time differ by sixty and
/// more, so that a wrong one leaves far less; of clocks that start apart nothing is known, and with less than half in
/// common most of the recording would be flown without that sensor.
const COVERED: f64 = 0.5;

pub(super) fn check(imported: &Imported) -> Vec<Finding> {
    let gyro = imported.gyro;
    let mut findings = Vec::new();
    let rate = gyro.rate_hz();
    let time = imported.map.gyro.time.as_deref().unwrap_or("rate_hz");
    let unit = imported.map.gyro.time_unit.as_deref().unwrap_or("s");
    if gyro.t_us.len() < 2 {
        findings.push(Finding::wrong(
            "one row has a time".into(),
            format!("name another column than {time:?} by time = \"...\""),
        ));
        return findings;
    }
    findings.push(if RATE_HZ.contains(&rate) {
        Finding::fine(format!(
            "rate {rate:.2} Hz, from the median step of {} {unit}",
            tidy(gyro.period_us() as f64 * 1e-6 / seconds_in(unit))
        ))
    } else {
        let fix = format!(
            "time_unit, now {unit:?}, or another column of time than {time:?}; the pipeline takes 20 Hz to 10 kHz"
        );
        Finding::wrong(format!("rate {rate:.3} Hz"), fix)
    });
    let duration = gyro.t_us.last().zip(gyro.t_us.first()).map_or(0, |(last, first)| last - first) as f64;
    let longest = gyro.t_us.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
    if gyro.gaps() > 0 {
        let lost: i64 =
            gyro.t_us.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 3 * gyro.period_us()).sum();
        let told = format!("{} gaps over three periods, the longest {:.3} s", gyro.gaps(), longest as f64 * 1e-6);
        findings.push(if lost as f64 > IN_GAPS * duration {
            let fix = "the gyro was not read all the time, or the file joins recordings: import them one by one".into();
            Finding::wrong(format!("{told}; they are {:.0} % of the time", 100.0 * lost as f64 / duration), fix)
        } else {
            Finding::note(told)
        });
    }
    findings.extend(covered(imported));
    for (series, part) in imported.all.iter().zip(imported.parts) {
        let dropped = series.dropped();
        if dropped == 0 {
            continue;
        }
        let (table, clock) = &series.clock;
        let told = format!(
            "{table}, {clock}: {dropped} rows dropped ({} repeat a time, {} are out of order, {} have none)",
            series.repeated, series.late, series.without_time
        );
        let share = dropped as f64 / (dropped + series.t_us.len()) as f64;
        findings.push(if share > DROPPED {
            let fix = format!("the clock {clock:?} is too coarse or not this sensor's: name another by time = \"...\" or rate_hz = ... in [{}]", name(part.quantity));
            Finding::wrong(format!("{told}, {:.0} % of all", 100.0 * share), fix)
        } else {
            Finding::note(told)
        });
        if imported.all.iter().all(|other| other.clock == series.clock) {
            break;
        }
    }
    findings
}

/// Sensors whose time stamps leave most of the gyro's time without a reading.
fn covered(imported: &Imported) -> Vec<Finding> {
    let Some((first, last)) = imported.gyro.t_us.first().zip(imported.gyro.t_us.last()) else { return Vec::new() };
    let mut findings = Vec::new();
    for (series, part) in imported.all.iter().zip(imported.parts) {
        // On the gyro's clock a sensor that has no reading is missing there, and no time stamp is wrong.
        let is_judged = matches!(part.quantity, Quantity::Accel | Quantity::Mag) && series.clock != imported.gyro.clock;
        let mut there =
            series.t_us.iter().zip(&series.rows).filter(|(_, row)| row[0].is_finite()).map(|(t_us, _)| t_us);
        let Some(from) = there.next().filter(|_| is_judged) else { continue };
        let to = there.next_back().unwrap_or(from);
        let covered_us = (to.min(last) - from.max(first)).max(0) as f64;
        let all_us = (last - first) as f64;
        if covered_us < COVERED * all_us {
            let told = format!(
                "the {} covers {:.3} s of the gyro's {:.3} s",
                in_words(part.quantity),
                covered_us * 1e-6,
                all_us * 1e-6
            );
            let unit = part.part.time_unit.as_deref().unwrap_or("none");
            let fix = format!(
                "name the unit of its time stamps by time_unit = \"...\" (now {unit:?}), or move its clock by \
                 time_offset_s = ..., in [{}] of --map",
                name(part.quantity)
            );
            findings.push(Finding::wrong(told, fix));
        }
    }
    findings
}

/// Without the last digits, which are a division's.
fn tidy(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn seconds_in(unit: &str) -> f64 {
    Quantity::Time.unit(unit).map_or(1.0, |unit| unit.factor)
}
