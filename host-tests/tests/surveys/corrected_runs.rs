//! Simulated runs with known truth: azimuths before and after the multi-station analysis, and what it says of itself.

use meerkat_mwd::{
    config::SurveyErrors,
    survey::multi_station::{MultiStation, MultiStationReport, MultiStationSettings, Parameter, Station},
};
use mwd::{
    bench::multi_station::{Score, scored},
    surveys::simulated_run::{Run, TrueStation},
};

const RUNS: u64 = 500;

fn scores(run: &Run) -> Vec<Score> {
    (0..RUNS).map(|seed| scored(run, seed).unwrap()).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    libm::sqrt(sum / count)
}

#[test]
fn in_specification_azimuths_get_better_and_under_one_run_in_a_hundred_worse() {
    let scores = scores(&Run::default());
    let [before, after] = [0, 1].map(|k| rms(scores.iter().map(|score| score.azimuth_deg[k])));
    let worse = scores.iter().filter(|score| score.azimuth_deg[1] > score.azimuth_deg[0]).count();
    println!("azimuth, deg rms: {before:.3} before, {after:.3} after; worse in {worse} of {RUNS} runs");
    assert!(after < 0.75 * before, "{before} {after}");
    assert!(worse * 100 < scores.len(), "{worse}");
    let [inclination_before, inclination_after] = [0, 1].map(|k| rms(scores.iter().map(|s| s.inclination_deg[k])));
    assert!(inclination_after < inclination_before);
}

#[test]
fn the_stated_sigma_covers_the_error() {
    let scores = scores(&Run::default());
    let [one, two, all] = [0, 1, 2].map(|k| scores.iter().map(|score| score.within[k]).sum::<f64>());
    // Errors of a run go together, so that 500 runs leave some 2 % of uncertainty.
    assert!((0.60..0.74).contains(&(one / all)) && (0.93..0.98).contains(&(two / all)), "{} {}", one / all, two / all);
    let stated = libm::sqrt(scores.iter().map(|score| score.stated[1]).sum::<f64>() / all);
    let after = rms(scores.iter().map(|score| score.azimuth_deg[1]));
    assert!((0.85..1.15).contains(&(after / stated)), "{after} {stated}");
}

#[test]
fn a_magnetised_string_and_a_magnetometer_out_of_specification_are_corrected() {
    let errors = SurveyErrors::default();
    let magnetised = SurveyErrors { axial_interference_ut: 5.0 * errors.axial_interference_ut, ..errors };
    let biased = SurveyErrors { mag_bias_ut: 4.0 * errors.mag_bias_ut, ..errors };
    for (errors, share) in [(magnetised, 0.2), (biased, 0.4)] {
        let scores = scores(&Run { errors, ..Run::default() });
        let [before, after] = [0, 1].map(|k| rms(scores.iter().map(|score| score.azimuth_deg[k])));
        let worse = scores.iter().filter(|score| score.azimuth_deg[1] > score.azimuth_deg[0]).count();
        assert!(after < share * before && worse * 100 < scores.len(), "{before} {after} {worse}");
    }
}

/// There the string's field and its growth pass for each other, and hardly show.
#[test]
fn level_to_the_east_a_magnetised_string_makes_under_one_run_in_a_hundred_worse() {
    let errors = SurveyErrors::default();
    let magnetised = SurveyErrors { axial_interference_ut: 5.0 * errors.axial_interference_ut, ..errors };
    for errors in [errors, magnetised] {
        let scores = scores(&Run { errors, level_to_the_east: true, ..Run::default() });
        let worse = scores.iter().filter(|score| score.azimuth_deg[1] > score.azimuth_deg[0]).count();
        assert!(worse * 100 < scores.len(), "{worse}");
    }
}

/// Growth of the drill string's field from the first to the last station of a run, microtesla.
const GROWTH_UT: f64 = 1.5;

fn analysed(stations: impl Iterator<Item = Station>) -> MultiStationReport {
    let mut all = MultiStation::new();
    stations.for_each(|station| all.push(station).unwrap());
    all.analyse(&SurveyErrors::default(), &MultiStationSettings::default()).unwrap()
}

/// The sigma of a station's azimuth by a report, degrees.
fn sigma_deg(report: &MultiStationReport, station: &Station) -> f64 {
    f64::from(report.corrected(station).unwrap().magnetic_azimuth_rad.sigma).to_degrees()
}

#[test]
fn a_field_that_grows_is_found_within_its_sigma_and_the_azimuths_sigma_grows_with_it() {
    let growth = Parameter::ALL.iter().position(|parameter| *parameter == Parameter::AxialGrowth).unwrap();
    let (mut off, mut told, mut within) = (vec![], 0, 0);
    let (mut errors, mut sigmas) = ([vec![], vec![]], [const { Vec::new() }; 2]);
    let runs = 200;
    for seed in 0..runs {
        let drawn = Run::default().drawn(seed);
        let last = drawn.stations.len() - 1;
        let with = |k: usize, truth: &TrueStation, by: f64| {
            let mut station = truth.station;
            station.field_ut[2] += (by * k as f64 / last as f64) as f32;
            station
        };
        let run = |by: f64| analysed(drawn.stations.iter().enumerate().map(|(k, truth)| with(k, truth, by)));
        let [without, grown] = [run(0.0), run(GROWTH_UT)];
        let estimate = grown.estimates()[growth].estimate;
        let truth = drawn.errors[growth] + GROWTH_UT;
        off.push((f64::from(estimate.value) - truth) / f64::from(estimate.sigma));
        told += i32::from(grown.axial_field_grows());
        let end = with(last, &drawn.stations[last], GROWTH_UT);
        let station = grown.corrected(&end).unwrap();
        let azimuth = drawn.stations[last].azimuth_rad;
        for (errors, x) in errors.iter_mut().zip([station.measured_azimuth_rad, station.magnetic_azimuth_rad]) {
            errors.push(libm::remainder(f64::from(x.value) - azimuth, std::f64::consts::TAU).to_degrees());
        }
        within += i32::from(errors[1].last().unwrap().abs() < 2.0 * sigma_deg(&grown, &end));
        // The same attitude as far below the run as the run is long: the growth goes on, and is not known from there.
        for (sigmas, (report, by)) in sigmas.iter_mut().zip([(&without, 0.0), (&grown, GROWTH_UT)]) {
            let end = with(last, &drawn.stations[last], by);
            let mut below = with(last, &drawn.stations[last], 2.0 * by);
            below.depth_m += end.depth_m - drawn.stations[0].station.depth_m;
            let more = sigma_deg(report, &below).powi(2) - sigma_deg(report, &end).powi(2);
            sigmas.push(more);
        }
    }
    let [before, after] = errors.map(|errors| rms(errors.into_iter()));
    let in_sigmas = rms(off.iter().copied());
    let [staying, growing] = sigmas.map(|more| libm::sqrt(more.iter().sum::<f64>() / more.len() as f64));
    println!(
        "growth of 1,500 nT: told in {told} of {runs} runs, error {in_sigmas:.2} sigmas rms; last azimuth {before:.2} deg rms \
         before, {after:.2} after, {within} within two sigmas; over as much hole again its sigma grows by {growing:.2} deg, \
         without a growth by {staying:.2}"
    );
    assert!(told as u64 * 100 >= runs * 95 && (0.7..1.3).contains(&in_sigmas), "{told} {in_sigmas}");
    assert!(after < 0.5 * before && within as u64 * 100 >= runs * 90, "{before} {after} {within}");
    assert!(growing > 0.3 && growing > 1.3 * staying, "{growing} {staying}");
}
