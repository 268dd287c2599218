//! A calibration as a page: what goes on record and why, and the errors before and after.

use meerkat_mwd::compensation::VectorModel;

use super::{Page, Plot, Series, Sources, chart::in_digits, escape::escape, fixed, sentence, table};
use crate::{
    calibrate::{Calibration, print_account, record, sensor::SensorCalibration, verdict::Verdict},
    layout::Layout,
};

/// The whole page, of a calibration from `sources`.
#[must_use]
pub fn page(calibration: &Calibration, sources: &Sources) -> String {
    let title = format!("Calibration from {}", calibration.traces.join(", "));
    let mut page = Page::new(&title, [0.0, 1.0]);
    page.head(&first_screen(&title, calibration));
    page.section("Accelerometer");
    let accel = calibration.accel.as_ref();
    sensor(&mut page, accel, calibration.accel_model(), "m/s²", "rests");
    page.section("Magnetometer");
    sensor(&mut page, calibration.mag.as_ref(), calibration.mag_model(), "µT", "readings");
    if let Some(record) = record::text(calibration) {
        page.section("The record");
        page.add("<p>Save it as a file and fly with it: <code>cargo mwd replay TRACE --config FILE.toml</code>.</p>\n");
        page.add(&format!("<pre tabindex=\"0\">{}</pre>\n", escape(&record)));
    }
    let mut account = Vec::new();
    // Writing to memory does not fail.
    let _ = print_account(&mut account, Layout::Table, calibration);
    page.section("Every figure");
    page.add(&format!("<pre tabindex=\"0\">{}</pre>\n", escape(&String::from_utf8_lossy(&account))));
    page.section("Where this comes from");
    page.add(&sources.html());
    page.finish()
}

fn first_screen(title: &str, calibration: &Calibration) -> String {
    let told = |name: &str, sensor: Option<&SensorCalibration>, none: String| match sensor.map(|sensor| &sensor.verdict)
    {
        Some(Verdict::Calibrated) => (true, format!("The {name} is calibrated: all new values go on record.")),
        Some(Verdict::Partly(why)) => {
            (false, format!("The {name} is calibrated in part, the rest stays as it was: {why}."))
        }
        Some(Verdict::Kept(why)) => (false, format!("The {name} keeps its old values: {why}.")),
        None => (false, format!("The {name} keeps its old values: {none}.")),
    };
    let both = [
        told("accelerometer", calibration.accel.as_ref(), calibration.no_accel()),
        told("magnetometer", calibration.mag.as_ref(), calibration.no_mag()),
    ];
    let class = if both.iter().all(|(is_new, _)| *is_new) { "good" } else { "caution" };
    let sentences: String =
        both.iter().map(|(_, text)| format!("<p class=\"sentence\">{}</p>\n", escape(text))).collect();
    let notes: String =
        calibration.notes.iter().map(|note| format!("<li>{}</li>\n", escape(&sentence(note)))).collect();
    let list = if notes.is_empty() { String::new() } else { format!("<ul>\n{notes}</ul>\n") };
    format!(
        "<header>\n<h1>{}</h1>\n<div class=\"verdict {class}\">\n{sentences}{list}</div>\n</header>\n",
        escape(title)
    )
}

/// Readings up to which each is marked.
const MARKED: usize = 100;

/// Drawing of the error of every reading, before and after.
fn errors(sensor: &SensorCalibration, unit: &str, of: &str) -> String {
    let both = sensor.errors();
    let ends = both.iter().flatten().copied().filter(|error| error.is_finite());
    let (low, high) = ends.fold((0.0_f64, 0.0_f64), |(low, high), error| (low.min(error), high.max(error)));
    let count = sensor.observations.len();
    if count < 2 || low >= high {
        return String::new();
    }
    let margin = 0.05 * (high - low);
    let [before, after] =
        both.map(|errors| (1_u32..).zip(errors).map(|(k, error)| [f64::from(k), error, 0.0]).collect());
    let series = |name: &str, class: &'static str, points: Vec<[f64; 3]>| Series {
        name: name.to_owned(),
        class,
        points,
        bridged_s: f64::MAX,
        marked: count <= MARKED,
    };
    let plot = Plot {
        width: Plot::NARROW,
        unit,
        over: &format!("{of}, in their order"),
        is_of_days: false,
        from: 1.0,
        to: count as f64,
        range: [low - margin, high + margin],
        shaded_s: &[],
        levels: &[0.0],
        series: vec![series("before", "before", before), series("after", "after", after)],
    };
    let about =
        "The size of the calibrated vector less what it should be. After should lie at zero in every orientation.";
    let described = format!("Error of the size by {of}, {unit}, before and after. {about}");
    format!(
        "<figure>\n<h3>Error of the size, {}</h3>\n<p class=\"about\">{about}</p>\n<div class=\"standing\">\n{}</div>\n\
         <p class=\"legend\"><span class=\"before\">before</span> <span class=\"after\">after</span></p>\n</figure>\n",
        escape(unit),
        plot.draw(&described),
    )
}

fn sensor(page: &mut Page, sensor: Option<&SensorCalibration>, model: VectorModel, unit: &str, of: &str) {
    let Some(sensor) = sensor else { return };
    let mut rows = Vec::new();
    let mut row =
        |name: String, before: f64, after: f64| rows.push((false, vec![name, in_digits(before), in_digits(after)]));
    if let Some((before, after)) = sensor.before_after() {
        row(format!("{of} that were fitted, rms"), before, after);
    }
    if let Some(check) = &sensor.held_out {
        row(format!("{} {of} held out ({}), rms", check.count, check.how), check.before, check.after);
    }
    let before = format!("before, {unit}");
    let after = format!("after, {unit}");
    page.add("<p>Error of the size of the calibrated vector, which should be gravity's or the field's.</p>\n");
    page.add(&table(&["error of the size", &before, &after], rows));
    page.add(&errors(sensor, unit, of));
    page.add("<h3>Model on record: calibrated = matrix (raw - offset)</h3>\n");
    let rows = model.matrix.iter().zip(model.offset).zip(["x", "y", "z"]).map(|((row, offset), axis)| {
        let cells = row.iter().map(|x| fixed(*x, 5));
        (false, [axis.to_owned()].into_iter().chain(cells).chain([fixed(offset, 5)]).collect())
    });
    let offset = format!("offset, {unit}");
    page.add(&table(&["axis", "matrix, times raw x", "raw y", "raw z", &offset], rows));
}
