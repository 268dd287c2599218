#![allow(clippy::indexing_slicing)]
use super::{rows::Scales, *};
use crate::survey::station_axes::Axes;
use nalgebra::{Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const REFERENCE: StationReference = StationReference { gravity_m_s2: 9.81, field_ut: 50.0, dip_rad: 1.2 };

fn uniform(generator: &mut Xoshiro128PlusPlus) -> f32 {
    generator.next_u32() as f32 / u32::MAX as f32
}

/// Station at an attitude (inclination, azimuth, toolface, radians) with errors added to what is read.
fn station(
    [inclination, azimuth, toolface]: [f32; 3],
    depth_m: f32,
    errors: impl Fn(Vector3<f32>, Vector3<f32>) -> [Vector3<f32>; 2],
) -> Station {
    let tool_to_ned = Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), inclination)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), toolface);
    let (sine, cosine) = libm::sincosf(REFERENCE.dip_rad);
    let field = Vector3::new(cosine, 0.0, sine) * REFERENCE.field_ut;
    let force = Vector3::new(0.0, 0.0, -REFERENCE.gravity_m_s2);
    let [force, field] = errors(tool_to_ned.inverse() * force, tool_to_ned.inverse() * field);
    Station { depth_m, force_m_s2: force.into(), field_ut: field.into(), reference: REFERENCE }
}

fn exact(force: Vector3<f32>, field: Vector3<f32>) -> [Vector3<f32>; 2] {
    [force, field]
}

fn analysed(stations: &[Station]) -> MultiStationReport {
    let mut all = MultiStation::new();
    for station in stations {
        all.push(*station).unwrap();
    }
    all.analyse(&SurveyErrors::default(), &MultiStationSettings::default()).unwrap()
}

#[test]
fn angles_and_their_gradients_are_those_of_small_changes() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
    for _ in 0..200 {
        let attitude =
            [0.2 + 2.7 * uniform(&mut generator), 6.2 * uniform(&mut generator), 6.2 * uniform(&mut generator)];
        let s = station(attitude, 0.0, exact);
        let axes = s.axes().unwrap();
        let off = |a: f32, b: f32| libm::fabsf(libm::remainderf(a - b, core::f32::consts::TAU));
        assert!(off(axes.inclination_rad(), attitude[0]) < 1e-5 && off(axes.azimuth_rad(), attitude[1]) < 2e-5);
        assert!(off(axes.dip_rad, REFERENCE.dip_rad) < 2e-6);
        let (force, field) = (Vector3::from(s.force_m_s2), Vector3::from(s.field_ut));
        let gradients = [axes.azimuth_gradient(), axes.inclination_gradient(), axes.dip_gradient()];
        let values = |axes: Axes| [axes.azimuth_rad(), axes.inclination_rad(), axes.dip_rad];
        for k in 0..3 {
            let change = Vector3::ith(k, 0.02);
            let both = |df: Vector3<f32>, db: Vector3<f32>| {
                let up = values(Axes::of(&(force + df), &(field + db)).unwrap());
                let down = values(Axes::of(&(force - df), &(field - db)).unwrap());
                core::array::from_fn::<f32, 3, _>(|i| libm::remainderf(up[i] - down[i], core::f32::consts::TAU) / 0.04)
            };
            let (by_force, by_field) = (both(change, Vector3::zeros()), both(Vector3::zeros(), change));
            for i in 0..3 {
                // Tolerance: rounding of some 1e-6 rad in a difference of angles, over the step of 0.04.
                let tolerance = 3e-4 + 2e-3 * libm::fabsf(by_force[i]);
                assert!(libm::fabsf(by_force[i] - gradients[i].force[k]) < tolerance, "{i} {k} {attitude:?}");
                assert!(libm::fabsf(by_field[i] - gradients[i].field[k]) < 3e-4, "{i} {k} {attitude:?}");
            }
        }
    }
}

