//! A fleet: what a batch wrote is read back, the worst comes first, P that moves over months is told from P that does
//! not, and the page filters and orders in a browser.
#![allow(clippy::unwrap_used, missing_docs)]

mod rig;

use std::{fs, path::Path};

use chrono::{Days, NaiveDate};
use mwd::{
    fleet::{Parameters, Recording, Standing, Window, drift::probes, read, read_and_replaced},
    report::html::{fleet::page, write_page},
};
use rig::{
    browser::{browser, is_legible, told, told_by},
    files::scenario,
    page::{is_whole, unbalanced},
    picture::looks_as_in_its_pictures,
    program::mwd,
};
use serde_json::json;
use tempfile::TempDir;
use testbed::simulate::{Effects, Scenario, simulate};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_batch_is_read_back_with_probe_day_verdict_and_windows() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let scenario = Scenario { duration_s: 75.0, ..scenario("drilling_45deg") };
    let (mut trace, _) = simulate(&scenario, 1);
    trace.keys.serial = Some("MWD 7 <a>".to_owned());
    trace.keys.date = NaiveDate::from_ymd_opt(2026, 3, 31);
    trace.write(&at("good.csv")).unwrap();
    fs::write(at("bad.csv"), "# serial = 12\nt_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n0.01,0,oops,0,0,0,9.8\n").unwrap();
    let (results, html, reports) = (at("all.parquet"), at("fleet.html"), at("their reports"));
    let output =
        mwd(&["batch", text(folder.path()), "-o", text(&results), "--html", text(&html), "--html-dir", text(&reports)]);
    assert!(output.status.success(), "{output:?}");
    // Recordings that could not be flown are named at once, not only in the table.
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        said.contains("not flown") && said.contains("bad.csv: line 4") && said.contains("is not a number"),
        "{said}"
    );
    let read = read(&[&results]).unwrap();
    let [bad, good] = &read[..] else { panic!("{read:?}") };
    assert_eq!((bad.standing, bad.name(), bad.windows.len()), (Standing::NotFlown, "bad", 0));
    assert!(bad.error.as_ref().unwrap().contains("is not a number"), "{bad:?}");
    assert_eq!(bad.serial.as_deref(), Some("12"), "a damaged recording is still of its probe");
    assert_eq!((good.serial.as_deref(), good.date), (Some("MWD 7 <a>"), trace.keys.date));
    assert!(!good.windows.is_empty() && good.windows.iter().all(|window| window.fit.is_some()), "{good:?}");
    assert_eq!(good.last.is_some(), good.accepted() > 0);
    let of_batch = fs::read_to_string(&html).unwrap();
    // But for the ways to the reports the page is whole.
    let alone = of_batch.replace("href=\"their%20reports/", "href=\"#");
    assert!(of_batch.contains("MWD 7 &lt;a&gt;") && unbalanced(&of_batch).is_empty() && is_whole(&alone));

    assert!(of_batch.contains("SHA-256 of the table"));
    // A row leads to its own report; that of a recording that was not flown leads nowhere.
    let links: Vec<&str> = of_batch.split("<a href=\"their%20reports/").skip(1).collect();
    assert_eq!(links.len(), 1, "{of_batch}");
    let name = links[0].split('"').next().unwrap();
    assert!(name.starts_with("good.csv.") && reports.join(name).is_file(), "{name}");

    let output = mwd(&["fleet", text(&results), "--html", text(&html), "--html-dir", text(&reports)]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && said.starts_with("1 of 2 recordings should be looked at: 1 could not"),
        "{said}"
    );
    assert_eq!(fs::read_to_string(&html).unwrap(), of_batch, "the same page");
    // A table of windows is none of recordings, and a trace is no table.
    for wrong in [at("all.windows.parquet"), at("bad.csv"), at("none.parquet")] {
        let output = mwd(&["fleet", text(&wrong), "--html", text(&at("wrong.html"))]);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(!at("wrong.html").exists());
    }
    // The page takes the place of no table that is read.
    for table in ["all.windows.parquet", "all.stations.parquet", "all.parquet"].map(at) {
        let before = fs::read(&table).unwrap();
        let output = mwd(&["fleet", text(&results), "--html", text(&table)]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains("would overwrite what is read"), "{output:?}");
        assert_eq!(fs::read(&table).unwrap(), before);
    }
}

/// A recording that was flown by `--force` is not among the sound ones, and the reason is told wherever it is shown.
#[test]
fn a_recording_whose_signs_cannot_be_is_not_sound() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut trace = simulate(&Scenario { duration_s: 80.0, ..scenario("drilling_45deg") }, 3).0;
    trace.samples.iter_mut().flat_map(|sample| &mut sample.accel_m_s2).for_each(|x| *x = -*x);
    trace.write(&at("turned.csv")).unwrap();
    let (results, html) = (at("all.parquet"), at("fleet.html"));
    let output = mwd(&["batch", text(&at("turned.csv")), "--force", "-o", text(&results), "--html", text(&html)]);
    let said = String::from_utf8(output.stdout).unwrap();
    let why = "the sign of all axes of the accelerometer";
    assert!(said.contains("units, signs or axes wrong") && said.contains(why), "{said}");
    let read = read(&[&results]).unwrap();
    let [turned] = &read[..] else { panic!("{read:?}") };
    assert_eq!((turned.standing, turned.standing.is_sound()), (Standing::Wrong, false));
    assert!(turned.error.as_ref().is_some_and(|told| told.contains(why)), "{turned:?}");
    let page = fs::read_to_string(&html).unwrap();
    assert!(page.contains("1 of 1 recording should be looked at: 1 with units, signs or axes that cannot be."));
    assert!(page.contains(why) && unbalanced(&page).is_empty());
}

