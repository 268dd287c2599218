//! Pages in a browser: no error, nothing wider than the screen, every plot drawn, keys work, an hour's page is small,
//! and what is where looks as in the pictures beside this file. Chromium draws them; without one the tests print
//! SKIPPED, and with `MWD_REQUIRE_BROWSER=1` they fail.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;

use std::{fs, process::Command};

use meerkat_mwd::{
    Config, Sample,
    attitude::{Attitude, AttitudeFlags},
    probe::Output,
};
use mwd::{
    diagnosis::diagnosed,
    report::html::{Told, replay::page, write_page},
};
use rig::{
    browser::{browser, frame_ms, is_legible, is_sound, told},
    files::{ATTACHED_MAGNET, FAST_ROTATION, recording_path},
    page::{is_whole, unbalanced},
    picture::looks_as_in_its_pictures,
};
use tempfile::TempDir;
use testbed::{
    flight::{Calibrated, Flight, Watched},
    trace::Trace,
};

/// Largest page of an hour's flight, bytes.
const LARGEST_PAGE: usize = 6_000_000;

#[test]
fn pages_of_a_recording_are_sound_on_a_desk_and_on_a_phone_in_the_light_and_in_the_dark() {
    let Some(browser) = browser() else { return };
    let directory = TempDir::new().unwrap();
    for command in ["replay", "diagnose"] {
        let page = directory.path().join(format!("{command}.html"));
        let mut mwd = Command::new(env!("CARGO_BIN_EXE_mwd"));
        let output = mwd.arg(command).arg(recording_path(FAST_ROTATION)).arg("--html").arg(&page).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.contains("<dt>Inclination at "), "{command}: attitude comes first");
        // No limit of the field without a place, and that is said.
        assert!(text.matches("No limits are drawn").count() >= 2, "{command}");
        assert!(text.contains("A residual that is no smaller with an effect taken out"), "{command}");
        for (width, is_dark) in [(1280, false), (390, true)] {
            is_sound(&told(&browser, &page, width, is_dark), width, is_dark);
        }
        looks_as_in_its_pictures(&browser, &page, command);
    }
}

/// The accelerometer of this recording reads in one sample of six: its lines are drawn, and nothing is called missing.
#[test]
fn a_sensor_that_is_slower_than_the_others_has_its_curves() {
    let directory = TempDir::new().unwrap();
    let page = directory.path().join("slow.html");
    let mut mwd = Command::new(env!("CARGO_BIN_EXE_mwd"));
    let output = mwd.arg("replay").arg(recording_path(ATTACHED_MAGNET)).arg("--html").arg(&page).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(&page).unwrap();
    let data = text.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(&data.replace("<\\/", "</")).unwrap();
    let headlines: Vec<&str> =
        text.split("<figure id=\"chart-").skip(1).map(|figure| figure.split("</h3>").next().unwrap()).collect();
    for name in ["Accelerometer, as read", "|G|", "Dip"] {
        let number = headlines.iter().position(|head| head.contains(&format!("<h3>{name},"))).unwrap();
        assert_eq!(data["charts"][number]["marks"], serde_json::json!([]), "{name}");
    }
    // A reference of every 114th sample is points, and no line that cuts corners.
    assert!(text.contains("The reference was not recorded at every sample"));
    // Changes that the recording's header states are told, not called unknown.
    assert!(text.contains("changed since it was recorded") && !text.contains("ignored keys"));
    // Drawn without scripts: long lines, not single points.
    for (name, least) in [("Accelerometer, as read", 500), ("|G|", 500), ("Dip", 500)] {
        let figure = text.split(&format!("<h3>{name},")).nth(1).unwrap().split("</figure>").next().unwrap();
        assert!(figure.matches('L').count() > least, "{name}: {}", figure.matches('L').count());
    }
    let Some(browser) = browser() else { return };
    is_sound(&told(&browser, &page, 1280, true), 1280, true);
}

/// Stations of a hole that builds to the north, as CSV.
fn stations() -> String {
    let mut text = "md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n".to_owned();
    let (north_nt, down_nt) = (21_000.0, 45_000.0);
    for k in 1..=12 {
        let (sine, cosine) = (5.0 * f64::from(k)).to_radians().sin_cos();
        let (bx, bz) = (north_nt * cosine - down_nt * sine, north_nt * sine + down_nt * cosine);
        text += &format!("{},{:.6},0.0,{cosine:.6},{bx:.1},0.0,{bz:.1}\n", 100 * k, -sine);
    }
    text
}

