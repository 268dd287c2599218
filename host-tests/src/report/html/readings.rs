//! Readings of a flight: raw sensors with what is missing or clipped, calibrated totals with their limits, counts.

use meerkat_mwd::{Sample, SampleFlags};

use super::{Chart, Mark, Page, Series, Told, in_s, line, table};
use testbed::{flight::Calibrated, trace::clipping_is_known};

/// Stretches into which marks of a plot are gathered.
const MARKS: f64 = 400.0;

/// Picks a vector of a sample.
type Vector = fn(&Sample) -> [f32; 3];

/// Adds raw readings, totals and counts.
pub(super) fn add(page: &mut Page, told: &Told) {
    let span = told.span_s();
    let raw: [(&str, &str, f64, Vector, [SampleFlags; 2]); 3] = [
        (
            "Gyro, as read",
            "deg/s",
            1_f64.to_degrees(),
            |s| s.gyro_rad_s,
            [SampleFlags::GYRO_MISSING, SampleFlags::GYRO_CLIPPED],
        ),
        (
            "Accelerometer, as read",
            "m/s²",
            1.0,
            |s| s.accel_m_s2,
            [SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED],
        ),
        ("Magnetometer, as read", "µT", 1.0, |s| s.mag_ut, [SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED]),
    ];
    for (name, unit, factor, vector, [missing, clipped]) in raw {
        let axes = [("x", "x"), ("y", "y"), ("z", "z")].into_iter().enumerate();
        // A sensor may read in one sample of several: what it does not say is no break of its line.
        let read = || told.trace.samples.iter().filter(|s| !s.flags.contains(missing));
        let series: Vec<Series> = axes
            .map(|(k, (name, class))| {
                let points = read().map(|s| [in_s(s.t_us), factor * f64::from(vector(s)[k]), 0.0]).collect();
                line(name, class, points, span)
            })
            .collect();
        let fault = "the driver reports a fault";
        let mut marks = gathered(told, gaps(told, missing), "missing");
        marks.extend(gathered(told, flagged(told, clipped), "clipped"));
        marks.extend(gathered(told, flagged(told, SampleFlags::FAULT), fault));
        let about =
            if marks.is_empty() { "" } else { "Shaded: readings are missing or clipped; point at it to see which." };
        page.chart(Chart::new(name, unit, about, series).marked(&marks));
    }
    totals(page, told);
    let read = told.trace.samples.iter().filter(|s| !s.flags.contains(SampleFlags::TEMPERATURE_MISSING));
    let warmth = read.map(|s| [in_s(s.t_us), f64::from(s.temperature_c), 0.0]).collect();
    page.chart(Chart::new("Temperature", "°C", "", vec![line("temperature", "x", warmth, span)]));
    page.add(&counts(told));
}

/// Adds |G|, |B| and dip of the calibrated vectors with their references and limits.
fn totals(page: &mut Page, told: &Told) {
    let Some(watched) = told.watched else { return };
    let (earth, limits) = (&told.config.earth, &told.config.survey.limits);
    let span = told.span_s();
    let over_time = |of: &dyn Fn(&Calibrated) -> Option<f64>| -> Vec<[f64; 3]> {
        watched.calibrated.iter().filter_map(|c| Some([in_s(c.t_us), of(c)?, 0.0])).collect()
    };
    let norm = |v: [f32; 3]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    let levels = |reference: Option<f64>, limit: f64, unit: &str| -> Vec<(f64, String)> {
        reference.map_or_else(Vec::new, |reference| {
            [
                (reference, format!("expected {reference:.3} {unit}")),
                (reference - limit, format!("limits of a survey at rest, ± {limit:.3} {unit}")),
                (reference + limit, String::new()),
            ]
            .into()
        })
    };
    let gravity = over_time(&|c| c.force_m_s2.map(norm));
    let about = "Size of the calibrated specific force: gravity, and all vibration and shock on top.";
    let expected = levels(Some(earth.gravity_m_s2.into()), limits.gravity_m_s2.into(), "m/s²");
    page.chart(Chart::new("|G|", "m/s²", about, vec![line("|G|", "after", gravity, span)]).with_levels(expected));
    let field = over_time(&|c| c.field_ut.map(norm));
    let unknown = |value: Option<f32>| if value.is_none() { UNKNOWN_FIELD } else { "" };
    let about = &format!(
        "Size of the calibrated field. It should be that of the place; what changes it is a magnet or an error of the magnetometer.{}",
        unknown(earth.magnetic_field_ut)
    );
    let expected = levels(earth.magnetic_field_ut.map(f64::from), limits.field_ut.into(), "µT");
    page.chart(Chart::new("|B|", "µT", about, vec![line("|B|", "after", field, span)]).with_levels(expected));
    let dip = over_time(&|c| {
        let (g, b) = (c.force_m_s2?, c.field_ut?);
        let along: f64 = g.iter().zip(&b).map(|(g, b)| -f64::from(*g) * f64::from(*b)).sum();
        Some((along / (norm(g) * norm(b))).asin().to_degrees()).filter(|x| x.is_finite())
    });
    let about = &format!(
        "Angle of the field below the horizon, by the same sample's specific force: vibration shows in it.{}",
        unknown(earth.dip_rad)
    );
    let expected =
        levels(earth.dip_rad.map(|x| f64::from(x).to_degrees()), f64::from(limits.dip_rad).to_degrees(), "deg");
    page.chart(Chart::new("Dip", "deg", about, vec![line("dip", "after", dip, span)]).with_levels(expected));
}