/// An error that was found and is not taken out stands against a recording.
#[test]
fn an_error_that_is_left_in_is_not_sound() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let effects = Effects { accel_bias_m_s2: [2.0, -1.5, 1.0], ..Effects::default() };
    let mut scenario = Scenario { duration_s: 120.0, effects, ..Scenario::default() };
    scenario.hole.inclination_deg = 45.0;
    let trace = simulate(&scenario, 1).0;
    trace.write(&at("biased.csv")).unwrap();
    let (results, html) = (at("all.parquet"), at("fleet.html"));
    let output = mwd(&["batch", text(&at("biased.csv")), "-o", text(&results), "--html", text(&html)]);
    assert!(output.status.success(), "{output:?}");
    let read = read(&[&results]).unwrap();
    let [biased] = &read[..] else { panic!("{read:?}") };
    assert_eq!((biased.standing, biased.standing.is_sound()), (Standing::LeftIn, false), "{biased:?}");
    assert!(!biased.left.is_empty() && biased.left.iter().all(|name| biased.effects.contains(name)));
    let page = fs::read_to_string(&html).unwrap();
    assert!(page.contains("1 of 1 recording should be looked at: 1 with an error that was found and is left in."));
    let said = String::from_utf8(mwd(&["diagnose", text(&at("biased.csv"))]).stdout).unwrap();
    assert!(said.contains(&format!("an error that was found is left in: {}", biased.left[0])), "{said}");
    assert!(!said.contains("what is left is small") && !said.contains("larger than"), "{said}");
}

/// Recordings are known by their bytes and their file's name, not by the path as it was typed: those of two sites may
/// have one path.
#[test]
fn tables_of_two_sites_do_not_overwrite_each_other() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("elsewhere")).unwrap();
    let of_seed = |seed| simulate(&Scenario { duration_s: 15.0, ..scenario("drilling_45deg") }, seed).0;
    let batch = |input: &str, table: &str| {
        let output = mwd(&["batch", text(&at(input)), "-o", text(&at(table))]);
        assert!(output.status.success(), "{output:?}");
    };
    of_seed(1).write(&at("run.csv")).unwrap();
    batch("run.csv", "one.parquet");
    fs::copy(at("run.csv"), at("elsewhere/run.csv")).unwrap();
    of_seed(2).write(&at("run.csv")).unwrap();
    batch("run.csv", "two.parquet");
    batch("elsewhere/run.csv", "three.parquet");
    let tables = ["one.parquet", "two.parquet", "three.parquet"].map(at);
    let (recordings, replaced) = read_and_replaced(&tables[..2]).unwrap();
    assert_eq!((recordings.len(), replaced.len()), (2, 0), "{recordings:?}");
    let (recordings, replaced) = read_and_replaced(&tables).unwrap();
    assert_eq!(recordings.len(), 2, "{recordings:?}");
    let [told] = &replaced[..] else { panic!("{replaced:?}") };
    assert!(told.starts_with("1 recordings of ") && told.contains("one.parquet"), "{told}");
}

/// A recording of a probe `days` into the year whose axis x reads `percent` too little.
fn recording(name: &str, serial: &str, days: u64, percent: f64, standing: Standing) -> Recording {
    let mut last = Parameters { sigma: [0.001; 12], b_rad_s: [0.01, -0.02, 0.005], ..Parameters::default() };
    for element in [0, 4, 8] {
        last.p[element] = 1.0;
    }
    last.p[0] += 0.01 * percent;
    let window = |share: f64| Window {
        accepted: share < 0.9,
        fit: Some(Parameters { p: last.p.map(|x| x + 0.001 * share), ..last }),
        nis: Some(0.5 + share),
    };
    Recording {
        path: format!("field/{name}.csv.gz"),
        hash: String::new(),
        report: None,
        serial: Some(serial.to_owned()),
        date: NaiveDate::from_ymd_opt(2026, 1, 5).map(|date| date + Days::new(days)),
        standing,
        error: (standing == Standing::NotFlown).then(|| "line 3, column gy: \"oops\" is not a number".to_owned()),
        effects: if name.ends_with('3') { vec!["mag_lag".to_owned()] } else { Vec::new() },
        left: Vec::new(),
        has_notes: false,
        duration_s: Some(600.0),
        last: (standing != Standing::NotFlown).then_some(last),
        field_deg: [Some(2.0), Some(0.4)],
        rotation_deg: [None; 2],
        windows: if standing == Standing::NotFlown { Vec::new() } else { [0.1, 0.4, 0.2, 0.9].map(window).into() },
    }
}