#[test]
fn a_stations_rows_are_the_derivatives_of_its_residuals() {
    let (errors, settings) = (SurveyErrors::default(), MultiStationSettings::default());
    let prior = Parameter::ALL.map(|parameter| parameter.prior_sigma(&errors, &settings));
    let scales = Scales { prior, settings, noise: 1.3, run: [100.0, 1_000.0] };
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(8);
    for _ in 0..50 {
        let attitude = [0.2 + uniform(&mut generator), 6.2 * uniform(&mut generator), 6.2 * uniform(&mut generator)];
        let s = station(attitude, 700.0, exact);
        let at: [f32; PARAMETERS] = core::array::from_fn(|_| 2.0 * uniform(&mut generator) - 1.0);
        let derivative = scales.rows(&s, &at).unwrap().derivative;
        for k in 0..PARAMETERS {
            let with = |by: f32| {
                let mut x = at;
                x[k] += by;
                scales.rows(&s, &x).unwrap().residual
            };
            let (up, down) = (with(1.0), with(-1.0));
            for i in 0..3 {
                let difference = (up[i] - down[i]) / 2.0;
                assert!(libm::fabsf(difference - derivative[i][k]) < 6e-3, "{i} {k}: {difference} {:?}", derivative[i]);
            }
        }
    }
}

#[test]
fn a_roll_test_determines_the_transverse_biases_and_not_the_axial_ones() {
    let offset = |force: Vector3<f32>, field: Vector3<f32>| {
        [force + Vector3::new(0.03, -0.02, 0.0), field + Vector3::new(0.4, -0.6, 0.3)]
    };
    let stations: [Station; 12] =
        core::array::from_fn(|k| station([1.1, 0.7, 0.1 + k as f32 * core::f32::consts::TAU / 12.0], 500.0, offset));
    let report = analysed(&stations);
    let estimates = report.estimates();
    let of = |parameter| *estimates.iter().find(|estimate| estimate.parameter == parameter).unwrap();
    for (parameter, truth) in [
        (Parameter::AccelBias(0), 0.03),
        (Parameter::AccelBias(1), -0.02),
        (Parameter::MagBias(0), 0.4),
        (Parameter::MagBias(1), -0.6),
    ] {
        let Estimate { estimate, observable, .. } = of(parameter);
        // The prior shrinks an error that is so far beyond it, by a tenth at the stated noise.
        let off = libm::fabsf(estimate.value - truth);
        assert!(observable && off < 0.15 * libm::fabsf(truth), "{parameter:?} {estimate:?}");
    }
    for parameter in [Parameter::AccelBias(2), Parameter::AxialGrowth, Parameter::MagScale(2)] {
        assert!(!of(parameter).observable, "{parameter:?}");
    }
    assert!(libm::fabsf(report.correlation(2, 13)) < 1.0 && libm::fabsf(report.correlation(3, 3) - 1.0) < 1e-5);
}

#[test]
fn exact_stations_are_not_corrected_and_one_bad_station_is_left_out() {
    let attitude = |k: usize| [0.3 + 0.04 * k as f32, 0.5 + 0.02 * k as f32, 1.7 * k as f32];
    let mut stations: [Station; 20] = core::array::from_fn(|k| station(attitude(k), 30.0 * k as f32, exact));
    let report = analysed(&stations);
    assert_eq!(report.azimuth, Decision::Refused(Refusal::NotCertain));
    assert_eq!((report.left_out, report.counted), (0, 20));
    stations[7].field_ut[0] += 2.0;
    let report = analysed(&stations);
    assert_eq!((report.left_out, report.counted), (1 << 7, 19));
}

#[test]
fn stations_without_rhyme_are_refused_as_a_contradiction() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(9);
    let stations: [Station; 20] = core::array::from_fn(|k| {
        let by = Vector3::from_fn(|_, _| 6.0 * uniform(&mut generator) - 3.0);
        station([0.5, 0.2 + 0.1 * k as f32, k as f32], 30.0 * k as f32, |force, field| [force, field + by])
    });
    let report = analysed(&stations);
    assert_eq!(report.azimuth, Decision::Refused(Refusal::Contradiction));
    assert!(report.noise_ratio > 9.0);
}

