//! The error model's three standard wells against welleng: another implementation, itself checked against the ISCWSA's
//! own results.

use meerkat_mwd::config::SurveyErrors;
use mwd::surveys::{
    path::{Direction, PathPoint, minimum_curvature},
    position_errors::{ModelStation, PositionErrors, covariances, horizontal_ellipse},
};
use nalgebra::{Matrix3, Vector3};

const WELLS: [&str; 3] =
    [include_str!("iscwsa_well_1.csv"), include_str!("iscwsa_well_2.csv"), include_str!("iscwsa_well_3.csv")];

struct Expected {
    directions: Vec<Direction>,
    positions: Vec<Vector3<f64>>,
    covariances: Vec<Matrix3<f64>>,
    /// Field, microtesla, dip and declination, radians.
    reference: [f64; 3],
}

fn expected(text: &str) -> Expected {
    let key = |key: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(&format!("# {key} ="))).unwrap();
        line.split('=').nth(1).unwrap().trim().parse().unwrap()
    };
    let reference = [1e-3 * key("field_nt"), key("dip_deg").to_radians(), key("declination_deg").to_radians()];
    let mut expected = Expected { directions: vec![], positions: vec![], covariances: vec![], reference };
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let x: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [inclination_rad, azimuth_rad] = [x[1], x[2]].map(f64::to_radians);
        expected.directions.push(Direction { md_m: x[0], inclination_rad, azimuth_rad });
        expected.positions.push(Vector3::new(x[3], x[4], x[5]));
        expected.covariances.push(Matrix3::new(x[6], x[7], x[8], x[7], x[9], x[10], x[8], x[10], x[11]));
    }
    expected
}

fn model(expected: &Expected, path: &[PathPoint]) -> Vec<ModelStation> {
    let [field_ut, dip_rad, declination_rad] = expected.reference;
    (expected.directions.iter().zip(path))
        .map(|(direction, point)| ModelStation {
            direction: *direction,
            tvd_m: point.position_m.z,
            magnetic_azimuth_rad: direction.azimuth_rad - declination_rad,
            true_azimuth_rad: direction.azimuth_rad,
            field_ut,
            dip_rad,
            gravity_m_s2: 9.806_65,
        })
        .collect()
}

#[test]
fn positions_are_those_of_another_implementation() {
    for well in WELLS {
        let expected = expected(well);
        let path = minimum_curvature(&expected.directions, Vector3::zeros());
        for (point, position) in path.iter().zip(&expected.positions) {
            assert!((point.position_m - position).norm() < 2e-4, "{point:?} {position}");
        }
    }
}

#[test]
fn covariances_are_those_of_another_implementation() {
    let mut worst = Vec::new();
    for well in WELLS {
        let expected = expected(well);
        let path = minimum_curvature(&expected.directions, Vector3::zeros());
        let ours = covariances(&model(&expected, &path), &SurveyErrors::default(), &PositionErrors::default());
        let mut largest: f64 = 0.0;
        // The start itself has no covariance here: it is where positions count from.
        for ((ours, theirs), direction) in ours.iter().zip(&expected.covariances).zip(&expected.directions).skip(1) {
            let scale = theirs.diagonal().map(f64::sqrt);
            let off = (ours - theirs).component_div(&(scale * scale.transpose())).amax();
            largest = largest.max(off);
            assert!(off < 0.01, "{} m: {ours} {theirs}", direction.md_m);
        }
        worst.push(largest);
    }
    println!("largest difference of covariances, in products of the standard deviations: {worst:?}");
}

#[test]
fn an_ellipse_has_the_covariances_axes() {
    let (sine, cosine) = 2.0_f64.sin_cos();
    let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    let covariance = turn * Matrix3::from_diagonal(&Vector3::new(9.0, 4.0, 1.0)) * turn.transpose();
    let ([major, minor], azimuth) = horizontal_ellipse(&covariance);
    assert!((major - 3.0).abs() < 1e-12 && (minor - 2.0).abs() < 1e-12 && (azimuth - 2.0).abs() < 1e-12);
}
