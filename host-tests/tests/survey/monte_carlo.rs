//! Sensors with errors at the level of the ISCWSA MWD error model: how far surveys are off, and whether their
//! sigmas say so.

use std::f64::consts::TAU;

use meerkat_mwd::{
    config::SurveyConfig,
    survey::{Grade, Uncertain},
};

use crate::tool::{Draw, Place, Tool};

const SEEDS: u64 = 100;
const INCLINATIONS_DEG: [f64; 6] = [3.0, 10.0, 30.0, 50.0, 70.0, 90.0];
const AZIMUTHS_DEG: [f64; 4] = [0.0, 30.0, 60.0, 90.0];
/// Below this east component of the tool axis the drill string's field, which an east-west level tool has
/// wholly in its azimuth, is in it by less than half.
const EASTWARD: f64 = 0.45;
/// Round figures of total field and dip at high and at middle latitude.
const NORTH_SEA: Place = Place { name: "North Sea", field_ut: 50.0, dip_deg: 72.0 };
const GULF: Place = Place { name: "Gulf of Mexico", field_ut: 48.0, dip_deg: 58.0 };

/// Squares and hits of one quantity.
#[derive(Clone, Copy, Default)]
struct Tally {
    square: f64,
    stated: f64,
    within: u32,
    count: u32,
}

impl Tally {
    fn add(&mut self, error: f64, sigma: f32) {
        let sigma = f64::from(sigma);
        self.square += error * error;
        self.stated += sigma * sigma;
        self.within += u32::from(error.abs() <= sigma);
        self.count += 1;
    }

    fn rms_deg(&self) -> f64 {
        (self.square / f64::from(self.count)).sqrt().to_degrees()
    }

    fn stated_deg(&self) -> f64 {
        (self.stated / f64::from(self.count)).sqrt().to_degrees()
    }

    fn share(&self) -> f64 {
        f64::from(self.within) / f64::from(self.count)
    }
}

fn off(measured: Uncertain, truth: f64) -> f64 {
    libm::remainder(f64::from(measured.value) - truth, TAU)
}

#[derive(Default)]
struct Place100 {
    /// By inclination, then azimuth.
    azimuth: [[Tally; 4]; 6],
    inclination: [Tally; 6],
    /// Inclination, magnetic azimuth, gravity toolface, magnetic toolface, true azimuth.
    pooled: [Tally; 5],
    good: u32,
    bad: u32,
    all: u32,
}

/// Surveys of 100 tools at every attitude, in a random quadrant and at a random toolface.
fn surveyed(place: &Place, config: &SurveyConfig) -> Place100 {
    let mut result = Place100::default();
    for seed in 0..SEEDS {
        let mut draw = Draw::new(seed);
        let tool = Tool::drawn(&mut draw, &config.errors, place);
        for (i, inclination_deg) in INCLINATIONS_DEG.into_iter().enumerate() {
            for (a, from_north_deg) in AZIMUTHS_DEG.into_iter().enumerate() {
                let azimuth_deg = match (draw.uniform() * 4.0) as u8 {
                    0 => from_north_deg,
                    1 => 180.0 - from_north_deg,
                    2 => 180.0 + from_north_deg,
                    _ => 360.0 - from_north_deg,
                };
                let [inclination, azimuth] = [inclination_deg, azimuth_deg].map(f64::to_radians);
                let toolface = TAU * draw.uniform();
                let report = tool.survey([inclination, azimuth, toolface], place, config, &mut draw);
                let survey = report.survey;
                let quantities = [
                    (survey.inclination_rad, inclination),
                    (survey.magnetic_azimuth_rad.unwrap(), azimuth),
                    (survey.gravity_toolface_rad.unwrap(), toolface),
                    (survey.magnetic_toolface_rad.unwrap(), azimuth + toolface),
                    (survey.true_azimuth_rad.unwrap(), azimuth + tool.declination_rad),
                ];
                for (tally, (measured, truth)) in result.pooled.iter_mut().zip(quantities) {
                    tally.add(off(measured, truth), measured.sigma);
                }
                result.inclination[i].add(off(quantities[0].0, inclination), quantities[0].0.sigma);
                result.azimuth[i][a].add(off(quantities[1].0, azimuth), quantities[1].0.sigma);
                result.good += u32::from(report.quality.grade == Grade::Good);
                result.bad += u32::from(report.quality.grade == Grade::Bad);
                result.all += 1;
            }
        }
    }
    result
}

