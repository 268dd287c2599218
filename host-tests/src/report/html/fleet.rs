//! A fleet as a page: its recordings as rows, the worst first, and how P of each probe moves over months.

use std::{collections::BTreeMap, path::PathBuf};

use super::{
    Chart, Page, Series, Sources,
    chart::{DATE, in_digits},
    escape::escape,
    fixed, sentence,
    spark::{Point, spark},
    table,
};
use crate::{
    fleet::{
        Recording, Standing,
        drift::{Probe, day, probes},
    },
    report::effect_words::EFFECT_WORDS,
};

/// Probes that have plots; the table has all.
const DRAWN: usize = 24;

/// Name of each element of P, its class in the style sheet, and its place: row by row.
const ELEMENTS: [(&str, &str); 9] =
    [("x", "x"), ("xy", "x"), ("xz", "u"), ("yx", "y"), ("y", "y"), ("yz", "v"), ("zx", "z"), ("zy", "w"), ("z", "z")];

/// The whole page of recordings that stand in their order.
#[must_use]
pub fn page(recordings: &[Recording], tables: &[PathBuf]) -> String {
    let drifting = probes(recordings);
    let days = || drifting.iter().flat_map(|probe| &probe.results).map(|(date, _)| day(*date));
    let (first, last) = days().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let margin = (0.02 * (last - first)).max(1.0);
    let span = if first <= last { [first - margin, last + margin] } else { [0.0, 1.0] };
    let mut page = Page::over("Fleet", span, ("date", DATE));
    page.head(&first_screen(recordings, &drifting));
    page.section("Recordings");
    page.add(&filters(recordings));
    page.add(&rows(recordings));
    page.section("Drift of P");
    drift(&mut page, &drifting);
    page.section("Where this comes from");
    let sources = tables.iter().fold(Sources::program(), |sources, path| sources.file("table", path));
    let hashes = recordings.iter().map(|recording| (false, vec![recording.path.clone(), recording.hash.clone()]));
    let about = "<p>A hash is of the recording, the configuration, the options and the program: all that a result depends on.</p>\n";
    let hashes = format!("{about}{}", table(&["recording", "hash"], hashes));
    page.add(&sources.folded("The recordings, and what their results depend on", &hashes).html());
    page.script(include_str!("fleet.js"));
    page.finish()
}

/// One of it, or several.
fn count(number: usize, one: &str, several: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { several })
}

/// Verdict on the fleet: true if it needs nothing, and what it needs, in a sentence.
#[must_use]
pub fn verdict(recordings: &[Recording]) -> (bool, String) {
    let of = |standing: Standing| recordings.iter().filter(|recording| recording.standing == standing).count();
    let why = [
        (of(Standing::NotFlown), "could not be flown"),
        (of(Standing::Wrong), "with units, signs or axes that cannot be"),
        (of(Standing::Unexplained), "with more left than noise accounts for"),
        (of(Standing::LeftIn), "with an error that was found and is left in"),
        (of(Standing::TooLittleMotion), "with too little motion for a verdict"),
    ];
    let needs: usize = why.iter().map(|(number, _)| number).sum();
    let all = count(recordings.len(), "recording", "recordings");
    if needs == 0 {
        return (true, format!("Nothing stands against any of {all}."));
    }
    let why = why.iter().filter(|(number, _)| *number > 0).map(|(number, what)| format!("{number} {what}"));
    (false, format!("{needs} of {all} should be looked at: {}.", why.collect::<Vec<_>>().join(", ")))
}

