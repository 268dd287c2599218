//! The monitor's page on loopback.

use std::{
    fs,
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process,
    time::{Duration, Instant},
};

use meerkat_mwd::{
    identification::Decision,
    telemetry::{AttitudeFormat, Identification, Message},
};
use mwd::{port::monitor::History, report::html::live::page};

use crate::{
    flown,
    rig::{
        browser::{browser, is_sound, told},
        page::without_scripts,
        picture::looks_as_in_its_pictures,
        report::report,
    },
};

/// Answer of a monitor on loopback: its status line and all that follows.
fn answered(address: &str, request: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// The page without its scripts, as a browser has it after two answers.
fn shown(browser: &Path, address: &str) -> String {
    let profile = tempfile::tempdir().unwrap();
    let mut command = process::Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=1500", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    let output = command.arg(format!("http://{address}/")).output().unwrap();
    without_scripts(&String::from_utf8(output.stdout).unwrap())
}

/// The page has the last attitude; another name for this machine, or another path, gets nothing.
#[test]
fn the_live_page_is_for_this_machine_and_shows_what_the_probe_says() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.bin");
    fs::write(&path, flown::stream(&config, &samples, AttitudeFormat::Exact)).unwrap();
    let flight = testbed::flight::fly(&config, &samples, |_| ()).unwrap();
    let last = flight.outputs.last().unwrap().attitude.unwrap();
    let mut monitor = process::Command::new(env!("CARGO_BIN_EXE_mwd"));
    let mut monitor = monitor.arg("monitor").arg(&path).arg("--web=0").stdout(process::Stdio::piped()).spawn().unwrap();
    let mut said = String::new();
    BufReader::new(monitor.stdout.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.split("http://").nth(1).unwrap().split('/').next().unwrap().to_owned();
    assert!(address.starts_with("127.0.0.1:"), "{said}");
    let ask = |path: &str, host: &str| answered(&address, &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    let until = Instant::now() + Duration::from_secs(300);
    let inclination = loop {
        let answer = ask("/state", &address);
        let body: serde_json::Value = serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap();
        let end_s = samples.last().unwrap().t_us as f64 * 1e-6;
        // Before the first frame there is no time.
        let is_last = body["t_s"].as_f64().is_some_and(|t_s| (t_s - end_s).abs() < 0.5);
        if is_last || Instant::now() > until {
            let head = body["head"].as_str().unwrap();
            let value = head.split("<dd>").nth(1).unwrap().split('°').next().unwrap().to_owned();
            break value.parse::<f64>().unwrap();
        }
    };
    let page = ask("/", &address);
    let refused = [ask("/state", "elsewhere.example"), ask("/etc/passwd", &address)];
    let drawn = browser().map(|browser| shown(&browser, &address));
    monitor.kill().unwrap();
    monitor.wait().unwrap();
    if let Some((browser, drawn)) = browser().zip(drawn) {
        let words = ["<dt>Inclination at ", "° ± ", "Probe's time "];
        assert!(words.iter().all(|word| drawn.contains(word)), "{drawn}");
        let file = folder.path().join("live.html");
        fs::write(&file, page.split_once("\r\n\r\n").unwrap().1.replacen("\nask();\n", "\n", 1)).unwrap();
        for (width, is_dark) in [(1280, true), (390, false)] {
            is_sound(&told(&browser, &file, width, is_dark), width, is_dark);
        }
        looks_as_in_its_pictures(&browser, &file, "live");
    }
    for told in ["<h3>Rotation about", "<h3>Vibration,", "<h3>Toolface as a dial<"] {
        assert!(page.contains(told), "{told}");
    }
    assert!((inclination - f64::from(last.inclination_rad.to_degrees())).abs() < 0.01, "{inclination}");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("connect-src 'self'") && page.contains("uPlot"));
    assert!(refused[0].starts_with("HTTP/1.1 403") && refused[1].starts_with("HTTP/1.1 404"), "{refused:?}");
}

#[test]
fn a_window_that_is_heard_has_its_fit_on_the_live_page() {
    let mut history = History::default();
    assert!(!page(&history.heard(&[])).contains("<h3>Bias b, "));
    let report = report(Decision::Accepted);
    history.take(&Message::Identification(Identification { report, temperature_c: None }));
    let told = page(&history.heard(&[]));
    assert!(["Bias b, deg/s", "Scale factors, %"].iter().all(|plot| told.contains(&format!("<h3>{plot}</h3>"))));
}
