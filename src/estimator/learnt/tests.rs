use super::*;
use crate::config::VectorErrors;

#[test]
fn every_number_has_a_place_of_its_own() {
    extern crate std;
    let mut places: std::vec::Vec<_> = (0..NUMBERS).map(|k| place(k).unwrap()).collect();
    assert_eq!(place(NUMBERS), None);
    assert_eq!((places[0], places[GLOBALS], places[NUMBERS - 1]), ((0, 37), (0, 0), (36, 36)));
    assert!(places.iter().all(|(row, column)| row <= column));
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), NUMBERS);
}

#[test]
fn a_fingerprint_is_another_one_for_every_part_of_the_configuration_that_counts() {
    let plain = Config::default();
    let name = LearntHead::fingerprint(&plain);
    let other = |change: &dyn Fn(&mut Config)| {
        let mut config = plain;
        change(&mut config);
        LearntHead::fingerprint(&config) != name
    };
    assert!(other(&|c| c.identification.motion = crate::config::Motion::Hand));
    assert!(other(&|c| c.identification.prior_sigma_diagonal = 0.05));
    assert!(other(&|c| c.gyro.p[1][2] = 1e-6));
    assert!(other(&|c| c.accel.offset[0] = 1e-3));
    assert!(other(&|c| c.mag.matrix[2][0] = 1e-3));
    assert!(other(&|c| c.accel.matrix[1][0] = 1e-3));
    assert!(other(&|c| c.mag.offset[1] = 1e-3));
    assert!(other(&|c| c.gyro.b_rad_s[2] = 1e-6));
    assert!(other(&|c| c.latency.gyro_s = Some(0.001)));
    assert!(other(&|c| c.latency.accel_s = Some(0.001)));
    assert!(other(&|c| c.latency.mag_s = Some(0.001)));
    assert!(other(&|c| c.identification.prior_sigma_off_diagonal = 0.05));
    assert!(other(&|c| c.identification.prior_sigma_bias_rad_s = 0.1));
    assert!(other(&|c| c.identification.vectors_from_reference = true));
    let errors: [fn(&mut VectorErrors) -> &mut f32; 6] = [
        |errors| &mut errors.mag_matrix,
        |errors| &mut errors.hard_iron,
        |errors| &mut errors.mag_lag_s,
        |errors| &mut errors.accel_matrix,
        |errors| &mut errors.accel_bias_m_s2,
        |errors| &mut errors.accel_lag_s,
    ];
    for (k, of) in errors.into_iter().enumerate() {
        assert!(other(&|c| *of(&mut c.identification.vector_errors) *= 1.5), "error {k}");
    }
    assert!(other(&|c| c.earth.gravity_m_s2 = 9.81));
    assert!(other(&|c| c.sample_period_us = 4_000));
    assert!(!other(&|c| c.seed = 7));
}