/// Stations without errors in common, only with noise: what is estimated from the others is noise, too, and a left-out
/// station is predicted better without it.
#[test]
fn errors_that_are_noise_alone_are_refused_by_leaving_stations_out() {
    let settings = MultiStationSettings { harm_deviations: 0.0, ..MultiStationSettings::default() };
    let mut refused = 0;
    for seed in 0..20 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(100 + seed);
        // Its variance is 1.
        let mut noise = || 3.464 * (uniform(&mut generator) - 0.5);
        let mut all = MultiStation::new();
        for k in 0..12 {
            let attitude = [0.4 + 0.06 * k as f32, 0.5 + 0.02 * k as f32, 1.7 * k as f32];
            let [df, db] = [settings.force_noise_m_s2, settings.field_noise_ut]
                .map(|sigma| Vector3::from_fn(|_, _| sigma * noise()));
            all.push(station(attitude, 30.0 * k as f32, |force, field| [force + df, field + db])).unwrap();
        }
        let report = all.analyse(&SurveyErrors::default(), &settings).unwrap();
        let left_out = Decision::Refused(Refusal::PredictsWorse);
        assert_eq!(report.azimuth == left_out, report.residual_left_out > report.residual_uncorrected);
        if report.azimuth != left_out {
            assert_eq!(report.azimuth, Decision::Corrected);
            continue;
        }
        refused += 1;
        assert_eq!(report.inclination, left_out);
        // As measured, with the sigma of the priors.
        let corrected = report.corrected(&all.stations()[5]).unwrap();
        assert_eq!(corrected.magnetic_azimuth_rad, corrected.measured_azimuth_rad);
        assert_eq!(corrected.inclination_rad, corrected.measured_inclination_rad);
    }
    assert!(refused >= 5, "{refused}");
}

#[test]
fn what_cannot_be_used_is_handed_back_and_too_few_are_not_analysed() {
    let mut all = MultiStation::new();
    let sound = station([0.5, 1.0, 2.0], 0.0, exact);
    for (force, field) in [([f32::NAN; 3], sound.field_ut), (sound.force_m_s2, [0.0; 3])] {
        assert!(all.push(Station { force_m_s2: force, field_ut: field, ..sound }).is_err());
    }
    let settings = MultiStationSettings::default();
    for _ in 0..LEAST_STATIONS - 1 {
        all.push(sound).unwrap();
    }
    assert!(all.analyse(&SurveyErrors::default(), &settings).is_none());
    for _ in LEAST_STATIONS - 1..MAX_STATIONS {
        all.push(sound).unwrap();
    }
    assert!(all.push(sound).is_err() && all.stations().len() == MAX_STATIONS);
    assert!(all.analyse(&SurveyErrors::default(), &settings).is_some());
    let nothing = SurveyErrors { mag_bias_ut: 0.0, ..SurveyErrors::default() };
    assert!(all.analyse(&nothing, &settings).is_none());
}

/// At the vertical the azimuth is not known, and the inclination as badly as anywhere: neither sigma goes to nothing.
#[test]
fn at_the_vertical_the_sigmas_stay() {
    let at = |inclination_deg: f32| {
        let stations: [Station; 8] = core::array::from_fn(|k| {
            station([inclination_deg.to_radians(), 0.3, 0.8 * k as f32], 30.0 * k as f32, exact)
        });
        let report = analysed(&stations);
        stations.map(|station| report.corrected(&station).unwrap())
    };
    for corrected in at(0.01) {
        assert!(corrected.magnetic_azimuth_rad.sigma > 1.0, "{corrected:?}");
    }
    for corrected in at(0.0) {
        assert!(corrected.inclination_rad.sigma > 3e-4 && corrected.magnetic_azimuth_rad.sigma > 1.0, "{corrected:?}");
    }
}
