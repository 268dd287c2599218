//! A run of surveys as a page: path, uncertainty, quality.

use super::{Chart, Page, Series, Sources, escape::escape, fixed, path_in_space, table};
use crate::surveys::{
    far_off::limits,
    run::{SurveyedRun, SurveyedStation},
    settings::Correction,
};

/// The whole page, of a run that was worked out from `sources`.
#[must_use]
pub fn page(run: &SurveyedRun, sources: &Sources) -> String {
    let depths = || run.stations.iter().map(|station| station.md_m);
    let span_m = [depths().fold(f64::MAX, f64::min), depths().fold(f64::MIN, f64::max)];
    let mut page = Page::over(&format!("Surveys of {}", run.well), span_m, ("measured depth", "m"));
    page.head(&first_screen(run));
    page.section("Path");
    let plan: Vec<[f64; 2]> = run.stations.iter().map(|s| [s.position_m[1], s.position_m[0]]).collect();
    let (ellipses, times) = ellipses(run, &plan);
    let size = if times > 1.0 { format!(", drawn {times} times as large") } else { String::new() };
    let about = format!("North is up, east to the right. Ellipses: two standard deviations{size}.");
    let plan = view("Plan", &about, ["East", "north"], true, &plan, &ellipses);
    let section: Vec<[f64; 2]> = run.stations.iter().map(|s| [s.vertical_section_m, s.position_m[2]]).collect();
    let about = format!("Along {:.0} deg: distance to the right, depth down.", run.vertical_section_deg);
    let section = view("Vertical section", &about, ["Distance", "depth"], false, &section, &[]);
    page.add(&format!("<div class=\"pair\">\n{plan}{section}{}</div>\n", path_in_space::drawing(run)));
    charts(&mut page, run);
    page.section("Stations");
    page.add(&stations(run));
    if let Some(analysis) = &run.analysis {
        page.section("Multi-station analysis");
        let told = format!(
            "From {} stations. Azimuths: {}. Inclinations: {}.",
            analysis.counted, analysis.azimuth, analysis.inclination
        );
        page.add(&format!("<p>{}</p>\n", escape(&told)));
        let rows = analysis.estimates.iter().map(|(name, value, sigma, before, observable)| {
            let told = if *observable { "determined" } else { "not determined" };
            let cells =
                [(*name).to_owned(), fixed(*value, 5), format!("{sigma:.5}"), fixed(*before, 5), told.to_owned()];
            (false, cells.to_vec())
        });
        page.add(&table(&["common error", "value", "deviation", "deviation before", "by these stations"], rows));
    }
    page.section("Where this comes from");
    let provenance = &run.provenance;
    let sources = sources.clone().known("reference", provenance.model.as_str()).known("day", provenance.date.as_str());
    let sources = sources.known("place", provenance.place.as_str()).known("tool code", run.tool_codes.join(", "));
    page.add(&sources.known("sag", run.sag_told()).html());
    page.finish()
}