fn first_screen(recordings: &[Recording], drifting: &[Probe]) -> String {
    let (is_sound, told) = verdict(recordings);
    let mut reasons = Vec::new();
    for probe in drifting {
        if let Some((element, change)) = probe.moves(drifting.len()) {
            let what = if element.is_multiple_of(4) { "scale of axis" } else { "cross-coupling" };
            reasons.push(format!(
                "P of probe {} moves: its {what} {} by {:.3} ± {:.3} % a month",
                probe.serial, ELEMENTS[element].0, change.a_month, change.sigma
            ));
        }
    }
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for effect in recordings.iter().flat_map(|recording| &recording.effects) {
        *seen.entry(effect).or_default() += 1;
    }
    let mut seen: Vec<(&str, usize)> = seen.into_iter().collect();
    seen.sort_by_key(|(_, number)| std::cmp::Reverse(*number));
    if !seen.is_empty() {
        let named = seen.iter().take(5).map(|(name, number)| format!("{} in {number}", title(name)));
        reasons.push(format!("Found most often: {}", named.collect::<Vec<_>>().join("; ")));
    }
    let reasons: String = reasons.iter().map(|reason| format!("<li>{}.</li>\n", escape(reason))).collect();
    let list = if reasons.is_empty() { String::new() } else { format!("<ul>\n{reasons}</ul>\n") };
    let windows: usize = recordings.iter().map(|recording| recording.windows.len()).sum();
    let accepted: usize = recordings.iter().map(Recording::accepted).sum();
    let hours = recordings.iter().filter_map(|recording| recording.duration_s).sum::<f64>() / 3_600.0;
    let tiles = [
        ("Recordings", recordings.len().to_string(), ""),
        ("Probes", serials(recordings).len().to_string(), "with a serial number"),
        ("Flown", format!("{hours:.1} h"), ""),
        ("Windows that flew", format!("{accepted} of {windows}"), "50 s of motion each"),
    ];
    let tiles: String = tiles
        .iter()
        .map(|(name, value, what)| format!("<div><dt>{name}</dt><dd>{value} <small>{what}</small></dd></div>\n"))
        .collect();
    let class = if is_sound { "good" } else { "caution" };
    format!(
        "<header>\n<h1>Fleet</h1>\n<div class=\"verdict {class}\">\n<p class=\"sentence\">{}</p>\n{list}</div>\n</header>\n<dl class=\"tiles\">\n{tiles}</dl>\n",
        escape(&told)
    )
}

/// An effect's title; its name where it has none.
fn title(name: &str) -> &str {
    EFFECT_WORDS.iter().find(|words| words.name == name).map_or(name, |words| words.title)
}

/// Serial numbers, each once.
fn serials(recordings: &[Recording]) -> Vec<&str> {
    let mut serials: Vec<&str> = recordings.iter().filter_map(|recording| recording.serial.as_deref()).collect();
    serials.sort_unstable();
    serials.dedup();
    serials
}

/// The form that filters the rows; without scripts it is not shown.
fn filters(recordings: &[Recording]) -> String {
    let option = |value: &str, text: &str| format!("<option value=\"{}\">{}</option>", escape(value), escape(text));
    let choice = |name: &str, label: &str, options: Vec<(String, String)>| {
        let options: String = options.iter().map(|(value, text)| option(value, text)).collect();
        let all = option("", "all");
        format!("<label>{label} <select name=\"{name}\">{all}{options}</select></label>\n")
    };
    let standings = Standing::ALL.into_iter().filter_map(|standing| {
        let number = recordings.iter().filter(|recording| recording.standing == standing).count();
        let words = standing.words();
        (number > 0).then(|| (words.to_owned(), format!("{} ({number})", sentence(words))))
    });
    let mut effects: Vec<&str> =
        recordings.iter().flat_map(|recording| &recording.effects).map(String::as_str).collect();
    effects.sort_unstable();
    effects.dedup();
    let effects = effects.into_iter().map(|name| (name.to_owned(), title(name).to_owned()));
    let serials = serials(recordings).into_iter().map(|serial| (serial.to_owned(), serial.to_owned()));
    format!(
        "<form id=\"filters\" class=\"filters\" hidden>\n{}{}{}<label>Text <input type=\"search\" name=\"text\"/></label>\n\
         <button type=\"reset\">Show all</button>\n</form>\n<p id=\"shown\" class=\"about\" aria-live=\"polite\"></p>\n",
        choice("standing", "Verdict", standings.collect()),
        choice("effect", "Effect", effects.collect()),
        choice("serial", "Probe", serials.collect()),
    )
}

