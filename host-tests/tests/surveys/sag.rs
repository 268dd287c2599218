//! Sag of the bottom-hole assembly: none unless it is asked for, and where it is, every output says so.

use std::{fs, process::Command};

use mwd::{
    report::html::{Sources, survey_run::page},
    surveys::{
        files, reference::Reference, run::SurveyedRun, settings::RunSettings, stations_csv::read, surveyed::surveyed,
    },
};
use tempfile::TempDir;

const RUN: &str = "well = \"A-1\"\nlatitude_deg = 60.0\nlongitude_deg = 2.0\ndate = \"2026-06-01\"\n";
const STATIONS: &str = "md_m,inclination_deg,magnetic_azimuth_deg\n1000,0,40\n1030,30,40\n1060,90,40\n";
const BY_STATION: &str =
    "md_m,inclination_deg,magnetic_azimuth_deg,sag_deg\n1000,0,40,0\n1030,30,40,-0.05\n1060,90,40,0.25\n";
const STATED: &str = "[sag]\nmodel = \"stated\"\nlevel_deg = 0.2\n";
const BEAM: &str =
    "[sag]\nmodel = \"beam\"\nspan_m = 18.0\nfrom_lower_support_m = 14.0\nouter_m = 0.17\ninner_m = 0.08\n";

fn run(stations: &str, sag: &str) -> SurveyedRun {
    let settings = RunSettings::parse(&format!("{RUN}{sag}")).unwrap();
    let reference = Reference::of(&settings).unwrap();
    surveyed(&read(stations).unwrap(), &settings, &reference).unwrap()
}

/// Sag and inclination of each station.
fn sags(run: &SurveyedRun) -> Vec<[f64; 2]> {
    run.stations.iter().map(|station| [station.sag_deg, station.inclination_deg]).collect()
}

/// Words on the sag in each of the outputs that have room for it.
fn told(run: &SurveyedRun) -> [String; 5] {
    let csv = files::csv::full(run);
    let las = files::las::las(run);
    let html = page(run, &Sources::program());
    let json: serde_json::Value = serde_json::from_str(&files::json(run).unwrap()).unwrap();
    let after =
        |text: &str, key: &str, end: &str| text.split(key).nth(1).unwrap().split(end).next().unwrap().to_owned();
    [
        after(&csv, "# sag = ", "\n"),
        after(&las, "SAGC. ", " : "),
        after(&html, ">sag</td>", "</tr>"),
        json["sag"].as_str().unwrap_or("none").to_owned(),
        after(&files::witsml1::witsml(run), "<sagCorUsed>", "<"),
    ]
}

#[test]
fn without_being_asked_for_no_sag_is_added_and_every_output_says_none() {
    let run = run(STATIONS, "");
    assert_eq!((run.sag.as_deref(), run.sag_told().as_str()), (None, "none corrected"));
    assert!(run.stations.iter().all(|s| s.sag_deg == 0.0 && (s.inclination_deg - s.measured_deg[0]).abs() < 1e-12));
    let [csv, las, html, json, witsml] = told(&run);
    assert_eq!(
        (csv.as_str(), las.as_str(), json.as_str(), witsml.as_str()),
        ("none corrected", "none corrected", "none", "false")
    );
    assert!(html.contains("none corrected") && !page(&run, &Sources::program()).contains("sag in it"), "{html}");
}

#[test]
fn a_stated_sag_goes_with_the_sine_and_is_told() {
    let run = run(STATIONS, STATED);
    for ([sag, inclination], (hole, expected)) in sags(&run).iter().zip([(0.0, 0.0), (30.0, 0.1), (90.0, 0.2)]) {
        assert!((sag - expected).abs() < 1e-9 && (inclination - hole - expected).abs() < 1e-9, "{sag} {inclination}");
    }
    let [csv, las, html, json, witsml] = told(&run);
    for text in [csv, las, html, json] {
        assert!(text.contains("0.200 deg in a level hole"), "{text}");
    }
    assert_eq!(witsml, "true");
    assert!(run.sag_told().ends_with("0.000 to 0.200 deg are added to the measured inclinations"));
    assert!(page(&run, &Sources::program()).contains("sag in it"));
    // Positions are of the hole, not of the tool.
    assert!(run.stations[2].position_m[2] < self::run(STATIONS, "").stations[2].position_m[2] - 0.01);
}

#[test]
fn a_beams_sag_is_that_of_its_model_and_is_told() {
    let run = run(STATIONS, BEAM);
    let sag = RunSettings::parse(&format!("{RUN}{BEAM}")).unwrap().sag.unwrap();
    for (k, [added, _]) in sags(&run).into_iter().enumerate() {
        let measured = run.stations[k].measured_deg[0].to_radians();
        assert!((added - sag.correction_rad(measured).to_degrees()).abs() < 1e-9);
    }
    assert!(run.stations[2].sag_deg > 0.01, "{:?}", sags(&run));
    for text in &told(&run)[..4] {
        assert!(text.contains("a beam of 18 m, the tool 14 m above its lower support"), "{text}");
    }
}

#[test]
fn a_sag_of_each_station_is_added_as_it_stands_and_not_together_with_a_model() {
    let run = run(BY_STATION, "");
    assert_eq!(sags(&run).iter().map(|[sag, _]| *sag).collect::<Vec<_>>(), [0.0, -0.05, 0.25]);
    assert!((run.stations[1].inclination_deg - 29.95).abs() < 1e-9);
    for text in &told(&run)[..4] {
        assert!(text.contains("column sag_deg"), "{text}");
    }
    let settings = RunSettings::parse(&format!("{RUN}{STATED}")).unwrap();
    let reference = Reference::of(&settings).unwrap();
    let error = surveyed(&read(BY_STATION).unwrap(), &settings, &reference).unwrap_err().to_string();
    assert!(error.contains("sag is given twice"), "{error}");
}

/// The terminal has one line of it, whatever was asked for.
#[test]
fn the_terminal_says_it_in_a_line() {
    let folder = TempDir::new().unwrap();
    let [stations, settings] = ["stations.csv", "run.toml"].map(|name| folder.path().join(name));
    fs::write(&stations, STATIONS).unwrap();
    for (sag, line) in
        [("", "sag: none corrected"), (STATED, "sag: stated: 0.200 deg in a level hole"), (BEAM, "sag: of a beam")]
    {
        fs::write(&settings, format!("{RUN}{sag}")).unwrap();
        let output =
            Command::new(env!("CARGO_BIN_EXE_mwd")).arg("survey").arg(&stations).arg("--run").arg(&settings).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{output:?}");
        let told = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert_eq!(told.lines().filter(|told| told.starts_with(line)).count(), 1, "{told}");
    }
}