/// Verdict in a sentence, and where the hole is.
fn first_screen(run: &SurveyedRun) -> String {
    let Some(last) = run.stations.last() else { return "<h1>No station</h1>\n".to_owned() };
    let doubted = run.stations.iter().filter(|station| station.doubted).count();
    let no_go = run.stations.iter().filter(|station| station.axial_no_go == Some(true)).count();
    let count = run.stations.len();
    let (class, verdict) = match (&run.analysis, doubted, run.warnings.len()) {
        (_, 1.., _) => ("caution", format!("{doubted} of {count} stations are contradicted by the others.")),
        (None, _, _) => ("caution", format!("{count} stations, not checked against each other.")),
        (Some(_), _, 0) => ("good", format!("{count} stations agree with each other.")),
        (Some(_), ..) => {
            ("caution", "The stations agree, but something about the run is assumed or doubtful.".to_owned())
        }
    };
    let mut reasons = run.warnings.clone();
    if let Some(analysis) = &run.analysis {
        reasons.push(format!("Azimuths are {}; inclinations are {}.", analysis.azimuth, analysis.inclination));
    }
    if run.correction == Correction::Axial {
        reasons.push(format!("{no_go} of {count} stations are in the no-go zone of the short-collar correction."));
    }
    let items: String =
        reasons.iter().map(|reason| format!("<li>{}</li>\n", escape(&super::sentence(reason)))).collect();
    let list = if items.is_empty() { String::new() } else { format!("<ul>\n{items}</ul>\n") };
    let north = if run.convergence_deg.is_some() { "from grid north" } else { "from true north" };
    let angle = |x: f64, sigma: Option<f64>| {
        format!("{}°{}", fixed(x, 2), sigma.map_or_else(String::new, |sigma| format!(" ± {sigma:.2}°")))
    };
    let [n, e, tvd] = last.position_m;
    let [major, ..] = last.ellipse;
    let at = format!("at {:.1} m", last.md_m);
    let tiles = [
        ("Inclination", angle(last.inclination_deg, last.sigma_inclination_deg), at),
        ("Azimuth", angle(last.azimuth_deg, last.sigma_azimuth_deg), north.to_owned()),
        ("True vertical depth", format!("{} m", fixed(tvd, 2)), String::new()),
        ("North, east", format!("{}, {} m", fixed(n, 1), fixed(e, 1)), format!("± {major:.2} m, one deviation")),
    ];
    let tiles: String = tiles
        .iter()
        .map(|(name, what, small)| format!("<div><dt>{name}</dt><dd>{what} <small>{small}</small></dd></div>\n"))
        .collect();
    format!(
        "<header>\n<h1>Surveys of {}</h1>\n<div class=\"verdict {class}\">\n<p class=\"sentence\">{verdict}</p>\n{list}</div>\n</header>\n<dl class=\"tiles\">\n{tiles}</dl>\n",
        escape(&run.well)
    )
}

/// Picks a figure of a station and its deviation.
type Figure = fn(&SurveyedStation) -> Option<[f64; 2]>;

fn charts(page: &mut Page, run: &SurveyedRun) {
    let series = |name: &str, class: &'static str, figure: Figure| {
        let point = |station: &SurveyedStation| {
            let [x, sigma] = figure(station).unwrap_or([f64::NAN, 0.0]);
            [station.md_m, x, sigma]
        };
        let points = run.stations.iter().map(point).collect();
        Series { name: name.to_owned(), class, points, bridged_s: f64::MAX, marked: true }
    };
    let measured = series("as measured", "before", |s| Some([s.measured_deg[0], 0.0]));
    let corrected = series("corrected", "after", |s| Some([s.inclination_deg, s.sigma_inclination_deg.unwrap_or(0.0)]));
    page.chart(Chart::new("Inclination", "deg", "", vec![measured, corrected]));
    // The measured azimuth from the same north; beside the corrected one, not a turn away.
    let measured = series("as measured", "before", |s| {
        let off_deg = libm::remainder(s.measured_deg[1] - s.magnetic_azimuth_deg, 360.0);
        Some([s.azimuth_deg + off_deg, 0.0])
    });
    let azimuth = series("corrected", "after", |s| Some([s.azimuth_deg, s.sigma_azimuth_deg.unwrap_or(0.0)]));
    page.chart(Chart::new("Azimuth", "deg", "From the north that positions count from.", vec![measured, azimuth]));
    let dogleg = series("dogleg", "x", |s| Some([s.dogleg_deg_30m, 0.0]));
    page.chart(Chart::new("Dogleg severity", "deg/30 m", "Bend since the station before.", vec![dogleg]).of_sizes());
    let off: [(&str, &str, &str, Figure); 3] = [
        ("|G| less the place's", "m/s²", "Gravity: what is off is an error of the accelerometer, or motion.", |s| {
            Some([s.off_reference?[0], 0.0])
        }),
        (
            "|B| less the place's",
            "µT",
            "Field: what is off is the drill string, a magnet, or the magnetometer.",
            |s| Some([s.off_reference?[1], 0.0]),
        ),
        ("Dip less the place's", "deg", "", |s| Some([s.off_reference?[2], 0.0])),
    ];
    for ((name, unit, about, figure), limit) in off.into_iter().zip(limits()) {
        let levels = vec![
            (0.0, "the place's".to_owned()),
            (-limit, format!("limits, ± {limit:.3} {unit}")),
            (limit, String::new()),
        ];
        let chart = Chart::new(name, unit, about, vec![series("measured less reference", "z", figure)]);
        page.chart(chart.with_levels(levels));
    }
}

