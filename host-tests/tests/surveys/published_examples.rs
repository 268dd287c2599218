//! Examples that other authors have published with all their numbers: hole, reference and errors, and how
//! well their own programs must find these. The readings are computed from them, in those authors' tool axes
//! (their y is x here).

use mwd::surveys::{
    reference::Reference,
    run::{SurveyedRun, SurveyedStation},
    settings::RunSettings,
    simulated_run::into_tool,
    stations_csv::read,
    surveyed::surveyed,
};

/// A published run.
struct Example {
    /// Total field, nanotesla, and dip, degrees.
    reference: [f64; 2],
    gravity_m_s2: f64,
    /// Depth, m, then inclination, azimuth from magnetic north and toolface, degrees.
    stations: Vec<[f64; 4]>,
    /// Bias, m/s^2, and scale factor of the accelerometers.
    accel: [[f64; 3]; 2],
    /// Bias, nanotesla, and scale factor of the magnetometers.
    mag: [[f64; 3]; 2],
}

/// Six stations below a string with 650 nT along its axis: M. Nikitin, ArroWell,
/// tests/arrowell_engine/integration/test_msa_recovery.py (github.com/maksim-y-nikitin/arrowell, commit
/// 3b32c8d). It must find the 650 nT within 50.
fn arrowell() -> Example {
    let attitudes = [
        [35.0, 45.0, 15.0],
        [45.0, 48.0, 80.0],
        [55.0, 50.0, 145.0],
        [65.0, 52.0, 215.0],
        [75.0, 55.0, 280.0],
        [82.0, 58.0, 340.0],
    ];
    Example {
        reference: [58_000.0, 77.0],
        gravity_m_s2: 9.806_65,
        // The depths, which are not stated, are of stands.
        stations: (0..).zip(attitudes).map(|(k, [i, a, t])| [1_000.0 + 30.0 * f64::from(k), i, a, t]).collect(),
        accel: [[0.0; 3]; 2],
        mag: [[0.0, 0.0, ARROWELL_NT], [0.0; 3]],
    }
}

const ARROWELL_NT: f64 = 650.0;

/// Twenty stations with errors of all sensors, in two holes, a steep and a building one: MWD STD, mwdstdcore,
/// tests/params.py and tests/test_msa.py (github.com/mwdstd/mwdstdcore, commit 3700534). It must find errors
/// of over twice the error model's size within three times this size.
fn mwdstdcore() -> [Example; 2] {
    let along = |[from, to]: [f64; 2], k: i32| from + (to - from) * f64::from(k) / 19.0;
    // Their azimuth counts from true north; the declination is 6 deg.
    let hole = |inclination: [f64; 2], azimuth: [f64; 2]| Example {
        reference: [48_000.0, 60.0],
        gravity_m_s2: 9.81,
        stations: (0..20)
            .map(|k| [along([0.0, 1e3], k), along(inclination, k), along(azimuth, k) - 6.0, along([0.0, 540.0], k)])
            .collect(),
        accel: [[0.005, -0.005, 0.0], [500e-6, -500e-6, 500e-6]],
        mag: [[-300.0, 300.0, 700.0], [1_600e-6, -2_000e-6, -2_200e-6]],
    };
    [hole([5.0, 8.0], [270.0, 285.0]), hole([8.0, 87.0], [285.0, 285.0])]
}

impl Example {
    /// Stations as their authors' programs would write them, worked out.
    fn worked_out(&self, more: &str) -> SurveyedRun {
        let [field_nt, dip_deg] = self.reference;
        let (sine, cosine) = dip_deg.to_radians().sin_cos();
        let mut text = "# axes = y -x z\nmd_m,gx_m_s2,gy_m_s2,gz_m_s2,bx_nt,by_nt,bz_nt\n".to_owned();
        for [md, inclination, azimuth, toolface] in &self.stations {
            let attitude = [*inclination, *azimuth, *toolface].map(f64::to_radians);
            let gravity = theirs(into_tool([0.0, 0.0, self.gravity_m_s2], attitude));
            let field = theirs(into_tool([field_nt * cosine, 0.0, field_nt * sine], attitude));
            let read = |truth: [f64; 3], [bias, scale]: [[f64; 3]; 2]| -> String {
                (0..3).map(|k| format!(",{}", (1.0 + scale[k]) * truth[k] + bias[k])).collect()
            };
            text += &format!("{md}{}{}\n", read(gravity, self.accel), read(field, self.mag));
        }
        let settings = format!(
            "date = \"2026-06-01\"\nstart_m = [0.0, 0.0, 0.0]\n{more}\n[reference]\nmodel = \"fixed\"\nname = \"stated\"\n\
             date = \"2026-06-01\"\nfield_nt = {field_nt}\ndip_deg = {dip_deg}\ndeclination_deg = 0\ngravity_m_s2 = {}\n",
            self.gravity_m_s2
        );
        let settings = RunSettings::parse(&settings).unwrap();
        surveyed(&read(&text).unwrap(), &settings, &Reference::of(&settings).unwrap()).unwrap()
    }

