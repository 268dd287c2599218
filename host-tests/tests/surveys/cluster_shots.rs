//! Several stations at one depth: a roll test and a cluster shot, through the command.

use std::{fs, process::Command};

use mwd::surveys::simulated_run::into_tool;
use serde_json::Value;

const FIELD: [f64; 2] = [50_480.0, 72.3];
/// Bias of the tool's transverse magnetometers, nanotesla.
const BIAS_NT: [f64; 2] = [420.0, -350.0];

/// A row of the stations' file at inclination, azimuth from magnetic north, and toolface, degrees.
fn row(md_m: f64, attitude: [f64; 3], bias_nt: [f64; 2]) -> String {
    let attitude = attitude.map(f64::to_radians);
    let (dip_sine, dip_cosine) = libm::sincos(FIELD[1].to_radians());
    let g = into_tool([0.0, 0.0, 9.819 / 9.806_65], attitude);
    let mut b = into_tool([FIELD[0] * dip_cosine, 0.0, FIELD[0] * dip_sine], attitude);
    b[0] += bias_nt[0];
    b[1] += bias_nt[1];
    format!("{md_m},{:.6},{:.6},{:.6},{:.1},{:.1},{:.1}\n", g[0], g[1], g[2], b[0], b[1], b[2])
}

/// Ten stations of a building hole; at the fourth, `shots` of them in all, toolfaces all around and azimuths with a
/// little scatter.
fn stations(shots: usize, bias_nt: [f64; 2]) -> String {
    let mut text = "md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n".to_owned();
    for k in 0..10 {
        let place = k as f64;
        let attitude = [10.0 + 4.0 * place, 60.0 + place, 77.0 * place];
        for shot in 0..if k == 3 { shots } else { 1 } {
            let shot = shot as f64;
            let scatter = if shots > 1 && k == 3 { 0.05 * (shot - (shots - 1) as f64 / 2.0) } else { 0.0 };
            text +=
                &row(1_000.0 + 30.0 * place, [attitude[0], attitude[1] + scatter, attitude[2] + 45.0 * shot], bias_nt);
        }
    }
    text
}

/// JSON that the command writes.
fn surveyed(text: &str, correction: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("stations.csv"), text).unwrap();
    let settings = format!(
        "well = \"roll test\"\ncorrection = \"{correction}\"\nfield_class = \"ifr1\"\ndate = \"2026-06-01\"\nstart_m = [0.0, 0.0, 990.0]\n\
         [reference]\nmodel = \"fixed\"\nname = \"IFR1\"\ndate = \"2026-06-01\"\nfield_nt = {}\ndip_deg = {}\n\
         declination_deg = -0.8\ngravity_m_s2 = 9.819\n",
        FIELD[0], FIELD[1]
    );
    fs::write(path("run.toml"), settings).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
    command.arg("survey").arg(path("stations.csv")).arg("--run").arg(path("run.toml"));
    let output = command.arg("--json").arg(path("run.json")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    serde_json::from_str(&fs::read_to_string(path("run.json")).unwrap()).unwrap()
}

fn places(run: &Value) -> Vec<&Value> {
    run["stations"].as_array().unwrap().iter().collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Largest difference of positions and of covariances, metres and square metres.
fn apart(a: &Value, b: &Value) -> [f64; 2] {
    let all = |value: &Value| -> Vec<f64> {
        let rows = value.as_array().unwrap().iter();
        rows.flat_map(|row| row.as_array().map_or_else(|| vec![number(row)], |row| row.iter().map(number).collect()))
            .collect()
    };
    ["position_m", "covariance_m2"]
        .map(|of| all(&a[of]).iter().zip(all(&b[of])).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
}

#[test]
fn shots_at_one_depth_are_one_place_of_the_path_and_of_its_uncertainty() {
    let [one, cluster] = [1, 8].map(|shots| surveyed(&stations(shots, [0.0; 2]), "none"));
    let (one, cluster) = (places(&one), places(&cluster));
    assert_eq!((one.len(), cluster.len()), (10, 17));
    // The shots' mean direction is the single station's, so that all places below are the same.
    for (k, single) in one.iter().enumerate() {
        let with = if k < 3 {
            vec![k]
        } else if k == 3 {
            (3..11).collect()
        } else {
            vec![k + 7]
        };
        for shot in with {
            let [position, covariance] = apart(single, cluster[shot]);
            assert!(position < 2e-3 && covariance < 1e-3, "{k} {shot}: {position} {covariance}");
            assert!((number(&single["azimuth_deg"]) - number(&cluster[shot]["azimuth_deg"])).abs() < 0.01);
        }
    }
    // Measured azimuth of each shot: it stays beside the direction of the place.
    let measured: Vec<f64> = cluster[3..11].iter().map(|shot| number(&shot["measured_deg"][1])).collect();
    let spread = measured.iter().fold(f64::MIN, |a, b| a.max(*b)) - measured.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!((0.3..0.4).contains(&spread), "{measured:?}");
}

#[test]
fn a_roll_test_finds_the_transverse_biases_and_names_the_corrected_tool_code() {
    let run = surveyed(&stations(8, BIAS_NT), "multi_station");
    let estimates = run["analysis"]["estimates"].as_array().unwrap();
    for (name, nanotesla) in [("mag_bias_x_ut", BIAS_NT[0]), ("mag_bias_y_ut", BIAS_NT[1])] {
        let estimate = estimates.iter().find(|estimate| estimate[0] == name).unwrap();
        let [value, sigma] = [1, 2].map(|k| 1e3 * number(&estimate[k]));
        assert!((value - nanotesla).abs() < 3.0 * sigma && estimate[4] == true, "{estimate}");
    }
    assert_eq!(run["tool_codes"], serde_json::json!(["MWD+IFR1+MS"]), "{}", run["analysis"]);
    let azimuth: Vec<f64> = places(&run)[3..11].iter().map(|shot| number(&shot["magnetic_azimuth_deg"])).collect();
    assert!(azimuth.iter().all(|azimuth| (azimuth - 63.0).abs() < 0.2), "{azimuth:?}");
}

#[test]
fn a_depth_that_falls_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stations.csv");
    fs::write(&path, "md_m,inclination_deg,magnetic_azimuth_deg\n100,2,3\n100,2,3\n99,2,3\n").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_mwd")).arg("survey").arg(&path).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains("line 4: depth falls"), "{said}");
}

#[test]
fn shots_of_one_place_that_contradict_each_other_are_told() {
    let warnings = |text: &str| {
        let warnings = surveyed(text, "none")["warnings"].as_array().unwrap().clone();
        warnings
            .iter()
            .filter_map(|warning| warning.as_str())
            .filter(|told| told.contains("one depth"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let angles = |inclination: f64, azimuth: f64| {
        format!(
            "md_m,inclination_deg,magnetic_azimuth_deg\n100,40,60\n130,40,60\n130,{inclination},{azimuth}\n160,44,60\n"
        )
    };
    let told = warnings(&angles(43.0, 60.0));
    let text = "stations at one depth differ by up to 3.0 deg in direction, and their mean is taken: at 130.0 m";
    assert_eq!(told, [text]);
    // A turn of the azimuth moves an inclined hole by less than itself.
    assert_eq!(warnings(&angles(40.0, 61.5)), [""; 0]);
    assert_eq!(warnings(&angles(40.0, 62.0)).len(), 1);
    assert_eq!(warnings(&stations(8, [0.0; 2])), [""; 0]);
}