/// Quality of a station in words: which of the differences, measured less reference, are beyond their limits.
fn quality(off_reference: Option<[f64; 3]>) -> String {
    let Some(off) = off_reference else { return "not known: angles alone were read".to_owned() };
    let beyond = off.iter().zip(limits()).zip(["gravity", "field", "dip"]);
    let beyond: Vec<&str> = beyond.filter(|((off, limit), _)| off.abs() > *limit).map(|(_, name)| name).collect();
    match beyond[..] {
        [] => "good".to_owned(),
        [one] => format!("{one} is off"),
        _ => format!("{} are off", beyond.join(", ")),
    }
}

fn stations(run: &SurveyedRun) -> String {
    let [gravity, field, dip] = limits();
    let about = format!(
        "<p>Quality compares |G|, |B| and dip as they were measured with what the place should have: within ± {gravity:.3} m/s², \
         ± {field:.1} µT and ± {dip:.2} deg they are good.</p>\n"
    );
    let sigma =
        |x: f64, sigma: Option<f64>| fixed(x, 2) + &sigma.map_or_else(String::new, |sigma| format!(" ± {sigma:.2}"));
    // Only where some was added: else the column says nothing.
    let sags = run.sag.is_some();
    let head = [
        "depth, m",
        "inclination, deg",
        "sag in it, deg",
        "azimuth, deg",
        "TVD, m",
        "north, m",
        "east, m",
        "dogleg, deg/30 m",
        "ellipse, m",
        "quality",
        "remark",
    ];
    let rows = run.stations.iter().map(|s| {
        let [n, e, tvd] = s.position_m.map(|x| fixed(x, 2));
        let [major, minor, azimuth] = s.ellipse;
        let remark = match (s.doubted, s.corrected) {
            (true, _) => "contradicted by the others",
            (false, "no") => "azimuth as measured",
            (false, "axial") => "short-collar correction",
            (false, _) => "multi-station correction",
        };
        let cells = vec![
            format!("{:.2}", s.md_m),
            sigma(s.inclination_deg, s.sigma_inclination_deg),
            format!("{:.3}", s.sag_deg),
            sigma(s.azimuth_deg, s.sigma_azimuth_deg),
            tvd,
            n,
            e,
            format!("{:.2}", s.dogleg_deg_30m),
            format!("{major:.2} x {minor:.2} at {azimuth:.0}"),
            quality(s.off_reference),
            remark.to_owned(),
        ];
        (s.doubted, shown(cells, sags))
    });
    about + &table(&shown(head.to_vec(), sags), rows)
}

/// A row with the column of the sag, the third, or without it.
fn shown<T>(mut row: Vec<T>, sags: bool) -> Vec<T> {
    if !sags {
        row.remove(2);
    }
    row
}

/// Middle in the plot's numbers, and half axes with the major one's azimuth, degrees.
type Ellipse = ([f64; 2], [f64; 3]);

