//! A run of 40 stations from six axes to positions with their covariances, against welleng's numbers.

use mwd::{
    report::html::{Sources, survey_run::page},
    surveys::{reference::Reference, run::SurveyedRun, settings::RunSettings, stations_csv::read, surveyed::surveyed},
};
use nalgebra::{Matrix3, Vector3};

fn run() -> SurveyedRun {
    let settings = RunSettings::parse(include_str!("forty_stations.toml")).unwrap();
    let reference = Reference::of(&settings).unwrap();
    surveyed(&read(include_str!("forty_stations.csv")).unwrap(), &settings, &reference).unwrap()
}

#[test]
fn positions_and_covariances_of_a_corrected_run_are_wellengs() {
    let run = run();
    let rows = include_str!("forty_stations_welleng.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    let rows: Vec<Vec<f64>> = rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((rows.len(), run.stations.len()), (40, 40));
    let (mut farthest, mut largest) = (0.0_f64, 0.0_f64);
    for (station, x) in run.stations.iter().zip(&rows).skip(1) {
        let off = Vector3::from(station.position_m) - Vector3::new(x[3], x[4], x[5]);
        let theirs = Matrix3::new(x[6], x[7], x[8], x[7], x[9], x[10], x[8], x[10], x[11]);
        let ours: Matrix3<f64> = Matrix3::from(station.covariance_m2);
        let scale = theirs.diagonal().map(f64::sqrt);
        farthest = farthest.max(off.norm());
        largest = largest.max((ours - theirs).component_div(&(scale * scale.transpose())).amax());
    }
    println!("positions within {farthest:.5} m, covariances within {largest:.1e} of the deviations' products");
    assert!(farthest < 1e-3 && largest < 1e-3, "{farthest} {largest}");
}

/// The string has 900 nT along its axis: raw azimuths at the end are three degrees off.
#[test]
fn the_correction_finds_the_strings_field_and_the_true_direction() {
    let run = run();
    let last = run.stations.last().unwrap();
    assert!((last.measured_deg[1] - 61.1).abs() < 0.1 && (last.azimuth_deg - 58.0).abs() < 0.3, "{last:?}");
    let drawn = page(&run, &Sources::program());
    assert_eq!(drawn.matches("<ellipse").count(), 9);
    assert!(drawn.contains("Ellipses: two standard deviations"));
}