/// Columns of the table.
const COLUMNS: [&str; 10] = [
    "Recording",
    "Probe",
    "Date",
    "Verdict",
    "Found",
    "Windows flown",
    "P off by, %",
    "Bias, deg/s",
    "Disagreement",
    "Field before, after, deg",
];

fn rows(recordings: &[Recording]) -> String {
    let head: String = COLUMNS
        .iter()
        .map(|name| format!("<th scope=\"col\"><button type=\"button\" disabled>{}</button></th>", escape(name)))
        .collect();
    let body: String = recordings.iter().map(row).collect();
    let about = "The worst come first. A small line is a recording's windows from first to last, an orange point a window that was refused, and the number the last one. \
        P off by: how far the gyro's scale and axes are off, as the root mean square of P less the identity (rate = P (raw rate - b)). Disagreement of the sensors: squared innovations over what noise accounts for; far above 1 something is not modelled. \
        Field: how far the gyro's prediction of the field over a second is off, with its bias alone taken out and as flown.";
    format!(
        "<p class=\"about\">{about}</p>\n<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"Recordings\">\n\
         <table id=\"fleet\" class=\"fleet\">\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n</table>\n</div>\n"
    )
}

/// A row: each cell has the key that it is ordered by, and the name of its column for narrow screens.
fn row(recording: &Recording) -> String {
    let mut cells = String::new();
    let mut column = COLUMNS.iter();
    let mut cell = |key: &str, html: &str| {
        let name = column.next().copied().unwrap_or_default();
        // A cell without anything is not shown on a narrow screen.
        let html = if html.is_empty() { String::new() } else { format!("<div>{html}</div>") };
        cells += &format!("<td data-name=\"{}\" data-key=\"{}\">{html}</td>", escape(name), escape(key));
    };
    let standing = recording.standing;
    let shown = |x: Option<f64>| x.map_or_else(String::new, |x| fixed(x, 2));
    let [path, name] = [&recording.path, recording.name()].map(escape);
    let shown_name = match &recording.report {
        Some(report) => format!("<a href=\"{}\" title=\"{path}\">{name}</a>", escape(report)),
        None => format!("<span title=\"{path}\">{name}</span>"),
    };
    cell(recording.name(), &shown_name);
    let serial = recording.serial.as_deref().unwrap_or_default();
    cell(serial, &escape(serial));
    let date = recording.date.map_or_else(String::new, |date| date.to_string());
    cell(&date, &escape(&date));
    let rank = Standing::ALL.iter().position(|one| *one == standing).unwrap_or_default().to_string();
    let class = if standing.is_sound() { "good" } else { "caution" };
    let why = recording.error.as_ref().map_or_else(String::new, |why| format!("<small>{}</small>", escape(why)));
    cell(&rank, &format!("<strong class=\"{class}\">{}</strong>{why}", escape(&sentence(standing.words()))));
    let effects: Vec<String> = recording
        .effects
        .iter()
        .map(|name| escape(title(name)) + if recording.left.contains(name) { ", left in" } else { "" })
        .collect();
    cell(&recording.effects.len().to_string(), &effects.join("<br/>"));
    let flew = recording.accepted();
    let flew =
        if standing == Standing::NotFlown { String::new() } else { format!("{flew} of {}", recording.windows.len()) };
    cell(flew.split(' ').next().unwrap_or_default(), &flew);
    let fits = || recording.windows.iter().filter_map(|window| Some((window.fit?, !window.accepted)));
    let off: Vec<Point> = fits().map(|(fit, refused)| (fit.off_percent(), refused)).collect();
    let bias: Vec<Point> = fits().map(|(fit, refused)| (fit.bias_deg_s(), refused)).collect();
    let nis = recording.windows.iter().filter_map(|window| Some((window.nis?, !window.accepted)));
    let nis: Vec<Point> = nis.collect();
    for (name, unit, points) in [("P off by", "%", off), ("bias", "deg/s", bias), ("disagreement", "times", nis)] {
        let last = points.last().map_or_else(String::new, |(x, _)| in_digits(*x));
        cell(&last, format!("{} {}", spark(name, unit, &points), shown(points.last().map(|(x, _)| *x))).trim());
    }
    let [before, after] = recording.field_deg;
    let both = if after.is_some() { format!("{} to {}", shown(before), shown(after)) } else { String::new() };
    cell(&shown(after), &both);
    format!(
        "<tr data-standing=\"{}\" data-effects=\"{}\" data-serial=\"{}\">{cells}</tr>\n",
        standing.words(),
        escape(&recording.effects.join(" ")),
        escape(serial)
    )
}