/// Ellipses of every fifth station and the last, of two standard deviations, so many times as large: as much as fits
/// into the margin.
fn ellipses(run: &SurveyedRun, plan: &[[f64; 2]]) -> (Vec<Ellipse>, f64) {
    let spread = |k: usize| {
        let of = || plan.iter().map(move |point| point[k]);
        of().fold(f64::MIN, f64::max) - of().fold(f64::MAX, f64::min)
    };
    let size = spread(0).max(spread(1)).max(1.0);
    let largest = run.stations.iter().map(|station| 2.0 * station.ellipse[0]).fold(1e-9, f64::max) / size;
    let times = [50.0, 20.0, 10.0, 5.0, 2.0].into_iter().find(|times| times * largest < 18.0 / 260.0).unwrap_or(1.0);
    let last = run.stations.len().saturating_sub(1);
    let shown = run.stations.iter().zip(plan).enumerate().filter(|(k, _)| k % 5 == 0 || *k == last);
    let ellipses = shown.map(|(_, (station, at))| {
        let [major, minor, azimuth] = station.ellipse;
        (*at, [2.0 * times * major, 2.0 * times * minor, azimuth])
    });
    (ellipses.collect(), times)
}

/// A drawing of the path in metres, one scale for both axes; `points` go to the right and down, or up.
fn view(
    name: &str,
    about: &str,
    [right, other]: [&str; 2],
    is_up: bool,
    points: &[[f64; 2]],
    ellipses: &[Ellipse],
) -> String {
    let range = |k: usize| {
        let of = || points.iter().map(move |point| point[k]);
        [of().fold(f64::MAX, f64::min), of().fold(f64::MIN, f64::max)]
    };
    let [x, y] = [range(0), range(1)];
    let size = (x[1] - x[0]).max(y[1] - y[0]).max(1.0);
    let place = |[a, b]: [f64; 2]| {
        let down = if is_up { y[1] - b } else { b - y[0] };
        [20.0 + 260.0 * (a - x[0]) / size, 20.0 + 260.0 * down / size]
    };
    let path: Vec<String> = points.iter().map(|point| place(*point)).map(|[a, b]| format!("{a:.1} {b:.1}")).collect();
    let dots: String = points
        .iter()
        .map(|point| place(*point))
        .map(|[a, b]| format!("<circle class=\"z\" cx=\"{a:.1}\" cy=\"{b:.1}\" r=\"2.5\"/>\n"))
        .collect();
    let around: String = ellipses
        .iter()
        .map(|(at, [major, minor, azimuth])| {
            let ([a, b], scale) = (place(*at), 260.0 / size);
            format!(
                "<ellipse cx=\"{a:.1}\" cy=\"{b:.1}\" rx=\"{:.2}\" ry=\"{:.2}\" transform=\"rotate({:.1} {a:.1} {b:.1})\" fill=\"none\" stroke=\"currentColor\" stroke-opacity=\"0.6\"/>\n",
                major * scale,
                minor * scale,
                azimuth - 90.0
            )
        })
        .collect();
    let height = 40.0 + 260.0 * (y[1] - y[0]) / size;
    let [[left, right_end], [low, high]] = [x, y].map(|range| range.map(|m| fixed(m, 1)));
    let told = format!("{right} {left} to {right_end} m, {other} {low} to {high} m.");
    format!(
        "<figure class=\"dial\">\n<h3>{name}</h3>\n<p class=\"about\">{} {}</p>\n<svg viewBox=\"0 0 300 {height:.0}\" role=\"img\" aria-label=\"{}\">\n\
         <path class=\"after\" d=\"M{}\"/>\n{around}{dots}</svg>\n</figure>\n",
        escape(about),
        escape(&told),
        escape(&format!("{name}: {told}")),
        path.join("L"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quality_names_what_is_beyond_its_limit() {
        assert_eq!(quality(Some([0.02, -0.2, 0.2])), "good");
        assert_eq!(quality(Some([0.02, -0.4, 0.2])), "field is off");
        assert_eq!(quality(Some([-0.03, 0.4, -8.0])), "gravity, field, dip are off");
        assert_eq!(quality(None), "not known: angles alone were read");
    }
}