/// Recordings of two probes over ten months: the scale of one moves by 0.05 % a month, that of the other scatters.
fn recordings() -> Vec<Recording> {
    let moved = (0..11).map(|k: u32| {
        let standing = if k == 4 { Standing::Unexplained } else { Standing::Sound };
        recording(&format!("run_{k:02}"), "1041", u64::from(30 * k), 1.0 + 0.05 * f64::from(k), standing)
    });
    let scattered = (0..11).map(|k: u32| {
        let off = if k.is_multiple_of(3) { 0.1 } else { -0.05 };
        recording(&format!("pad_{k:02}"), "1042", u64::from(30 * k), off, Standing::EffectsFound)
    });
    let bad = recording("bad", "1042", 40, 0.0, Standing::NotFlown);
    let mut all: Vec<Recording> = moved.chain(scattered).chain([bad]).collect();
    all.sort_by_key(|recording| recording.standing);
    all
}

#[test]
fn a_probe_whose_p_moves_is_told_from_one_whose_p_scatters() {
    let probes = probes(&recordings());
    let serials: Vec<&str> = probes.iter().map(|probe| probe.serial.as_str()).collect();
    assert_eq!(serials, ["1041", "1042"], "the clearest comes first");
    let (element, change) = probes[0].moves(2).unwrap();
    assert_eq!(element, 0);
    assert!((change.a_month - 0.05 * 30.44 / 30.0).abs() < 3.0 * change.sigma, "{change:?}");
    assert_eq!(probes[1].moves(2), None, "{:?}", probes[1].change_percent(0));
    assert_eq!(probes[0].results.len() + probes[1].results.len(), 22, "what did not fly has no P");
}

/// Clicks through the page's filters and columns.
const USE: &str = "<script>
  const told = { wrong: window.wrong };
  try {
    const form = document.getElementById('filters');
    const rows = () => [...document.querySelectorAll('#fleet tbody tr')].filter(row => row.offsetParent !== null);
    const shows = (name, value) => {
      form.reset();
      form.elements[name].value = value;
      form.elements[name].dispatchEvent(new Event('input', { bubbles: true }));
      return rows().length;
    };
    told.all = rows().length;
    told.first = rows()[0].cells[0].textContent;
    told.unexplained = shows('standing', 'more left than noise');
    told.effect = shows('effect', 'mag_lag');
    told.serial = shows('serial', '1041');
    told.probes = [...document.querySelectorAll('[data-probe]')].filter(probe => !probe.hidden).length;
    told.text = shows('text', 'PAD_0');
    told.said = document.getElementById('shown').textContent;
    shows('text', '');
    const button = document.querySelectorAll('#fleet th button')[6];
    button.click();
    const offs = () => rows().map(row => row.cells[6].dataset.key).filter(key => key !== '').map(Number);
    told.up = offs().every((x, k, all) => k === 0 || all[k - 1] <= x);
    told.last = rows().at(-1).cells[0].textContent;
    button.click();
    told.down = offs().every((x, k, all) => k === 0 || all[k - 1] >= x);
    told.sorted = button.parentNode.getAttribute('aria-sort');
  } catch (error) { told.wrong.push(String(error)); }
  document.body.dataset.told = JSON.stringify(told);
  document.getElementById('hold').src = '';
</script>";

#[test]
fn the_page_is_legible_filters_and_orders() {
    let text = page(&recordings(), &["march.parquet".into()]);
    assert!(unbalanced(&text).is_empty() && is_whole(&text), "{:?}", unbalanced(&text));
    assert!(text.contains("P of probe 1041 moves") && !text.contains("P of probe 1042 moves"));
    assert!(text.contains(">2026-05-"), "the drawings' axis has dates");
    let Some(browser) = browser() else { return };
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("fleet.html");
    write_page(&file, &text).unwrap();
    looks_as_in_its_pictures(&browser, &file, "fleet");
    for (width, is_dark) in [(1280, false), (390, true)] {
        let seen = told(&browser, &file, width, is_dark);
        is_legible(&seen, width, is_dark);
        assert_eq!(seen["plots"], 4, "{seen}");
        assert!(seen["reads"].as_str().is_some_and(|read| read.contains('%')), "{seen}");
        let used = told_by(USE, &browser, &file, width, is_dark);
        assert_eq!(
            used,
            json!({
                "wrong": [], "all": 23, "first": "bad", "unexplained": 1, "effect": 2, "serial": 11, "probes": 1,
                "text": 10, "said": "10 of 23 recordings", "up": true, "last": "bad", "down": true, "sorted": "descending",
            }),
            "{width}"
        );
    }
}

#[test]
fn an_empty_fleet_and_one_without_days_have_their_page() {
    assert!(unbalanced(&page(&[], &[])).is_empty());
    let undated: Vec<Recording> =
        recordings().into_iter().map(|recording| Recording { date: None, ..recording }).collect();
    let text = page(&undated, &[]);
    assert!(text.contains("Drift needs recordings") && !text.contains("class=\"plot\""));
}