fn print(place: &Place, terms: &str, result: &Place100) {
    println!("{}, {terms}: error rms (stated), deg, over {SEEDS} tools", place.name);
    println!("  inclination   of inclination    of magnetic azimuth at 0, 30, 60, 90 deg from the meridian");
    for (i, inclination_deg) in INCLINATIONS_DEG.into_iter().enumerate() {
        let cell = |tally: &Tally| format!("{:.3} ({:.3})", tally.rms_deg(), tally.stated_deg());
        let cells: Vec<_> = result.azimuth[i].iter().map(cell).collect();
        println!("  {inclination_deg:>11}   {}     {}", cell(&result.inclination[i]), cells.join("  "));
    }
    let names = ["inclination", "magnetic azimuth", "gravity toolface", "magnetic toolface", "true azimuth"];
    let shares: Vec<_> = names
        .iter()
        .zip(&result.pooled)
        .map(|(name, tally)| format!("{name} {:.1} %", 100.0 * tally.share()))
        .collect();
    println!("  within one sigma: {}", shares.join(", "));
    println!("  graded good {} bad {} of {}", result.good, result.bad, result.all);
}

#[test]
fn surveys_are_as_good_as_the_error_model_and_say_so() {
    let mut config = SurveyConfig { settle_s: 0.1, ..SurveyConfig::default() };
    config.limits.propagated = true;
    for place in [GULF, NORTH_SEA] {
        let result = surveyed(&place, &config);
        print(&place, "all terms", &result);
        for (tally, i) in result.inclination.iter().zip(INCLINATIONS_DEG) {
            assert!(tally.rms_deg() < 0.1, "inclination at {i}");
        }
        for (row, inclination_deg) in result.azimuth.iter().zip(INCLINATIONS_DEG) {
            for (tally, from_north_deg) in row.iter().zip(AZIMUTHS_DEG) {
                let eastward = inclination_deg.to_radians().sin() * from_north_deg.to_radians().sin();
                if inclination_deg >= 10.0 && eastward < EASTWARD {
                    assert!(
                        tally.rms_deg() < 0.5,
                        "azimuth at {inclination_deg}, {from_north_deg}: {}",
                        tally.rms_deg()
                    );
                }
            }
        }
        // Three checks within two deviations each, and beyond three.
        assert!((0.80..0.93).contains(&(f64::from(result.good) / f64::from(result.all))), "{}", result.good);
        assert!(result.bad * 50 < result.all, "{}", result.bad);
        for tally in &result.pooled {
            assert!((0.60..=0.76).contains(&tally.share()), "{}", tally.share());
        }
    }
}

/// Field of the drill string along the axis: it is no error of a sensor. A survey in which it has been corrected, or
/// which is far enough from the drill string, is as good as this.
#[test]
fn without_the_drill_strings_field_the_azimuth_is_within_half_a_degree_everywhere() {
    let mut config = SurveyConfig { settle_s: 0.1, ..SurveyConfig::default() };
    config.limits.propagated = true;
    config.errors.axial_interference_ut = 0.0;
    for place in [GULF, NORTH_SEA] {
        let result = surveyed(&place, &config);
        print(&place, "sensor terms only", &result);
        for (row, inclination_deg) in result.azimuth.iter().zip(INCLINATIONS_DEG) {
            for (tally, from_north_deg) in row.iter().zip(AZIMUTHS_DEG) {
                let rms_deg = tally.rms_deg();
                assert!(inclination_deg < 10.0 || rms_deg < 0.5, "{inclination_deg}, {from_north_deg}: {rms_deg}");
            }
        }
        for tally in &result.pooled {
            assert!((0.60..=0.76).contains(&tally.share()), "{}", tally.share());
        }
    }
}
