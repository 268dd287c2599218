//! Simulated runs with known truth: azimuths before and after the multi-station analysis, and what it says of itself.

use meerkat_mwd::config::SurveyErrors;
use mwd::{
    bench::multi_station::{Score, scored},
    surveys::simulated_run::Run,
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