/// Note for a reader who sees no limits.
const UNKNOWN_FIELD: &str = " No limits are drawn, because the recording does not say what the place should have; `cargo mwd field` prints it for --config.";

/// Time of each sample with a flag.
fn flagged(told: &Told, flag: SampleFlags) -> Vec<[f64; 2]> {
    let half_s = 0.5 * period_s(told);
    let samples = told.trace.samples.iter().filter(|sample| sample.flags.contains(flag));
    samples.map(|sample| in_s(sample.t_us)).map(|t_s| [t_s - half_s, t_s + half_s]).collect()
}

/// Times between two readings of a sensor, or between one and an end of the trace, in which it misses one by its own
/// usual step. A sensor that never reads has no curve.
fn gaps(told: &Told, missing: SampleFlags) -> Vec<[f64; 2]> {
    let read = told.trace.samples.iter().filter(|sample| !sample.flags.contains(missing));
    let times: Vec<f64> = read.map(|sample| in_s(sample.t_us)).collect();
    let mut steps: Vec<f64> = times.windows(2).filter_map(|pair| Some(pair.last()? - pair.first()?)).collect();
    steps.sort_by(f64::total_cmp);
    let Some(own_s) = steps.get(steps.len() / 2).copied() else { return Vec::new() };
    let [from_s, to_s] = told.span_s();
    // A sensor that does not keep step with the samples is late by up to one of them.
    let late_s = 1.5 * own_s + 0.4 * period_s(told);
    let ends = [from_s - own_s].into_iter().chain(times).chain([to_s + own_s]).collect::<Vec<_>>();
    let pairs = ends.windows(2).filter_map(|pair| Some([*pair.first()?, *pair.last()?]));
    pairs
        .filter(|[last, next]| next - last > late_s)
        .map(|[last, next]| [last + 0.5 * own_s, next - 0.5 * own_s])
        .collect()
}

/// Usual step between two samples, seconds.
fn period_s(told: &Told) -> f64 {
    1e-6 * f64::from(told.trace.nominal_period_us())
}

/// Marks of intervals; those that no plot could show apart are one.
fn gathered(told: &Told, intervals: Vec<[f64; 2]>, text: &str) -> Vec<Mark> {
    let [from_s, to_s] = told.span_s();
    let apart_s = (to_s - from_s) / MARKS;
    let mut spans: Vec<([f64; 2], usize)> = Vec::new();
    for [start_s, end_s] in intervals {
        match spans.last_mut() {
            Some(([_, until_s], count)) if start_s - *until_s < apart_s => (*until_s, *count) = (end_s, *count + 1),
            _ => spans.push(([start_s, end_s], 1)),
        }
    }
    let times = |count: usize| if count > 1 { format!(", {count} times") } else { String::new() };
    spans.into_iter().map(|(span_s, count)| Mark { span_s, text: format!("{text}{}", times(count)) }).collect()
}

/// Table of the counters that are not zero.
fn counts(told: &Told) -> String {
    let counters = &told.flight.counters;
    let facts = told.trace.facts();
    let lacking = |flag| facts.count(flag) as u64;
    let counts = [
        ("samples", counters.samples),
        ("without the gyro", lacking(SampleFlags::GYRO_MISSING)),
        ("without the accelerometer", lacking(SampleFlags::ACCEL_MISSING)),
        ("without the magnetometer", lacking(SampleFlags::MAG_MISSING)),
        ("without temperature", lacking(SampleFlags::TEMPERATURE_MISSING)),
        ("with a clipped sensor", counters.clipped.into()),
        ("out of order, refused", counters.out_of_order.into()),
        ("gaps in time", counters.gaps.into()),
        ("windows that were not ready in time", counters.overruns.into()),
    ];
    let rows = counts.iter().filter(|(_, count)| *count > 0);
    let mut out =
        table(&["readings", "count"], rows.map(|(name, count)| (false, vec![(*name).to_owned(), count.to_string()])));
    if !clipping_is_known(&told.config.full_scale) {
        out += "<p>Whether a sensor clipped cannot be known: the trace states no full scale.</p>\n";
    }
    out
}