/// Table and plots of the probes with dated results.
fn drift(page: &mut Page, drifting: &[Probe]) {
    if drifting.is_empty() {
        page.add(
            "<p>Drift needs recordings of one probe on two days at least: the keys <code>serial</code> and <code>date</code> in the \
             traces' headers, as <code>cargo mwd record</code> and <code>cargo mwd import --key serial=NUMBER</code> write them.</p>\n",
        );
        return;
    }
    page.add(
        "<p>What each probe's P was at the end of each recording, and how a line through these moves in a month. A result counts by its \
         own deviation; the one that moves most clearly comes first. Between runs a gyro's P may move with temperature too.</p>\n",
    );
    let diagonal = [0, 4, 8];
    let cross = || (0..9).filter(|element| !diagonal.contains(element));
    let change = |probe: &Probe, element: usize| {
        let change = probe.change_percent(element);
        change.map_or_else(String::new, |change| format!("{} ± {:.3}", fixed(change.a_month, 3), change.sigma))
    };
    let rows = drifting.iter().map(|probe| {
        let moves = probe.moves(drifting.len());
        let date =
            |result: Option<&(chrono::NaiveDate, _)>| result.map_or_else(String::new, |(date, _)| date.to_string());
        let [first, last] = [probe.results.first(), probe.results.last()].map(date);
        let mut cells = vec![probe.serial.clone(), probe.results.len().to_string(), first, last];
        cells.extend(diagonal.map(|element| change(probe, element)));
        let clearest = cross().max_by(|a, b| {
            let clear = |element: usize| probe.change_percent(element).map_or(0.0, |change| change.in_sigmas());
            clear(*a).total_cmp(&clear(*b))
        });
        cells.push(
            clearest.map_or_else(String::new, |element| format!("{} {}", ELEMENTS[element].0, change(probe, element))),
        );
        cells.push(if moves.is_some() { "moves" } else { "as chance allows" }.to_owned());
        (moves.is_some(), cells)
    });
    let head = [
        "probe",
        "recordings",
        "first",
        "last",
        "scale x, % a month",
        "scale y, % a month",
        "scale z, % a month",
        "clearest cross-coupling, % a month",
        "more than chance",
    ];
    page.add(&table(&head, rows));
    for probe in drifting.iter().take(DRAWN) {
        page.add(&format!("<div data-probe=\"{}\">\n", escape(&probe.serial)));
        let series = |element: usize| {
            let (name, class) = ELEMENTS[element];
            let point = |(date, result): &(chrono::NaiveDate, crate::fleet::Parameters)| {
                let [x, sigma] = result.percent(element);
                [day(*date), x, sigma]
            };
            let points = probe.results.iter().map(point).collect();
            Series { name: name.to_owned(), class, points, bridged_s: f64::MAX, marked: true }
        };
        let name = format!("Scale factors of probe {}", probe.serial);
        let about = "P's diagonal less 1, with one deviation to each side.";
        page.chart(Chart::new(&name, "%", about, diagonal.map(series).into()));
        let name = format!("Cross-coupling of probe {}", probe.serial);
        page.chart(Chart::new(&name, "%", "The rest of P.", cross().map(series).collect()));
        page.add("</div>\n");
    }
    if drifting.len() > DRAWN {
        page.add(&format!(
            "<p>The other {} probes have no plots; they move less clearly.</p>\n",
            drifting.len() - DRAWN
        ));
    }
}