#[test]
fn pages_of_a_calibration_and_of_a_run_of_surveys_are_legible() {
    let directory = TempDir::new().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("stations.csv"), stations()).unwrap();
    fs::write(at("run.toml"), "latitude_deg = 60.4\nlongitude_deg = 5.3\ndate = \"2026-06-01\"\n").unwrap();
    let run = at("run.toml").display().to_string();
    let rests = recording_path("multipos_mpu9150_imu0");
    let browser = browser();
    for (command, input, more) in [("calibrate", rests, vec![]), ("survey", at("stations.csv"), vec!["--run", &run])] {
        let page = at(&format!("{command}.html"));
        let mut mwd = Command::new(env!("CARGO_BIN_EXE_mwd"));
        let output = mwd.arg(command).arg(input).args(more).arg("--html").arg(&page).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(&page).unwrap();
        assert!(unbalanced(&text).is_empty() && is_whole(&text), "{command}: {:?}", unbalanced(&text));
        assert_eq!(text.contains("<h3>Error of the size, m/s²</h3>"), command == "calibrate");
        // Differences of every station from the place's values, and where the limits are.
        assert_eq!(text.contains("are off</td>") && text.contains("limits, ± 0.250 deg"), command == "survey");
        assert!(text.matches("SHA-256 of the ").count() > 1, "{command}");
        for (width, is_dark) in [(1280, false), (390, true)] {
            if let Some(browser) = &browser {
                is_legible(&told(browser, &page, width, is_dark), width, is_dark);
            }
        }
        if let Some(browser) = &browser {
            looks_as_in_its_pictures(browser, &page, command);
        }
    }
}

/// Outputs and readings of an hour at 100 Hz, with every curve moving all the time.
#[test]
fn a_page_of_an_hour_is_small_and_its_plots_move_at_once() {
    let times = || (1..=360_000_u64).map(|k| (10_000 * k, k as f32 * 0.01));
    let shaken = |t_s: f32, k: f32| libm::sinf(t_s * k) + 0.1 * libm::sinf(t_s * 31.7 * k);
    let attitude = |t_s: f32| Attitude {
        q: [1.0, 0.0, 0.0, 0.0],
        inclination_rad: 0.7 + 0.01 * shaken(t_s, 0.3),
        azimuth_rad: 1.0 + 0.02 * shaken(t_s, 0.4),
        gravity_toolface_rad: (3.0 * t_s).rem_euclid(core::f32::consts::TAU),
        magnetic_toolface_rad: 0.0,
        sigma_inclination_rad: 0.003,
        sigma_azimuth_rad: 0.01,
        sigma_toolface_rad: 0.005,
        flags: AttitudeFlags::empty(),
    };
    let vector = |t_s: f32| [1.1, 2.3, 3.7].map(|k| shaken(t_s, k));
    let sample = |(t_us, t_s)| Sample {
        t_us,
        gyro_rad_s: vector(t_s),
        accel_m_s2: vector(t_s + 1.0),
        mag_ut: vector(t_s + 2.0),
        temperature_c: 60.0 + shaken(t_s, 0.01),
        ..Sample::default()
    };
    let trace = Trace { samples: times().map(sample).collect(), ..Trace::default() };
    let outputs = times().map(|(t_us, t_s)| Output { t_us, rate_rad_s: vector(t_s), attitude: Some(attitude(t_s)) });
    let flight = Flight { outputs: outputs.collect(), ..Flight::default() };
    let calibrated = times().map(|(t_us, t_s)| Calibrated {
        t_us,
        force_m_s2: Some(vector(t_s + 1.0)),
        field_ut: Some(vector(t_s + 2.0)),
    });
    let watched = Watched { calibrated: calibrated.collect(), ..Watched::default() };
    let config = Config { effects: false, ..Config::default() };
    let diagnosed = diagnosed(&Trace::default(), &config, &Flight::default());
    let (trace, flight) = (&trace, &flight);
    let text = page(&Told {
        trace,
        config: &config,
        flight,
        diagnosed: &diagnosed,
        reference: None,
        watched: Some(&watched),
        place: "here",
    });
    assert!(text.len() < LARGEST_PAGE, "{}", text.len());
    let Some(browser) = browser() else { return };
    let directory = TempDir::new().unwrap();
    let file = directory.path().join("hour.html");
    write_page(&file, &text).unwrap();
    let told = told(&browser, &file, 1280, false);
    is_sound(&told, 1280, false);
    let [mean_ms, largest_ms] = frame_ms(&told);
    println!("page of an hour: {} bytes, {mean_ms:.0} ms to a painted frame, at most {largest_ms:.0}", text.len());
}
