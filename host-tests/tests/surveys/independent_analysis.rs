//! The multi-station analysis against another one in double precision that shares no formula with it: every station's
//! attitude is an unknown too, the six readings are the observations, derivatives are differences, and all unknowns are
//! solved for together.

use meerkat_mwd::{
    config::SurveyErrors,
    survey::multi_station::{MultiStation, MultiStationSettings, PARAMETERS, Parameter, Station},
};
use mwd::surveys::simulated_run::{Run, into_tool};
use nalgebra::{SMatrix, SVector};

const STEPS: usize = 6;
const STATIONS: usize = 14;
/// Errors, then of each station three angles and what its field differs from the reference.
const UNKNOWNS: usize = PARAMETERS + 5 * STATIONS;
/// Priors of the errors, then of each station two of the field and six readings.
const ROWS: usize = PARAMETERS + 8 * STATIONS;

type Unknowns = SVector<f64, UNKNOWNS>;

/// Residuals of all stations and priors, divided by their standard deviations.
fn residuals(stations: &[Station], x: &Unknowns) -> SVector<f64, ROWS> {
    let settings = MultiStationSettings::default();
    let errors = SurveyErrors::default();
    let sigma = Parameter::ALL.map(|parameter| f64::from(parameter.prior_sigma(&errors, &settings)));
    let value = |k: usize| x[k] * sigma[k];
    let mut r: Vec<f64> = (0..PARAMETERS).map(|k| x[k]).collect();
    let last = stations.len() - 1;
    for (k, station) in stations.iter().enumerate() {
        // Beside the attitude, what the field differs from its reference here: total and dip.
        let own = |j: usize| x[PARAMETERS + 5 * k + j];
        let attitude = [own(0), own(1), own(2)];
        let gravity = f64::from(station.reference.gravity_m_s2) + value(13);
        let total =
            f64::from(station.reference.field_ut) + value(14) + own(3) * f64::from(settings.total_field_noise_ut);
        let dip = f64::from(station.reference.dip_rad) + value(15) + own(4) * f64::from(settings.dip_noise_rad);
        r.extend([own(3), own(4)]);
        let force = into_tool([0.0, 0.0, -gravity], attitude);
        let field = into_tool([total * libm::cos(dip), 0.0, total * libm::sin(dip)], attitude);
        let along =
            f64::from(station.depth_m - stations[0].depth_m) / f64::from(stations[last].depth_m - stations[0].depth_m);
        for axis in 0..3 {
            let read = (1.0 + value(3 + axis)) * force[axis] + value(axis);
            r.push((f64::from(station.force_m_s2[axis]) - read) / f64::from(settings.force_noise_m_s2));
            let axial = if axis == 2 { along * value(12) } else { 0.0 };
            let read = (1.0 + value(9 + axis)) * field[axis] + value(6 + axis) + axial;
            r.push((f64::from(station.field_ut[axis]) - read) / f64::from(settings.field_noise_ut));
        }
    }
    SVector::from_iterator(r)
}

/// Most probable unknowns with their covariance, from attitudes near the truth.
fn solved(stations: &[Station], attitudes: &[[f64; 3]]) -> (Unknowns, SMatrix<f64, UNKNOWNS, UNKNOWNS>) {
    let mut x = Unknowns::zeros();
    for (k, attitude) in attitudes.iter().enumerate() {
        (0..3).for_each(|j| x[PARAMETERS + 5 * k + j] = attitude[j]);
    }
    let mut covariance = SMatrix::zeros();
    for _ in 0..STEPS {
        let r = residuals(stations, &x);
        let mut j = SMatrix::<f64, ROWS, UNKNOWNS>::zeros();
        for k in 0..UNKNOWNS {
            let step = 1e-5;
            let with = |by: f64| {
                let mut x = x;
                x[k] += by;
                residuals(stations, &x)
            };
            j.set_column(k, &((with(step) - with(-step)) / (2.0 * step)));
        }
        covariance = (j.transpose() * j).cholesky().unwrap().inverse();
        x -= covariance * (j.transpose() * r);
    }
    (x, covariance)
}

#[test]
fn errors_azimuths_and_their_sigmas_are_those_of_the_whole_problem_in_double_precision() {
    let (mut compared, mut worst) = (0, [0.0_f64; 3]);
    for seed in 0..12 {
        let drawn = Run { stations: STATIONS, ..Run::default() }.drawn(1_000 + seed);
        let stations: Vec<Station> = drawn.stations.iter().map(|truth| truth.station).collect();
        let mut all = MultiStation::new();
        stations.iter().for_each(|station| all.push(*station).unwrap());
        // Corrected however uncertain that is: what is compared is the arithmetic.
        let settings = MultiStationSettings { harm_deviations: 0.0, ..MultiStationSettings::default() };
        let report = all.analyse(&SurveyErrors::default(), &settings).unwrap();
        let estimates = report.estimates();
        let priors = Parameter::ALL.map(|p| p.prior_sigma(&SurveyErrors::default(), &MultiStationSettings::default()));
        let widened = estimates.iter().zip(priors).any(|(estimate, prior)| estimate.prior_sigma > prior);
        if report.left_out != 0 || report.noise_ratio > 1.0 || widened {
            continue;
        }
        let attitudes: Vec<[f64; 3]> = (drawn.stations.iter())
            .map(|truth| {
                let [x, y, _] = truth.station.force_m_s2.map(f64::from);
                [truth.inclination_rad, truth.azimuth_rad, libm::atan2(-y, x)]
            })
            .collect();
        let (x, covariance) = solved(&stations, &attitudes);
        compared += 1;
        for (k, estimate) in estimates.iter().enumerate() {
            let prior = f64::from(estimate.prior_sigma);
            worst[0] = worst[0].max((f64::from(estimate.estimate.value) / prior - x[k]).abs());
            let sigma = libm::sqrt(covariance[(k, k)]);
            worst[1] = worst[1].max((f64::from(estimate.estimate.sigma) / prior - sigma).abs());
        }
        if report.azimuth == meerkat_mwd::survey::multi_station::Decision::Corrected {
            for (k, station) in stations.iter().enumerate().filter(|(k, _)| drawn.stations[*k].inclination_rad > 0.1) {
                let ours = f64::from(report.corrected(station).unwrap().magnetic_azimuth_rad.value);
                // The whole problem's azimuth is smoothed by the reference, too; it is within the noise's sigma of
                // ours.
                let off = libm::remainder(ours - x[PARAMETERS + 5 * k + 1], std::f64::consts::TAU).abs();
                worst[2] = worst[2].max(off.to_degrees());
            }
        }
    }
    println!(
        "compared {compared}; worst difference of errors {:.4} and sigmas {:.4} of a prior sigma, azimuths {:.4} deg",
        worst[0], worst[1], worst[2]
    );
    assert!(compared >= 6 && worst[2] > 0.0, "{compared} {worst:?}");
    assert!(worst[0] < 0.02 && worst[1] < 0.01 && worst[2] < 0.2, "{worst:?}");
}