    /// Errors of the stations' azimuths as measured and as they are believed, rms, degrees.
    fn azimuth_errors_deg(&self, run: &SurveyedRun) -> [f64; 2] {
        let of = |value: fn(&SurveyedStation) -> f64| {
            let off =
                run.stations.iter().zip(&self.stations).map(|(s, truth)| libm::remainder(value(s) - truth[2], 360.0));
            (off.map(|x| x * x).sum::<f64>() / self.stations.len() as f64).sqrt()
        };
        [of(|s| s.measured_deg[1]), of(|s| s.magnetic_azimuth_deg)]
    }
}

/// A vector of our tool axes in those of both authors.
fn theirs([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-y, x, z]
}

/// An estimate and its standard deviation by its name.
fn estimate(run: &SurveyedRun, name: &str) -> [f64; 2] {
    let estimates = &run.analysis.as_ref().unwrap().estimates;
    let found = estimates.iter().find(|estimate| estimate.0 == name).unwrap();
    [f64::from(found.1), f64::from(found.2)]
}

/// The string is stated, as a short collar's is: three of its deviations would else be the most that is
/// likely.
const SHORT_COLLAR: &str = "errors = { axial_interference_ut = 0.65 }";

#[test]
fn the_short_collar_correction_finds_the_published_interference_and_azimuths() {
    let example = arrowell();
    let run = example.worked_out(&format!("correction = \"axial\"\n{SHORT_COLLAR}"));
    for (station, truth) in run.stations.iter().zip(&example.stations) {
        let [found_ut, _] = station.axial_interference_ut.unwrap();
        assert!((1e3 * found_ut - ARROWELL_NT).abs() < 1.0 && station.axial_no_go == Some(false), "{station:?}");
        assert!((station.magnetic_azimuth_deg - truth[2]).abs() < 0.01, "{station:?}");
    }
    let [before, after] = example.azimuth_errors_deg(&run);
    println!(
        "ArroWell, short-collar correction: 650 nT at each of 6 stations, azimuths off by {before:.2} deg rms, corrected by {after:.3}"
    );
    // Below a string of the error model's size the flattest ones, the nearest to the east, stay as measured.
    let usual = example.worked_out("correction = \"axial\"");
    let no_go: Vec<bool> = usual.stations.iter().map(|station| station.axial_no_go.unwrap()).collect();
    assert_eq!(no_go, [false, false, true, true, true, true]);
}

#[test]
fn the_analysis_finds_the_published_interference_and_does_not_trust_six_stations_with_the_azimuths() {
    let example = arrowell();
    let run = example.worked_out(SHORT_COLLAR);
    let [found, sigma] = estimate(&run, "mag_bias_z_ut").map(|ut| 1e3 * ut);
    let analysis = run.analysis.as_ref().unwrap();
    println!("ArroWell, multi-station analysis: {found:.0} +- {sigma:.0} nT; azimuths {}", analysis.azimuth);
    assert!((found - ARROWELL_NT).abs() < 50.0 && sigma < 150.0, "{found} {sigma}");
    assert_eq!(analysis.azimuth, "as measured: too uncertain for its size");
}

#[test]
fn the_analysis_finds_the_published_errors_of_all_sensors_and_mends_the_azimuths() {
    for (example, hole) in mwdstdcore().iter().zip(["5 to 8", "8 to 87"]) {
        let run = example.worked_out("");
        let [before, after] = example.azimuth_errors_deg(&run);
        let mut found = Vec::new();
        // Errors of over twice the error model's size, in our axes, and this size, nanotesla.
        for (name, truth, size) in
            [("mag_bias_x_ut", 300.0, 70.0), ("mag_bias_y_ut", 300.0, 70.0), ("mag_bias_z_ut", 700.0, 230.0)]
        {
            let [value, sigma] = estimate(&run, name).map(|ut| 1e3 * ut);
            assert!((value - truth).abs() < 3.0 * f64::min(size, sigma), "{name}: {value} +- {sigma}, not {truth}");
            found.push(format!("{value:.0} +- {sigma:.0}"));
        }
        println!(
            "mwdstdcore, {hole} deg: biases of 300, 300 and 700 nT found as {}; azimuths off by {before:.2} deg rms, corrected by \
             {after:.2}",
            found.join(", ")
        );
        assert_eq!(run.analysis.as_ref().unwrap().azimuth, "corrected");
        assert!(after < 0.25 * before, "{before} {after}");
    }
}
